//! Everything that belongs to one frame.

use std::sync::Arc;

use super::mesh::VertexNormals;
use super::mesh_state::MeshState;
use super::published::Published;
use super::report::FrameReport;
use super::slots::Slots;
use crate::geometry::{Aabb, Affine};
use crate::handle::{InstanceId, MeshId};
use crate::traverse::FrameBvh;

/// A frame: what rays are traced against, and what hits are resolved with.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    pub(crate) world: FrameBvh,
    /// Those of the meshes of `world`, by slot, where they have any. Apart from them, because
    /// normals change without their trees.
    pub(crate) normals: Vec<Option<FrameNormals>>,
    /// One per instance record.
    pub(crate) placed: Vec<PlacedInstance>,
    /// World boxes, one per instance record.
    pub(crate) boxes: Vec<Aabb>,
    pub(crate) report: FrameReport,
    /// By slot, the mesh to whose ring the buffer in `world.meshes` belongs; `None` if clones share
    /// it.
    pub(crate) owners: Vec<Option<MeshId>>,
    /// For a copy, the frame whose buffers it shares, which has to be held as long. Dropped last.
    #[expect(dead_code, reason = "it is held, not read")]
    pub(crate) original: Option<Published<Self>>,
}

/// Normals for shading, of one mesh.
#[derive(Debug, Clone)]
pub(crate) struct FrameNormals {
    /// The mesh to whose ring the buffer belongs; `None` if clones share it.
    pub(crate) owner: Option<MeshId>,
    pub(crate) normals: Arc<VertexNormals>,
}

/// The data of an instance that tracing does not need.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedInstance {
    pub(crate) id: InstanceId,
    /// Index of its mesh in the report of the frame.
    pub(crate) mesh: u32,
    pub(crate) world_from_object: Affine,
}

impl Frame {
    /// The normals of the mesh in this slot, one per vertex; empty if it has none.
    pub(crate) fn normals_of(&self, slot: u32) -> &[[f32; 3]] {
        self.normals.get(slot as usize).and_then(Option::as_ref).map_or(&[], |of| &of.normals)
    }

    /// Gives the buffers of meshes back to the rings that they belong to.
    pub(crate) fn release_meshes(&mut self, meshes: &mut Slots<MeshState>) {
        for (owner, frame) in self.owners.drain(..).zip(self.world.meshes.drain(..)) {
            if let Some(Ok(mesh)) = owner.map(|id| meshes.get_mut(id.0)) {
                mesh.frames.release(frame);
            }
        }
        for FrameNormals { owner, normals } in self.normals.drain(..).flatten() {
            if let Some(Ok(mesh)) = owner.map(|id| meshes.get_mut(id.0)) {
                mesh.normals.release(normals);
            }
        }
    }
}
