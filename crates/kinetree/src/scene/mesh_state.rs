//! A mesh in a scene: what it was handed over as, its settings, its edits since the last commit,
//! and its buffers. `mesh_commit` brings it up to date.

use std::collections::HashSet;
use std::sync::Arc;

use super::error::EditError;
use super::input::Positions;
use super::mesh::{Mesh, MeshData, VertexNormals};
use super::mesh_edits::{GeometryEdit, MeshEdits, Vertices};
use super::pose::OwnedPose;
use super::ring::{Buffer, Ring};
use crate::build::Quality;
use crate::geometry::Precision;
use crate::threads::Threads;
use crate::traverse::MeshFrame;
use crate::update::{Motion, Upkeep};

#[derive(Debug)]
pub(crate) struct MeshState {
    pub(super) mesh: Mesh,
    pub(super) motion: Motion,
    /// Instead of the quality that the motion suggests.
    pub(super) chosen_quality: Option<Quality>,
    pub(super) precision: Precision,
    /// How many instances there are.
    pub(crate) instances: usize,
    pub(super) edits: MeshEdits,
    /// Memory for the positions that are given next.
    pub(super) positions_buffer: Vec<[f32; 3]>,
    /// Vertices and trees. Shared by clones of the mesh: the rest pose.
    pub(super) frames: Ring<MeshFrame>,
    /// Apart from the vertices, since normals change without their tree. Shared by clones: those
    /// that the mesh was handed over with.
    pub(super) normals: Ring<VertexNormals>,
    pub(super) tree: TreeHistory,
}

/// What is known about the current tree.
#[derive(Debug)]
pub(super) struct TreeHistory {
    /// What it was built with. Baked trees count as the best, since that is not known of them.
    pub(super) quality: Quality,
    pub(super) upkeep: Upkeep,
    /// As reports say it.
    pub(super) drift: f32,
}

impl MeshState {
    pub(crate) fn new(mesh: Mesh, motion: Motion) -> Self {
        let &MeshData { quality, precision, .. } = &**mesh.data();
        Self {
            mesh,
            motion,
            chosen_quality: quality,
            precision,
            instances: 0,
            edits: MeshEdits::ADDED,
            positions_buffer: Vec::new(),
            frames: Ring::default(),
            normals: Ring::default(),
            tree: TreeHistory { quality: Quality::Fastest, upkeep: Upkeep::of_build(None), drift: 1.0 },
        }
    }

    pub(crate) fn data(&self) -> &Arc<MeshData> {
        self.mesh.data()
    }

    pub(crate) fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    pub(crate) fn motion(&self) -> Motion {
        self.motion
    }

    pub(crate) fn precision(&self) -> Precision {
        self.precision
    }

    /// The quality of the next build.
    pub(crate) fn quality(&self) -> Quality {
        self.chosen_quality.unwrap_or(match self.motion {
            Motion::Static => Quality::Balanced,
            Motion::Rigid | Motion::Deforming => Quality::Fast,
            Motion::Dynamic => Quality::Fastest,
        })
    }

    /// # Errors
    /// There is a tree already, or the bytes are none of this mesh.
    pub(crate) fn set_tree(&mut self, tree: &[u8]) -> Result<(), EditError> {
        if !self.edits.geometry.is_replaced() {
            return Err(EditError::HasTree);
        }
        self.mesh = self.mesh.clone().with_tree(tree)?;
        Ok(())
    }

    /// # Errors
    /// Another number of positions, or some that are not finite; then nothing has changed.
    pub(crate) fn set_positions(&mut self, positions: Positions<'_>) -> Result<(), EditError> {
        positions.write_into(&mut self.positions_buffer)?;
        let (expected, found) = (self.data().positions.len(), self.positions_buffer.len());
        if found != expected {
            return Err(EditError::PositionCountChanged { expected, found });
        }
        let given = Vertices::Positions(std::mem::take(&mut self.positions_buffer));
        if let Some(Vertices::Positions(unused)) = self.edits.geometry.set(given) {
            self.positions_buffer = unused;
        }
        Ok(())
    }

    pub(crate) fn set_normals(&mut self, normals: VertexNormals) {
        self.edits.normals = Some(normals);
    }

    pub(crate) fn pose(&mut self, pose: OwnedPose) {
        self.edits.geometry.set(Vertices::Pose(pose));
    }

    pub(crate) fn rebuild(&mut self) {
        self.edits.rebuild = true;
    }

    pub(crate) fn set_motion(&mut self, motion: Motion) {
        self.edits.motion |= motion != self.motion;
        self.motion = motion;
    }

    pub(crate) fn set_quality(&mut self, quality: Option<Quality>) {
        self.chosen_quality = quality;
    }

    pub(crate) fn set_precision(&mut self, precision: Precision) {
        self.precision = precision;
    }

    /// Other triangles; what was edited of the old ones is dropped.
    pub(crate) fn replace(&mut self, mesh: Mesh) {
        self.mesh = mesh;
        self.edits.geometry = GeometryEdit::Replaced(None);
        self.edits.normals = None;
    }

    /// Bytes held, those of buffers that snapshots still hold included. What clones share is
    /// counted once: `counted` remembers its addresses.
    pub(crate) fn heap_bytes(&self, counted: &mut HashSet<*const ()>) -> usize {
        let own = self.frames.heap_bytes() + self.normals.heap_bytes();
        let shared = self.frames.shared().map(|frame| (Arc::as_ptr(frame).cast::<()>(), frame.heap_bytes()));
        let shared_normals = self.normals.shared().map(|normals| (Arc::as_ptr(normals).cast(), normals.heap_bytes()));
        let of_refits = self.frames.current().and_then(|current| current.bvh.refit_plan());
        let all = [shared, shared_normals, of_refits].into_iter().flatten();
        let once = all.filter(|&(address, _)| counted.insert(address));
        own + once.map(|(_, bytes)| bytes).sum::<usize>() + self.positions_buffer.capacity() * size_of::<[f32; 3]>()
    }

    /// Whether the next commit takes the tree of the rest pose that clones of the mesh share: where
    /// they stay at rest, or are posed from it.
    pub(super) fn shares_first_build(&self) -> bool {
        let is_from_rest = match self.edits.geometry.vertices() {
            None => true,
            Some(Vertices::Pose(_)) => self.motion == Motion::Deforming,
            Some(Vertices::Positions(_)) => false,
        };
        is_from_rest
            && !self.mesh.has_tree()
            && self.frames.current().is_none()
            && self.precision == self.data().precision
            && Arc::strong_count(self.data()) > 1
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
