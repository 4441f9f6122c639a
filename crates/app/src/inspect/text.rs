//! The report as text: an overview, a table of motions, and a table of trees, the largest meshes
//! first.

use std::cmp::Reverse;

use super::{ClipFigures, Inspection, MeshFigures};
use crate::figures::{self, bytes, count};
use crate::table::Table;
use crate::trees::TreeFigures;

/// The columns of the table of trees. The last one is the result of `validate`.
const COLUMNS: [&str; 12] = [
    "tree",
    "motion",
    "triangles",
    "instances",
    "all bytes",
    "drift",
    "tree bytes",
    "nodes",
    "depth",
    "cost",
    "overlap",
    "promises",
];

/// The most animations that are named.
const MOST_CLIPS: usize = 20;

impl Inspection {
    /// The report with at most `shown` meshes.
    pub(super) fn text(&self, shown: usize) -> String {
        let mut lines = self.overview();
        lines.push(String::new());
        lines.extend(self.motion_table().lines());
        lines.push(String::new());
        lines.extend(self.mesh_table(shown).lines());
        let more = self.meshes.len().saturating_sub(shown);
        if more > 0 {
            lines.push(format!("  … {more} more (--all lists them)"));
        }
        lines.join("\n")
    }

    fn overview(&self) -> Vec<String> {
        let scene = &self.scene;
        let meshes = figures::of(scene.meshes as u64, "mesh", "meshes");
        let instances = figures::of(scene.instances as u64, "instance", "instances");
        let motion = if scene.duration_s > 0.0 {
            format!("repeats after {:.3} s", scene.duration_s)
        } else {
            "nothing moves".to_owned()
        };
        let names: Vec<String> = self.cameras.iter().map(|name| format!("{name:?}")).collect();
        let label = |(number, clip): (usize, &ClipFigures)| {
            let name = clip.name.as_ref().map(|name| format!(" {name:?}")).unwrap_or_default();
            format!("{number}{name}{}", if clip.is_played { "" } else { " (not played)" })
        };
        let mut clips: Vec<String> = self.clips.iter().enumerate().take(MOST_CLIPS).map(label).collect();
        if let Some(more) = self.clips.len().checked_sub(MOST_CLIPS).filter(|&more| more > 0) {
            clips.push(format!("… {more} more"));
        }
        let clips = if clips.is_empty() { "none".to_owned() } else { clips.join(", ") };
        let cameras = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        let light = if scene.has_default_lighting { ", light by default" } else { "" };
        let appearance = [
            figures::of(self.appearance.materials as u64, "material", "materials"),
            figures::of(self.appearance.textures as u64, "texture", "textures"),
            figures::of(self.appearance.lights as u64, "light", "lights"),
        ];
        let peak = self.memory.process_peak.map(|peak| format!(", {} process peak", bytes(peak)));
        let build = self.first_commit.total_ms.map(|ms| format!(", first commit {ms:.1} ms"));
        let loaded = match self.first_commit.loaded {
            0 => String::new(),
            loaded => format!(", {} from a file", figures::of(loaded as u64, "tree", "trees")),
        };
        let mut lines = vec![
            scene.name.clone(),
            format!("  time       {:.3} s, {motion}", self.time_s),
            format!("  meshes     {meshes}, {}", figures::of(scene.triangles, "triangle", "triangles")),
            format!("  instances  {instances}, {}", figures::of(scene.instanced_triangles, "triangle", "triangles")),
            format!("  appearance {}{light}", appearance.join(", ")),
            format!("  cameras    {cameras}"),
            format!("  clips      {clips}"),
            format!(
                "  memory     {} trees and geometry, {} textures{}",
                bytes(self.memory.scene),
                bytes(self.memory.textures),
                peak.unwrap_or_default()
            ),
            format!("  load       {:.1} ms{}{loaded}", self.load_ms, build.unwrap_or_default()),
        ];
        if self.commit.left_out > 0 {
            let left_out = figures::of(self.commit.left_out as u64, "instance", "instances");
            lines.push(format!("  left out   {left_out} whose placement is flat along two axes or overflows"));
        }
        lines
    }

    fn motion_table(&self) -> Table {
        let mut table = Table::new(&["motion", "meshes", "triangles", "instances", "instanced triangles"]);
        for motion in self.motions.iter().filter(|motion| motion.meshes > 0) {
            table.row([
                motion.motion.to_owned(),
                count(motion.meshes as u64),
                count(motion.triangles),
                count(motion.instances as u64),
                count(motion.instanced_triangles),
            ]);
        }
        table
    }

    /// The top level, and at most `shown` meshes.
    fn mesh_table(&self, shown: usize) -> Table {
        let mut table = Table::new(&COLUMNS);
        let size = bytes(self.top_level.bytes as u64);
        let name = ["top level".to_owned(), dash(), dash(), count(self.scene.instances as u64), size, dash()];
        table.row(name.into_iter().chain(tree_cells(&self.top_level)));

        let mut by_size: Vec<&MeshFigures> = self.meshes.iter().collect();
        by_size.sort_by_key(|mesh| (Reverse(mesh.bytes()), mesh.number));
        for mesh in by_size.into_iter().take(shown) {
            let name = format!("mesh {}", mesh.number);
            let [triangles, instances] = [mesh.triangles, mesh.instances].map(|number| count(number as u64));
            let (size, drift) = (bytes(mesh.bytes() as u64), format!("{:.2}", mesh.drift));
            let name = [name, mesh.seen.motion.to_owned(), triangles, instances, size, drift];
            table.row(name.into_iter().chain(tree_cells(&mesh.seen.tree)));
        }
        table
    }
}

fn dash() -> String {
    "-".to_owned()
}

fn tree_cells(tree: &TreeFigures) -> [String; 6] {
    [
        bytes(tree.bytes as u64),
        count(tree.nodes as u64),
        tree.depth.to_string(),
        format!("{:.1}", tree.cost),
        format!("{:.2}", tree.overlap),
        tree.violation.clone().unwrap_or_else(|| "kept".to_owned()),
    ]
}
