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

/// A frame: what rays are traced against, and whom hits belong to.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    pub(crate) world: FrameBvh,
    /// Of the meshes of `world`, where they have any. Apart from them, because normals change
    /// without their trees.
    pub(crate) normals: Vec<Option<FrameNormals>>,
    /// One per instance record.
    pub(crate) placed: Vec<PlacedInstance>,
    /// World boxes, one per instance record.
    pub(crate) boxes: Vec<Aabb>,
    pub(crate) report: FrameReport,
    /// Whose buffers `world.meshes` holds; of none that clones share.
    pub(crate) owners: Vec<Option<MeshId>>,
    /// Of a copy: the frame whose buffers it shares, which has to be held as long. Dropped last.
    #[expect(dead_code, reason = "it is held, not read")]
    pub(crate) original: Option<Published<Self>>,
}

/// Normals for shading, of one mesh.
#[derive(Debug, Clone)]
pub(crate) struct FrameNormals {
    /// Whose buffer it is; nobody's if clones share it.
    pub(crate) owner: Option<MeshId>,
    pub(crate) normals: Arc<VertexNormals>,
}

/// What tracing does not need to know about an instance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedInstance {
    pub(crate) id: InstanceId,
    /// Index of its mesh in the report of the frame.
    pub(crate) mesh: u32,
    pub(crate) world_from_object: Affine,
}

impl Frame {
    /// Of the mesh in this slot, one per vertex, or none at all.
    pub(crate) fn normals_of(&self, slot: u32) -> &[[f32; 3]] {
        self.normals.get(slot as usize).and_then(Option::as_ref).map_or(&[], |of| &of.normals)
    }

    /// Gives the buffers of meshes back to the rings that they are from.
    pub(crate) fn release_meshes(&mut self, meshes: &mut Slots<MeshState>) {
        for (owner, posed) in self.owners.drain(..).zip(self.world.meshes.drain(..)) {
            if let Some(Ok(mesh)) = owner.map(|id| meshes.get_mut(id.0)) {
                mesh.release(posed);
            }
        }
        for FrameNormals { owner, normals } in self.normals.drain(..).flatten() {
            if let Some(Ok(mesh)) = owner.map(|id| meshes.get_mut(id.0)) {
                mesh.release_normals(normals);
            }
        }
    }
}
