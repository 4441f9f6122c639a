//! The geometry of a mesh of the file, and the library's meshes made of it.

use kinetree::{Mesh, MeshError, MorphTarget, Skin};
use kinetree_world::Surface;

/// A mesh of the file. Always: all arrays that are there have one element per vertex, and indices
/// are in range.
pub(crate) struct Geometry {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Option<Vec<[f32; 3]>>,
    /// The vertices from here on belong to triangles that have no normals in the file: they are
    /// flat in every pose.
    pub(crate) flat_from: usize,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) skin: Option<Skin>,
    /// As many as [`Document::target_count`](crate::document::Document::target_count) says.
    pub(crate) targets: Vec<MorphTarget>,
    pub(crate) surface: Surface,
}

impl Geometry {
    /// The mesh in its rest state, or as one that can be posed; then normals of flat triangles are
    /// zero.
    pub(crate) fn mesh(&self, skinned: bool, morphed: bool) -> Result<Mesh, MeshError> {
        let mut mesh = Mesh::new(&self.positions, &self.triangles)?;
        if let Some(normals) = &self.normals {
            let flat_from = if skinned || morphed { self.flat_from } else { normals.len() };
            let mut normals = normals.clone();
            // A normal of the rest pose is wrong in other poses: zero stands for the normal of the
            // triangle.
            normals[flat_from..].fill([0.0; 3]);
            mesh = mesh.with_normals(&normals)?;
        }
        if let Some(skin) = self.skin.as_ref().filter(|_| skinned) {
            mesh = mesh.with_skin(skin.clone())?;
        }
        if morphed {
            mesh = mesh.with_morph_targets(self.targets.clone())?;
        }
        Ok(mesh)
    }

    /// The highest joint that any vertex follows.
    pub(crate) fn highest_joint(&self) -> Option<u16> {
        self.skin.as_ref()?.joints.iter().flatten().copied().max()
    }

    /// How many numbers a copy of it holds.
    pub(crate) fn numbers(&self) -> u64 {
        let per_vertex = 6 + 8 * u64::from(self.skin.is_some()) + 6 * self.targets.len() as u64;
        self.positions.len() as u64 * per_vertex + 3 * self.triangles.len() as u64
    }
}
