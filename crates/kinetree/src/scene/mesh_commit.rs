//! Brings one mesh up to date: its vertices, its normals, and then its tree, in buffers that no
//! snapshot holds.

use std::sync::Arc;

use super::input::all_finite;
use super::mesh::{VertexNormals, grow};
use super::mesh_edits::{MeshEdits, Vertices};
use super::mesh_state::MeshState;
use super::pose::OwnedPose;
use super::report::MeshReport;
use crate::build::Quality;
use crate::clock::Clock;
use crate::geometry::Triangles;
use crate::handle::MeshId;
use crate::simd::Level;
use crate::threads::Threads;
use crate::traverse::MeshFrame;
use crate::update::{Action, Doubt, Edit, MeshUpdate, Motion, Reason, Upkeep, decide};
use crate::wide::MeshBvh;

/// The tree that a commit begins with.
enum Start {
    /// None: one is built.
    Build,
    /// That of the last commit.
    Last,
    /// A tree of the rest pose.
    Rest(Arc<MeshFrame>),
}

impl MeshState {
    /// Carries out the edits since the last commit.
    pub(crate) fn commit(&mut self, id: MeshId, threads: &Threads) -> MeshReport {
        let clock = Clock::start();
        let mut report = self.unchanged(id);
        let shares_first_build = self.shares_first_build();
        let edits = std::mem::replace(&mut self.edits, MeshEdits::NONE);
        if edits.motion
            && let Some(current) = self.frames.current().cloned()
        {
            self.observe_from(&current.bvh, threads);
            report.drift = self.tree.drift;
        }
        let is_replaced = edits.geometry.is_replaced();
        let (mut posed, mut positions, mut poses_normals) = (None, None, false);
        match edits.geometry.into_vertices() {
            Some(Vertices::Pose(pose)) => {
                // Normals that were set replace those of the pose.
                poses_normals = edits.normals.is_none() && !self.data().normals.is_empty();
                posed = self.write_posed(&pose, poses_normals, &mut report, threads);
                poses_normals &= posed.is_some();
            }
            Some(Vertices::Positions(given)) => positions = Some(given),
            None => {}
        }
        self.update_normals(edits.normals, is_replaced && !poses_normals, &mut report);
        let edit = match (is_replaced, posed.is_some() || positions.is_some()) {
            (true, _) => Edit::Triangles,
            (false, true) => Edit::Positions,
            (false, false) => Edit::Nothing,
        };
        let (action, reason) = self.decide(edit, edits.rebuild);
        report.action = action;
        if report.reason != Reason::PoseNotFinite && reason != Reason::NothingChanged {
            report.reason = reason;
        }
        if action == Action::Kept {
            self.update_precision(&mut report);
            return report;
        }
        let is_at_rest = is_replaced && posed.is_none() && positions.is_none();
        let start = self.start(&mut report, shares_first_build, is_at_rest);
        if let Start::Rest(rest) = &start
            && is_at_rest
        {
            let clock = Clock::start();
            self.observe_from(&rest.bvh, threads);
            self.frames.share(rest.clone());
            report.tree_time = clock.elapsed();
            return report;
        }
        let mut spare = posed.unwrap_or_else(|| self.write_vertices(positions, is_replaced, &mut report));
        report.pose_time = clock.elapsed();
        let clock = Clock::start();
        self.update_tree(&mut spare, &start, &mut report, threads);
        report.tree_time = clock.elapsed();
        self.frames.publish(spare);
        report
    }

    /// The report of a commit that has nothing to do.
    fn unchanged(&self, id: MeshId) -> MeshReport {
        MeshReport {
            mesh: id,
            motion: self.motion,
            action: Action::Kept,
            reason: Reason::NothingChanged,
            triangles: self.data().triangles.len(),
            drift: self.tree.drift,
            compared: false,
            allocated: false,
            pose_time: None,
            tree_time: None,
        }
    }

    fn decide(&self, edit: Edit, rebuild: bool) -> (Action, Reason) {
        let has_tree = self.frames.current().is_some();
        let is_below_quality = self.tree.quality < self.quality();
        decide(&MeshUpdate { motion: self.motion, edit, has_tree, rebuild, is_below_quality })
    }

    /// Chooses the tree to begin with. Trees that came with the mesh, or that clones share, stand
    /// over the rest pose: they are taken as they are where nothing has moved, and refitted where
    /// the mesh deforms.
    fn start(&mut self, report: &mut MeshReport, shares_first_build: bool, is_at_rest: bool) -> Start {
        if report.action == Action::Refitted {
            return Start::Last;
        }
        let is_of_use = is_at_rest || self.motion == Motion::Deforming;
        if let Some(mut given) = self.mesh.take_tree().filter(|_| is_of_use) {
            if given.precision != self.precision {
                Arc::make_mut(&mut given).precision = self.precision;
            }
            report.action = Action::Loaded;
            self.tree.quality = Quality::Best;
            return Start::Rest(given);
        }
        let quality = self.quality();
        self.tree.quality = quality;
        let shared = self.mesh.first_build(quality).filter(|_| shares_first_build && is_of_use);
        shared.map_or(Start::Build, |shared| Start::Rest(shared.clone()))
    }

    /// Refits or builds.
    fn update_tree(&mut self, spare: &mut MeshFrame, start: &Start, report: &mut MeshReport, threads: &Threads) {
        let from = match start {
            Start::Build => None,
            Start::Last => self.frames.current().cloned(),
            Start::Rest(rest) => {
                self.tree.upkeep = Upkeep::of_build(rest.bvh.ray_cost(threads));
                Some(rest.clone())
            }
        };
        if let Some(from) = from {
            from.bvh.refit_into(&mut spare.bvh, &spare.triangles, threads, Level::current());
            self.examine(spare, report, threads);
        } else {
            spare.bvh = grow(&spare.triangles, self.quality(), threads);
            self.observe_from(&spare.bvh, threads);
            report.drift = self.tree.drift;
        }
    }

    /// Measures a tree that was refitted, and replaces it if a better one is found.
    fn examine(&mut self, spare: &mut MeshFrame, report: &mut MeshReport, threads: &Threads) {
        // A pose without area tells nothing about the tree.
        let Some(now) = spare.bvh.ray_cost(threads) else { return };
        let (drift, doubt) = self.tree.upkeep.refitted(&now);
        self.tree.drift = drift.unwrap_or(1.0) as f32;
        report.drift = self.tree.drift;
        let Some(doubt) = doubt else { return };
        report.compared = true;
        let new = grow(&spare.triangles, self.quality(), threads);
        let new_cost = new.ray_cost(threads);
        let found = new_cost.map_or(1.0, |new| (now.work / new.work) as f32);
        if !self.tree.upkeep.compared(&now, new_cost.as_ref()) {
            (self.tree.drift, report.drift) = (found, found);
            return;
        }
        spare.bvh = new;
        self.tree.quality = self.quality();
        report.action = Action::Rebuilt;
        (report.reason, report.drift) = match doubt {
            Doubt::Degraded => (Reason::Drifted, self.tree.drift),
            Doubt::Baseline => (Reason::BetterTreeFound, found),
        };
        self.tree.drift = 1.0;
    }

    /// Measures drift from this tree on. Only trees that are refitted are measured.
    fn observe_from(&mut self, tree: &MeshBvh, threads: &Threads) {
        let is_refitted = self.motion == Motion::Deforming;
        self.tree.upkeep = Upkeep::of_build(if is_refitted { tree.ray_cost(threads) } else { None });
        self.tree.drift = 1.0;
    }

    /// A buffer with the vertices of a pose, whose normals are published if they are asked for.
    /// `None` if the pose makes a vertex infinite or NaN: then the buffers go back, and the pose is
    /// dropped.
    fn write_posed(
        &mut self,
        pose: &OwnedPose,
        poses_normals: bool,
        report: &mut MeshReport,
        threads: &Threads,
    ) -> Option<MeshFrame> {
        let mut spare = self.claim(report);
        let data = self.mesh.data();
        let (mut normals, new_normals) = if poses_normals { self.normals.claim() } else { Default::default() };
        normals.resize(if poses_normals { data.normals.len() } else { 0 }, [0.0; 3]);
        pose.apply(data, spare.triangles.positions_mut(), &mut normals, threads);
        if !all_finite(spare.triangles.positions()) {
            self.frames.give_back(spare);
            if poses_normals {
                self.normals.give_back(normals);
            }
            report.reason = Reason::PoseNotFinite;
            return None;
        }
        if poses_normals {
            self.normals.publish(normals);
            report.allocated |= new_normals;
        }
        Some(spare)
    }

    /// Publishes normals that were set, or shares those of new triangles.
    fn update_normals(&mut self, given: Option<VertexNormals>, takes_those_of_the_mesh: bool, report: &mut MeshReport) {
        if let Some(normals) = given {
            self.normals.publish(normals);
            if report.reason == Reason::NothingChanged {
                report.reason = Reason::NormalsChanged;
            }
        } else if takes_those_of_the_mesh {
            self.normals.share(self.data().normals.clone());
        }
    }

    /// A buffer with the vertices as they were given, as they were last, or at rest.
    fn write_vertices(
        &mut self,
        given: Option<Vec<[f32; 3]>>,
        is_replaced: bool,
        report: &mut MeshReport,
    ) -> MeshFrame {
        let mut spare = self.claim(report);
        if let Some(mut positions) = given {
            spare.triangles.swap_positions(&mut positions);
            self.positions_buffer = positions;
        } else {
            let last = self.frames.current().filter(|_| !is_replaced);
            let positions = last.map_or(&self.data().positions[..], |last| last.triangles.positions());
            spare.triangles.positions_mut().copy_from_slice(positions);
        }
        spare
    }

    /// Publishes a copy of a tree that is kept, if its triangles are to be tested in another way.
    fn update_precision(&mut self, report: &mut MeshReport) {
        let Some(current) = self.frames.current().filter(|current| current.precision != self.precision) else { return };
        let copy = MeshFrame { precision: self.precision, ..MeshFrame::clone(current) };
        self.frames.publish(copy);
        report.allocated = true;
        if report.reason == Reason::NothingChanged {
            report.reason = Reason::PrecisionChanged;
        }
    }

    /// A buffer for the triangles as they are now.
    fn claim(&mut self, report: &mut MeshReport) -> MeshFrame {
        let (mut spare, is_new) = self.frames.claim();
        report.allocated |= is_new;
        let data = self.mesh.data();
        let fits = Arc::ptr_eq(spare.triangles.shared_indices(), &data.triangles)
            && spare.triangles.positions().len() == data.positions.len();
        if !fits {
            let triangles = Triangles::new(data.positions.clone(), data.triangles.clone());
            spare.triangles = triangles.expect("a mesh has only indices in range");
        }
        spare.precision = self.precision;
        spare
    }
}
