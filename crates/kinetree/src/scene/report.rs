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
    /// Counts from one.
    pub frame: u64,
    /// Every mesh, in the order in which they were added.
    pub meshes: Vec<MeshReport>,
    /// What became of the tree over the instances.
    pub top_level: TopLevelReport,
    /// Instances whose placement is flat along two or three axes (scale zero, for instance) or overflows. No ray sees them.
    pub left_out: Vec<InstanceId>,
    /// How many buffers had to be allocated, because all others were held by snapshots or did not exist yet.
    pub allocated: usize,
    /// Bytes held by the scene for trees and posed geometry, all buffers counted.
    pub memory: usize,
    /// Posing, refitting and building of all meshes.
    pub mesh_time: Option<Duration>,
    /// The whole commit.
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
    /// How much more work a ray is than through a good tree for the same pose, as a ratio. Of a tree that was rebuilt for it
    /// ([`Reason::Drifted`], [`Reason::BetterTreeFound`]): the drift that caused it, and from the next commit on that of the new tree. Estimated by
    /// the expected costs of rays, and found by a comparison where there was one. As it was last where the pose has no area, and 1
    /// where nothing is known yet.
    pub drift: f32,
    /// A tree was built to compare the refitted one with; its build is part of `tree_time`. The better one was kept.
    pub compared: bool,
    /// A new buffer was needed.
    pub allocated: bool,
    /// Morph targets, skin, copying.
    pub pose_time: Option<Duration>,
    /// Refit or build.
    pub tree_time: Option<Duration>,
}

/// How the tree over the instances came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum TopLevelMethod {
    /// Nothing had moved.
    #[default]
    Kept,
    /// Agglomerative clustering (Walter et al. 2008).
    Clustered,
    /// Binned, because there are many.
    Binned,
}

/// What became of the tree over the instances.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TopLevelReport {
    /// How it came about.
    pub method: TopLevelMethod,
    /// Instances in the tree.
    pub instances: usize,
    /// Expected cost of a ray, in nodes and instances.
    pub cost: f32,
    /// Transforms, inverses, boxes and the tree.
    pub time: Option<Duration>,
}

impl FrameReport {
    /// How many meshes had this done to them.
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
