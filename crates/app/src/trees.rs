//! Figures of trees and of commits.

use kinetree::tree::Violation;
use kinetree::wide::WideBvh;
use kinetree::{Action, FrameReport, MeshBvh, Motion, TopLevelBvh};
use serde::Serialize;

use crate::figures::millis;

/// All motions with their names.
pub(crate) const MOTIONS: [(Motion, &str); 4] = [
    (Motion::Static, "static"),
    (Motion::Rigid, "rigid"),
    (Motion::Deforming, "deforming"),
    (Motion::Dynamic, "dynamic"),
];

/// The name of a motion.
pub(crate) fn name_of(motion: Motion) -> &'static str {
    MOTIONS.iter().find(|(other, _)| *other == motion).map_or("", |&(_, name)| name)
}

/// Figures of one tree.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct TreeFigures {
    pub(crate) nodes: usize,
    pub(crate) bytes: usize,
    pub(crate) depth: usize,
    /// The expected cost of a ray that hits the root, in visits of nodes and tests of leaf items
    /// (blocks of four triangles, or instances).
    pub(crate) cost: f32,
    /// Summed area of the intersections of sibling boxes, over the root's.
    pub(crate) overlap: f32,
    pub(crate) valid: bool,
    /// The first promise that is broken, and where.
    pub(crate) violation: Option<String>,
}

impl TreeFigures {
    pub(crate) fn of_mesh(mesh: &MeshBvh) -> Self {
        Self::new(mesh.tree(), mesh.heap_bytes(), mesh.validate())
    }

    pub(crate) fn of_top_level(top: &TopLevelBvh) -> Self {
        Self::new(top.tree(), top.heap_bytes(), top.validate())
    }

    fn new(tree: &WideBvh, bytes: usize, validated: Result<(), Violation>) -> Self {
        let violation = validated.err().map(|violation| violation.to_string());
        Self {
            nodes: tree.node_count(),
            bytes,
            depth: tree.depth(),
            cost: tree.cost(1.0, 1.0),
            overlap: tree.overlap(),
            valid: violation.is_none(),
            violation,
        }
    }
}

/// Figures of one commit. Times are missing where there is no clock.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct CommitFigures {
    pub(crate) number: u64,
    pub(crate) total_ms: Option<f64>,
    pub(crate) mesh_ms: Option<f64>,
    pub(crate) top_level_ms: Option<f64>,
    pub(crate) built: usize,
    /// Trees that were taken from a file.
    pub(crate) loaded: usize,
    pub(crate) rebuilt: usize,
    pub(crate) refitted: usize,
    pub(crate) kept: usize,
    pub(crate) top_level: String,
    pub(crate) top_level_cost: f32,
    pub(crate) instances: usize,
    pub(crate) left_out: usize,
    pub(crate) triangles: usize,
    pub(crate) worst_drift: f32,
    pub(crate) buffers_allocated: usize,
    pub(crate) memory_bytes: usize,
}

impl CommitFigures {
    pub(crate) fn of(report: &FrameReport) -> Self {
        Self {
            number: report.frame,
            total_ms: report.total_time.map(millis),
            mesh_ms: report.mesh_time.map(millis),
            top_level_ms: report.top_level.time.map(millis),
            built: report.count(Action::Built),
            loaded: report.count(Action::Loaded),
            rebuilt: report.count(Action::Rebuilt),
            refitted: report.count(Action::Refitted),
            kept: report.count(Action::Kept),
            top_level: report.top_level.method.to_string(),
            top_level_cost: report.top_level.cost,
            instances: report.top_level.instances,
            left_out: report.left_out.len(),
            triangles: report.triangles(),
            worst_drift: report.meshes.iter().fold(1.0, |worst, mesh| worst.max(mesh.drift)),
            buffers_allocated: report.allocated,
            memory_bytes: report.memory,
        }
    }
}
