//! What a commit did, why, and how long it took.

use std::fmt;
use std::time::Duration;

use crate::handle::{InstanceId, MeshId};
use crate::update::{Action, Motion, Reason};

/// What a commit did. Durations are `None` where there is no clock.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FrameReport {
    /// The number of the commit in its scene, from 1.
    pub frame: u64,
    /// Every mesh, in the order in which they were added.
    pub meshes: Vec<MeshReport>,
    /// The tree over the instances.
    pub top_level: TopLevelReport,
    /// Instances whose placement is flat along two or three axes (such as scale zero) or overflows.
    /// No ray hits them.
    pub left_out: Vec<InstanceId>,
    /// How many buffers were allocated, because all others were held by snapshots or did not exist
    /// yet.
    pub allocated: usize,
    /// Bytes held by the scene for trees and posed geometry, all buffers counted.
    pub memory: usize,
    /// Time for posing, refitting and building all meshes.
    pub mesh_time: Option<Duration>,
    /// Time for the whole commit.
    pub total_time: Option<Duration>,
}

/// What a commit did with one mesh.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeshReport {
    /// The mesh.
    pub mesh: MeshId,
    /// How it was announced to move.
    pub motion: Motion,
    /// What the commit did.
    pub action: Action,
    /// Why it did so.
    pub reason: Reason,
    /// How many triangles the mesh has now.
    pub triangles: usize,
    /// The expected cost of a ray through this tree over that through a good tree for the same
    /// pose. Estimated by the expected cost, and found by a comparison where there was one. If the
    /// drift caused a rebuild ([`Reason::Drifted`], [`Reason::BetterTreeFound`]), this is the drift
    /// of the old tree; the next report gives that of the new one. If the pose has no area, the
    /// last value; 1 if nothing is known yet.
    pub drift: f32,
    /// Whether a second tree was built to compare the refitted one with; its build is part of
    /// `tree_time`. The better one was kept.
    pub compared: bool,
    /// Whether a buffer was allocated.
    pub allocated: bool,
    /// Time for morph targets, skin and copying of vertices.
    pub pose_time: Option<Duration>,
    /// Time for the refit or build.
    pub tree_time: Option<Duration>,
}

/// How the tree over the instances was built.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum TopLevelMethod {
    /// It is that of the last frame: no box has changed.
    #[default]
    Kept,
    /// Agglomerative clustering (Walter et al. 2008).
    Clustered,
    /// Binned, because there are many.
    Binned,
}

/// The tree over the instances.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TopLevelReport {
    /// How it was built.
    pub method: TopLevelMethod,
    /// Instances in the tree.
    pub instances: usize,
    /// Expected cost of a ray, in nodes and instances.
    pub cost: f32,
    /// Time for transforms, inverses, boxes and the tree.
    pub time: Option<Duration>,
}

impl FrameReport {
    /// The number of meshes with this action.
    pub fn count(&self, action: Action) -> usize {
        self.meshes.iter().filter(|mesh| mesh.action == action).count()
    }

    /// Triangles of all meshes, each mesh counted once.
    pub fn triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.triangles).sum()
    }
}

/// A duration in milliseconds, or a dash where there is no clock.
struct Millis(Option<Duration>);

impl fmt::Display for Millis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(time) => write!(f, "{:.2} ms", time.as_secs_f64() * 1e3),
            None => f.write_str("- ms"),
        }
    }
}

impl fmt::Display for TopLevelMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Kept => "kept",
            Self::Clustered => "clustered",
            Self::Binned => "binned",
        })
    }
}

impl fmt::Display for FrameReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [built, loaded, rebuilt, refitted, kept] =
            [Action::Built, Action::Loaded, Action::Rebuilt, Action::Refitted, Action::Kept]
                .map(|action| self.count(action));
        writeln!(f, "frame {}: {} in all", self.frame, Millis(self.total_time))?;
        writeln!(
            f,
            "  meshes     {built} built, {loaded} loaded, {rebuilt} rebuilt, {refitted} refitted, {kept} kept in {}",
            Millis(self.mesh_time)
        )?;
        writeln!(
            f,
            "  top level  {} over {} instances in {}, cost {:.1}",
            self.top_level.method,
            self.top_level.instances,
            Millis(self.top_level.time),
            self.top_level.cost
        )?;
        write!(f, "  memory     {:.1} MB, {} buffers allocated", self.memory as f64 / 1e6, self.allocated)?;
        if !self.left_out.is_empty() {
            write!(
                f,
                "\n  left out   {} instances whose placement is flat along two axes or overflows",
                self.left_out.len()
            )?;
        }
        for mesh in self.meshes.iter().filter(|mesh| mesh.action == Action::Rebuilt && mesh.compared) {
            let MeshReport { triangles, drift, .. } = mesh;
            write!(f, "\n  drifted    a mesh of {triangles} triangles was rebuilt at drift {drift:.2}")?;
        }
        Ok(())
    }
}
