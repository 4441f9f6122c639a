//! A mesh in a scene: its edits since the last commit, its buffers, and how its tree is kept.

use std::sync::Arc;

use super::Mesh;
use super::error::EditError;
use super::input::{Positions, all_finite};
use super::mesh::MeshData;
use super::pose::KeptPose;
use super::report::MeshReport;
use super::ring::{Buffer, Ring};
use crate::build::{self, BuildOptions, Quality};
use crate::clock::Clock;
use crate::geometry::Triangles;
use crate::handle::MeshId;
use crate::simd::Level;
use crate::threads::Threads;
use crate::traverse::Posed;
use crate::update::{Action, Candidate, Doubt, Edit, Motion, Reason, Upkeep, decide};
use crate::wide::WideMesh;

#[derive(Debug)]
pub(crate) struct LivingMesh {
    mesh: Mesh,
    pub(crate) motion: Motion,
    /// How many instances there are.
    pub(crate) instances: usize,
    edit: Edit,
    shape: Shape,
    normals: Option<Vec<[f32; 3]>>,
    /// Memory for the positions that are given next.
    room: Vec<[f32; 3]>,
    ring: Ring<Posed>,
    /// Whether the caller asked for a new tree.
    rebuild: bool,
    upkeep: Upkeep,
    drift: f32,
}

/// Where the vertices go with the next commit.
#[derive(Debug)]
enum Shape {
    /// They stay.
    Kept,
    Given(Vec<[f32; 3]>),
    Posed(KeptPose),
}

impl LivingMesh {
    pub(crate) fn new(mesh: Mesh, motion: Motion) -> Self {
        Self {
            mesh,
            motion,
            instances: 0,
            edit: Edit::Triangles,
            shape: Shape::Kept,
            normals: None,
            room: Vec::new(),
            ring: Ring::default(),
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
        let given = Shape::Given(std::mem::take(&mut self.room));
        if let Shape::Given(never_used) = std::mem::replace(&mut self.shape, given) {
            self.room = never_used;
        }
        self.edit = self.edit.or_positions();
        Ok(())
    }

    pub(crate) fn set_normals(&mut self, normals: Vec<[f32; 3]>) {
        self.normals = Some(normals);
        self.edit = self.edit.or_positions();
    }

    pub(crate) fn pose(&mut self, pose: KeptPose) {
        self.shape = Shape::Posed(pose);
        self.edit = self.edit.or_positions();
    }

    pub(crate) fn rebuild(&mut self) {
        self.rebuild = true;
    }

    pub(crate) fn replace(&mut self, mesh: Mesh) {
        self.mesh = mesh;
        self.shape = Shape::Kept;
        self.normals = None;
        self.edit = Edit::Triangles;
    }

    /// As of the last commit.
    pub(crate) fn current(&self) -> Option<&Arc<Posed>> {
        self.ring.current()
    }

    /// Takes back a buffer that a frame held.
    pub(crate) fn release(&mut self, posed: Arc<Posed>) {
        self.ring.release(posed);
    }

    /// Bytes held, those of buffers that wait for their snapshots included.
    pub(crate) fn memory(&self) -> usize {
        let shared = self.current().map_or(0, |current| current.bvh.refit_memory());
        self.ring.memory() + shared + self.room.capacity() * size_of::<[f32; 3]>()
    }

    /// Clones of a mesh that bend share the tree of the rest pose; it is built here, before they are brought up to date side by side.
    pub(crate) fn prepare_first_build(&self, threads: &Threads) {
        let data = self.data();
        if self.shares_first_build() && data.first_build.get().is_none() {
            let rest = self.mesh.at_rest();
            // Another scene may have been faster; the trees are the same.
            let _ = data.first_build.set(grow(&rest, self.quality(), threads));
        }
    }

    fn quality(&self) -> Quality {
        self.data().quality.unwrap_or(match self.motion {
            Motion::Static => Quality::Balanced,
            Motion::Rigid | Motion::Deforming => Quality::Fast,
            Motion::Rebuilt => Quality::Fastest,
        })
    }

    fn shares_first_build(&self) -> bool {
        let posed = matches!(self.shape, Shape::Posed(_)) && self.motion == Motion::Deforming;
        posed && !self.mesh.has_tree() && self.ring.current().is_none() && Arc::strong_count(self.data()) > 1
    }

    /// Brings positions, normals and tree up to date, in a buffer that no snapshot holds.
    pub(crate) fn commit(&mut self, id: MeshId, threads: &Threads) -> MeshReport {
        let clock = Clock::start();
        let has_tree = self.ring.current().is_some();
        let rebuild = std::mem::take(&mut self.rebuild);
        let (action, reason) = decide(&Candidate { motion: self.motion, edit: self.edit, has_tree, rebuild });
        let mut report = MeshReport {
            mesh: id,
            action,
            reason,
            triangles: self.data().triangles.len(),
            drift: self.drift,
            compared: false,
            allocated: false,
            pose_time: None,
            tree_time: None,
        };
        if action == Action::Kept {
            return report;
        }
        let shares_first_build = self.shares_first_build();
        // A tree from elsewhere stands over the rest pose: it is taken as it is where nothing has moved, and refitted to what bends.
        let at_rest = matches!(self.shape, Shape::Kept);
        let given = self.mesh.take_tree().filter(|_| at_rest || self.motion == Motion::Deforming);
        if given.is_some() {
            report.action = Action::Loaded;
        }
        let (mut spare, allocated) = self.ring.claim();
        report.allocated = allocated;
        if !self.shape_into(&mut spare, threads) {
            report.reason = Reason::PoseNotFinite;
            if has_tree {
                report.action = Action::Kept;
                return report;
            }
        }
        report.pose_time = clock.elapsed();
        let clock = Clock::start();
        if at_rest && let Some(tree) = given {
            spare.bvh = tree;
            self.watch_from(&spare.bvh, threads);
            report.drift = self.drift;
        } else {
            self.update_tree(&mut spare, &mut report, given, shares_first_build, threads);
        }
        report.tree_time = clock.elapsed();
        self.ring.publish(spare);
        report
    }

    /// Refits or builds.
    fn update_tree(
        &mut self,
        spare: &mut Posed,
        report: &mut MeshReport,
        given: Option<WideMesh>,
        shares_first_build: bool,
        threads: &Threads,
    ) {
        let first_build = self.mesh.data().first_build.get().filter(|_| shares_first_build);
        let from = match report.action {
            Action::Refitted => self.ring.current().map(|current| &current.bvh),
            Action::Loaded => given.as_ref(),
            Action::Built => first_build,
            _ => None,
        };
        let Some(from) = from else {
            spare.bvh = grow(&spare.triangles, self.quality(), threads);
            self.watch_from(&spare.bvh, threads);
            report.drift = self.drift;
            return;
        };
        if report.action != Action::Refitted {
            self.upkeep = Upkeep::of_build(from.ray_cost(threads));
        }
        from.refit_into(&mut spare.bvh, &spare.triangles, threads, Level::current());
        self.examine(spare, report, threads);
    }

    /// Measures a tree that was refitted, and replaces it if a better one is found.
    fn examine(&mut self, spare: &mut Posed, report: &mut MeshReport, threads: &Threads) {
        // A pose without area tells nothing about the tree.
        let Some(now) = spare.bvh.ray_cost(threads) else { return };
        let (drift, doubt) = self.upkeep.refitted(&now);
        self.drift = drift.unwrap_or(1.0) as f32;
        report.drift = self.drift;
        let Some(doubt) = doubt else { return };
        report.compared = true;
        let new = grow(&spare.triangles, self.quality(), threads);
        let new_cost = new.ray_cost(threads);
        let found = new_cost.map_or(1.0, |new| (now.work / new.work) as f32);
        if !self.upkeep.compared(&now, new_cost.as_ref()) {
            (self.drift, report.drift) = (found, found);
            return;
        }
        spare.bvh = new;
        report.action = Action::Rebuilt;
        (report.reason, report.drift) = match doubt {
            Doubt::Degraded => (Reason::Drifted, self.drift),
            Doubt::Baseline => (Reason::BetterTreeFound, found),
        };
        self.drift = 1.0;
    }

    /// Drift begins here. Only trees that are refitted are measured.
    fn watch_from(&mut self, tree: &WideMesh, threads: &Threads) {
        let is_refitted = self.motion == Motion::Deforming;
        self.upkeep = Upkeep::of_build(if is_refitted { tree.ray_cost(threads) } else { None });
        self.drift = 1.0;
    }

    /// Writes triangles, positions and normals. `false` when a pose went beyond all numbers and the vertices stayed at rest.
    fn shape_into(&mut self, spare: &mut Posed, threads: &Threads) -> bool {
        let data = self.mesh.data();
        let current = self.ring.current().filter(|_| self.edit != Edit::Triangles);
        self.edit = Edit::Nothing;
        let fits = Arc::ptr_eq(spare.triangles.shared_indices(), &data.triangles)
            && spare.triangles.positions().len() == data.positions.len();
        if !fits {
            let triangles = Triangles::new(data.positions.clone(), data.triangles.clone());
            spare.triangles = triangles.expect("a mesh has only indices in range");
        }
        spare.precision = data.precision;
        spare.normals.clear();
        spare.normals.extend_from_slice(current.map_or(&data.normals, |current| &current.normals));
        let rest = current.map_or(&data.positions[..], |current| current.triangles.positions());
        let mut finite = true;
        match std::mem::replace(&mut self.shape, Shape::Kept) {
            Shape::Kept => spare.triangles.positions_mut().copy_from_slice(rest),
            Shape::Given(mut positions) => {
                spare.triangles.swap_positions(&mut positions);
                self.room = positions;
            }
            Shape::Posed(pose) => {
                // Of a mesh whose normals were set by hand, the pose bends the original ones all the same.
                spare.normals.clone_from(&data.normals);
                pose.bend(data, spare.triangles.positions_mut(), &mut spare.normals, threads);
                finite = all_finite(spare.triangles.positions());
                if !finite {
                    spare.triangles.positions_mut().copy_from_slice(&data.positions);
                    spare.normals.clone_from(&data.normals);
                }
            }
        }
        if let Some(normals) = self.normals.take() {
            spare.normals = normals;
        }
        finite
    }
}

impl Buffer for Posed {
    fn memory(&self) -> usize {
        self.bvh.memory() + self.triangles.memory() + self.normals.capacity() * size_of::<[f32; 3]>()
    }
}

fn grow(triangles: &Triangles, quality: Quality, threads: &Threads) -> WideMesh {
    let options = BuildOptions { quality, threads: threads.clone(), ..BuildOptions::default() };
    WideMesh::new_watched(&build::triangles(triangles, &options), triangles, threads)
}

impl Edit {
    /// Positions moved, too.
    fn or_positions(self) -> Self {
        if self == Self::Nothing { Self::Positions } else { self }
    }
}
