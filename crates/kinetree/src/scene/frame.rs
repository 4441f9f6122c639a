//! Everything that belongs to one frame.

use super::report::FrameReport;
use crate::geometry::{Aabb, Affine};
use crate::handle::{InstanceId, MeshId};
use crate::traverse::TwoLevel;
use crate::update::Motion;

/// A frame: what rays are traced against, and whom hits belong to.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    pub(crate) world: TwoLevel,
    /// One per instance record.
    pub(crate) placed: Vec<PlacedInstance>,
    /// World boxes, one per instance record.
    pub(crate) boxes: Vec<Aabb>,
    pub(crate) report: FrameReport,
}

/// What tracing does not need to know about an instance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedInstance {
    pub(crate) id: InstanceId,
    pub(crate) mesh: MeshId,
    pub(crate) motion: Motion,
    pub(crate) world_from_object: Affine,
}

impl Frame {
    /// Lets go of meshes that only this frame still holds on to.
    pub(crate) fn release_meshes(&mut self) {
        self.world.meshes.clear();
    }
}
