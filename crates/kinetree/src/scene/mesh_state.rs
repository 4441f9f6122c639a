//! A mesh in a scene: its edits since the last commit, and its buffers. `mesh_commit` brings it up
//! to date.

use std::collections::HashSet;
use std::sync::Arc;

use super::Mesh;
use super::error::EditError;
use super::frame::FrameNormals;
use super::input::Positions;
use super::mesh::{MeshData, VertexNormals};
use super::pose::OwnedPose;
use super::ring::{Buffer, Ring};
use crate::build::Quality;
use crate::handle::MeshId;
use crate::threads::Threads;
use crate::traverse::MeshFrame;
use crate::update::{Edit, Motion, Upkeep};

#[derive(Debug)]
pub(crate) struct MeshState {
    pub(super) mesh: Mesh,
    pub(crate) motion: Motion,
    /// How many instances there are.
    pub(crate) instances: usize,
    pub(super) edit: Edit,
    pub(super) geometry: Geometry,
    /// Normals that were set since the last commit.
    pub(super) normals: Option<Vec<[f32; 3]>>,
    /// Memory for the positions that are given next.
    pub(super) room: Vec<[f32; 3]>,
    pub(super) ring: Ring<MeshFrame>,
    /// Current instead of what is in the ring: vertices at rest and their tree, which clones share.
    pub(super) shared: Option<Arc<MeshFrame>>,
    /// Apart from the vertices: normals never touch a tree.
    pub(super) normal_ring: Ring<VertexNormals>,
    pub(super) shared_normals: Option<Arc<VertexNormals>>,
    /// Whether the caller asked for a new tree.
    pub(super) rebuild: bool,
    pub(super) upkeep: Upkeep,
    pub(super) drift: f32,
}

/// Where the vertices go with the next commit.
#[derive(Debug)]
pub(super) enum Geometry {
    /// They stay.
    Unchanged,
    Positions(Vec<[f32; 3]>),
    Pose(OwnedPose),
}

impl MeshState {
    pub(crate) fn new(mesh: Mesh, motion: Motion) -> Self {
        Self {
            mesh,
            motion,
            instances: 0,
            edit: Edit::Triangles,
            geometry: Geometry::Unchanged,
            normals: None,
            room: Vec::new(),
            ring: Ring::default(),
            shared: None,
            normal_ring: Ring::default(),
            shared_normals: None,
            rebuild: false,
            upkeep: Upkeep::of_build(None),
            drift: 1.0,
        }
    }

    pub(crate) fn data(&self) -> &Arc<MeshData> {
        self.mesh.data()
    }

    pub(crate) fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// # Errors
    /// There is a tree already, or the bytes are none of this mesh.
    pub(crate) fn set_tree(&mut self, tree: &[u8]) -> Result<(), EditError> {
        if self.edit != Edit::Triangles {
            return Err(EditError::HasTree);
        }
        self.mesh = self.mesh.clone().with_tree(tree)?;
        Ok(())
    }

    /// # Errors
    /// Another number of positions, or some that are no positions; then nothing has changed.
    pub(crate) fn set_positions(&mut self, positions: Positions<'_>) -> Result<(), EditError> {
        positions.write_into(&mut self.room)?;
        let expected = self.data().positions.len();
        if self.room.len() != expected {
            return Err(EditError::PositionCountChanged { expected, found: self.room.len() });
        }
        let given = Geometry::Positions(std::mem::take(&mut self.room));
        if let Geometry::Positions(never_used) = std::mem::replace(&mut self.geometry, given) {
            self.room = never_used;
        }
        self.edit = self.edit.or_positions();
        Ok(())
    }

    pub(crate) fn set_normals(&mut self, normals: Vec<[f32; 3]>) {
        self.normals = Some(normals);
    }

    pub(crate) fn pose(&mut self, pose: OwnedPose) {
        self.geometry = Geometry::Pose(pose);
        self.edit = self.edit.or_positions();
    }

    pub(crate) fn rebuild(&mut self) {
        self.rebuild = true;
    }

    pub(crate) fn replace(&mut self, mesh: Mesh) {
        self.mesh = mesh;
        self.geometry = Geometry::Unchanged;
        self.normals = None;
        self.edit = Edit::Triangles;
    }

    /// As of the last commit.
    pub(crate) fn current(&self) -> Option<&Arc<MeshFrame>> {
        self.shared.as_ref().or(self.ring.current())
    }

    /// Whether that is a buffer of this mesh alone.
    pub(crate) fn owns_current(&self) -> bool {
        self.shared.is_none()
    }

    /// As of the last commit, if there are any.
    pub(crate) fn current_normals(&self, id: MeshId) -> Option<FrameNormals> {
        let shared = self.shared_normals.as_ref();
        let owner = shared.is_none().then_some(id);
        let normals = shared.or(self.normal_ring.current()).filter(|normals| !normals.is_empty());
        normals.map(|normals| FrameNormals { owner, normals: normals.clone() })
    }

    /// Takes back a buffer that a frame held.
    pub(crate) fn release(&mut self, posed: Arc<MeshFrame>) {
        self.ring.release(posed);
    }

    /// Takes back normals that a frame held.
    pub(crate) fn release_normals(&mut self, normals: Arc<VertexNormals>) {
        self.normal_ring.release(normals);
    }

    /// Bytes held, those of buffers that wait for their snapshots included. What clones share is
    /// counted once: `counted` remembers.
    pub(crate) fn heap_bytes(&self, counted: &mut HashSet<*const ()>) -> usize {
        let own = self.ring.heap_bytes() + self.normal_ring.heap_bytes();
        let shared = self.shared.iter().map(|posed| (Arc::as_ptr(posed).cast::<()>(), posed.heap_bytes()));
        let shared_normals =
            self.shared_normals.iter().map(|normals| (Arc::as_ptr(normals).cast(), normals.heap_bytes()));
        let of_refits = self.current().and_then(|current| current.bvh.refit_plan());
        let once = shared.chain(shared_normals).chain(of_refits).filter(|&(place, _)| counted.insert(place));
        own + once.map(|(_, bytes)| bytes).sum::<usize>() + self.room.capacity() * size_of::<[f32; 3]>()
    }

    pub(super) fn quality(&self) -> Quality {
        self.data().quality.unwrap_or(match self.motion {
            Motion::Static => Quality::Balanced,
            Motion::Rigid | Motion::Deforming => Quality::Fast,
            Motion::Dynamic => Quality::Fastest,
        })
    }

    /// Clones of a mesh share the tree of the rest pose: where they stay at rest, or are posed from
    /// it.
    pub(super) fn shares_first_build(&self) -> bool {
        let from_rest = match self.geometry {
            Geometry::Unchanged => true,
            Geometry::Pose(_) => self.motion == Motion::Deforming,
            Geometry::Positions(_) => false,
        };
        from_rest && !self.mesh.has_tree() && self.current().is_none() && Arc::strong_count(self.data()) > 1
    }

    /// Builds the tree of the rest pose that clones share, before they are brought up to date side
    /// by side.
    pub(crate) fn prepare_first_build(&self, threads: &Threads) {
        if self.shares_first_build() {
            self.mesh.prepare_first_build(self.quality(), threads);
        }
    }
}

impl Buffer for MeshFrame {
    fn heap_bytes(&self) -> usize {
        self.bvh.heap_bytes() + self.triangles.heap_bytes()
    }
}

impl Buffer for VertexNormals {
    fn heap_bytes(&self) -> usize {
        self.capacity() * size_of::<[f32; 3]>()
    }
}

impl Edit {
    /// Positions moved, too.
    fn or_positions(self) -> Self {
        if self == Self::Nothing { Self::Positions } else { self }
    }
}
