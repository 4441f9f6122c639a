//! Everything that belongs to one frame.

use super::living_mesh::LivingMesh;
use super::published::Published;
use super::report::FrameReport;
use super::slots::Slots;
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
    /// Whose buffers `world.meshes` holds, if anybody's.
    pub(crate) owners: Vec<Option<MeshId>>,
    /// Of a copy: the frame whose buffers it shares, which has to be held as long. Dropped last.
    #[expect(dead_code, reason = "it is held, not read")]
    pub(crate) original: Option<Published<Self>>,
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
    /// Gives the buffers of meshes back to the rings that they are from.
    pub(crate) fn release_meshes(&mut self, meshes: &mut Slots<LivingMesh>) {
        for (owner, posed) in self.owners.drain(..).zip(self.world.meshes.drain(..)) {
            if let Some(Ok(mesh)) = owner.map(|id| meshes.get_mut(id.0)) {
                mesh.release(posed);
            }
        }
    }
}
