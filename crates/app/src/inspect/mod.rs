//! `kinetree inspect`: what a scene consists of, what its trees are like, and whether they keep their promises.

mod text;

use std::collections::HashMap;

use kinetree::{MeshId, Motion, Snapshot};
use kinetree_gltf::ClipInfo;
use kinetree_render::Frame;
use serde::Serialize;

use crate::args::{Common, InspectArgs};
use crate::failure::Failure;
use crate::figures::{self, millis};
use crate::output::{remark, report};
use crate::scene;
use crate::summary::{MemoryFigures, SceneFigures};
use crate::trees::{CommitFigures, MOTIONS, TreeFigures, name_of};

/// Prints what there is to say, and fails if any tree is not valid.
pub(crate) fn run(args: &InspectArgs, common: &Common) -> Result<(), Failure> {
    let mut opened = scene::open(args.scene.as_deref(), args.clip.as_ref(), args.trees.as_deref())?;
    if !common.quiet {
        opened.notes.iter().for_each(|note| remark(&format!("{}: {note}", opened.name)));
    }
    let frame = opened.frame(args.time)?;
    let duration = opened.world.motion.duration();
    let meshes = meshes(&frame.view);
    let inspection = Inspection {
        scene: SceneFigures::of(&opened.name, duration, &frame, opened.has_default_lighting, &opened.notes),
        time_s: args.time,
        load_ms: millis(opened.load_time),
        first_commit: CommitFigures::of(&opened.first_commit),
        commit: CommitFigures::of(frame.view.report()),
        memory: MemoryFigures::of(frame.view.report(), &frame.look),
        look: LookFigures::of(&frame),
        cameras: opened.world.cameras.iter().map(|source| source.name.clone()).collect(),
        clips: opened.clips.iter().map(ClipFigures::of).collect(),
        motions: MOTIONS.map(|(motion, name)| MotionFigures::of(&meshes, motion, name)).into(),
        top_level: TreeFigures::of_top_level(frame.view.top_level()),
        meshes,
    };
    report(&inspection, || inspection.text(if args.all { usize::MAX } else { SHOWN }), common, false)?;
    inspection.verdict()
}

/// How many meshes a table shows unless all are asked for.
const SHOWN: usize = 20;

/// Everything about a scene at one moment.
#[derive(Debug, Serialize)]
struct Inspection {
    scene: SceneFigures,
    time_s: f64,
    load_ms: f64,
    first_commit: CommitFigures,
    commit: CommitFigures,
    memory: MemoryFigures,
    look: LookFigures,
    cameras: Vec<String>,
    clips: Vec<ClipFigures>,
    motions: Vec<MotionFigures>,
    top_level: TreeFigures,
    meshes: Vec<MeshFigures>,
}

/// What the scene looks like, in numbers.
#[derive(Debug, Serialize)]
struct LookFigures {
    materials: usize,
    textures: usize,
    lights: usize,
}

/// An animation of the file.
#[derive(Debug, Serialize)]
struct ClipFigures {
    name: Option<String>,
    is_played: bool,
}

impl ClipFigures {
    fn of(clip: &ClipInfo) -> Self {
        Self { name: clip.name.clone(), is_played: clip.is_played }
    }
}

/// Meshes that move in the same manner. A mesh that is not in the frame is counted nowhere.
#[derive(Debug, Serialize)]
struct MotionFigures {
    motion: &'static str,
    meshes: usize,
    triangles: u64,
    instances: usize,
    instanced_triangles: u64,
}

/// One mesh.
#[derive(Debug, Serialize)]
struct MeshFigures {
    /// In the order in which the meshes came into the scene, from 0.
    number: usize,
    triangles: usize,
    /// Instances in the frame.
    instances: usize,
    action: String,
    reason: String,
    drift: f32,
    /// Missing when no instance of it is in the frame: there is no way to its tree then.
    seen: Option<SeenMesh>,
}

/// What is known of a mesh that is in the frame.
#[derive(Debug, Serialize)]
struct SeenMesh {
    motion: &'static str,
    #[serde(skip)]
    kind: Motion,
    vertices: usize,
    /// Positions, normals and vertex numbers.
    geometry_bytes: usize,
    tree: TreeFigures,
}

impl MeshFigures {
    fn bytes(&self) -> usize {
        self.seen.as_ref().map_or(0, |seen| seen.geometry_bytes + seen.tree.bytes)
    }
}

fn meshes(view: &Snapshot) -> Vec<MeshFigures> {
    // Looked up only, never gone through: its order is not always the same.
    let mut of_mesh: HashMap<MeshId, (u32, usize)> = HashMap::new();
    for instance in view.instances() {
        of_mesh.entry(instance.mesh_id()).or_insert((instance.index(), 0)).1 += 1;
    }
    let figures = |(number, report): (usize, &kinetree::MeshReport)| {
        let shown = of_mesh.get(&report.mesh);
        MeshFigures {
            number,
            triangles: report.triangles,
            instances: shown.map_or(0, |&(_, instances)| instances),
            action: report.action.to_string(),
            reason: report.reason.to_string(),
            drift: report.drift,
            seen: shown.map(|&(first, _)| seen(&view.instance_at(first))),
        }
    };
    view.report().meshes.iter().enumerate().map(figures).collect()
}

fn seen(instance: &kinetree::InstanceView<'_>) -> SeenMesh {
    let kind = instance.motion();
    SeenMesh {
        motion: name_of(kind),
        kind,
        vertices: instance.positions().len(),
        geometry_bytes: size_of_val(instance.positions())
            + size_of_val(instance.normals().unwrap_or_default())
            + size_of_val(instance.triangles()),
        tree: TreeFigures::of_mesh(instance.bvh()),
    }
}

impl LookFigures {
    fn of(frame: &Frame) -> Self {
        let look = &frame.look;
        Self { materials: look.materials.len(), textures: look.textures.len(), lights: frame.lights.len() }
    }
}

impl MotionFigures {
    fn of(meshes: &[MeshFigures], kind: Motion, motion: &'static str) -> Self {
        let mut figures = Self { motion, meshes: 0, triangles: 0, instances: 0, instanced_triangles: 0 };
        for mesh in meshes.iter().filter(|mesh| mesh.seen.as_ref().is_some_and(|seen| seen.kind == kind)) {
            figures.meshes += 1;
            figures.triangles += mesh.triangles as u64;
            figures.instances += mesh.instances;
            figures.instanced_triangles += mesh.triangles as u64 * mesh.instances as u64;
        }
        figures
    }
}

impl Inspection {
    /// Fails with the first broken promise.
    fn verdict(&self) -> Result<(), Failure> {
        let top_level = self.top_level.violation.iter().map(|violation| format!("top level: {violation}"));
        let of_mesh = |mesh: &MeshFigures| {
            let violation = mesh.seen.as_ref()?.tree.violation.as_ref()?;
            Some(format!("mesh {}: {violation}", mesh.number))
        };
        let broken: Vec<String> = top_level.chain(self.meshes.iter().filter_map(of_mesh)).collect();
        match broken.first() {
            None => Ok(()),
            Some(first) => {
                let trees = figures::of(broken.len() as u64, "tree is", "trees are");
                Err(Failure::work(format!("{}: {trees} not valid: {first}", self.scene.name)))
            }
        }
    }
}
