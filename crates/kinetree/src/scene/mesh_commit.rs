//! Bringing one mesh up to date: its vertices, its normals, and then its tree, in buffers that no
//! snapshot holds.

use std::sync::Arc;

use super::input::all_finite;
use super::mesh::grow;
use super::mesh_state::{Geometry, MeshState};
use super::report::MeshReport;
use crate::clock::Clock;
use crate::geometry::Triangles;
use crate::handle::MeshId;
use crate::simd::Level;
use crate::threads::Threads;
use crate::traverse::MeshFrame;
use crate::update::{Action, Doubt, Edit, MeshUpdate, Motion, Reason, Upkeep, decide};
use crate::wide::MeshBvh;

/// What a tree begins with.
enum Start {
    /// Nothing: it is built.
    Nothing,
    /// The tree of the last commit.
    Last,
    /// A tree of the rest pose.
    Rest(Arc<MeshFrame>),
}

impl MeshState {
    /// Carries out the edits since the last commit.
    pub(crate) fn commit(&mut self, id: MeshId, threads: &Threads) -> MeshReport {
        let clock = Clock::start();
        let mut report = MeshReport {
            mesh: id,
            motion: self.motion,
            action: Action::Kept,
            reason: Reason::NothingChanged,
            triangles: self.data().triangles.len(),
            drift: self.drift,
            compared: false,
            allocated: false,
            pose_time: None,
            tree_time: None,
        };
        let shares_first_build = self.shares_first_build();
        let posed = self.write_posed(&mut report, threads);
        self.update_normals(posed.is_some(), &mut report);
        let (action, reason) = self.decide();
        report.action = action;
        if report.reason != Reason::PoseNotFinite && reason != Reason::NothingChanged {
            report.reason = reason;
        }
        let edit = std::mem::replace(&mut self.edit, Edit::Nothing);
        if action == Action::Kept {
            return report;
        }
        let is_at_rest = posed.is_none() && edit == Edit::Triangles && matches!(self.geometry, Geometry::Unchanged);
        let start = self.start(&mut report, shares_first_build, is_at_rest);
        if let Start::Rest(rest) = &start
            && is_at_rest
        {
            let clock = Clock::start();
            self.watch_from(&rest.bvh, threads);
            self.shared = Some(rest.clone());
            report.tree_time = clock.elapsed();
            return report;
        }
        let mut spare = posed.unwrap_or_else(|| self.write_vertices(edit, &mut report));
        report.pose_time = clock.elapsed();
        let clock = Clock::start();
        self.update_tree(&mut spare, &start, &mut report, threads);
        report.tree_time = clock.elapsed();
        self.ring.publish(spare);
        self.shared = None;
        report
    }

    fn decide(&mut self) -> (Action, Reason) {
        let rebuild = std::mem::take(&mut self.rebuild);
        let has_tree = self.current().is_some();
        decide(&MeshUpdate { motion: self.motion, edit: self.edit, has_tree, rebuild })
    }

    /// Which tree there is to begin with. Trees that came with the mesh, or that clones share,
    /// stand over the rest pose: they are taken as they are where nothing has moved, and refitted
    /// to what bends.
    fn start(&mut self, report: &mut MeshReport, shares_first_build: bool, is_at_rest: bool) -> Start {
        if report.action == Action::Refitted {
            return Start::Last;
        }
        let is_of_use = is_at_rest || self.motion == Motion::Deforming;
        if let Some(given) = self.mesh.take_tree().filter(|_| is_of_use) {
            report.action = Action::Loaded;
            return Start::Rest(given);
        }
        let shared = self.mesh.first_build(self.quality()).filter(|_| shares_first_build && is_of_use);
        shared.map_or(Start::Nothing, |shared| Start::Rest(shared.clone()))
    }

    /// Refits or builds.
    fn update_tree(&mut self, spare: &mut MeshFrame, start: &Start, report: &mut MeshReport, threads: &Threads) {
        let from = match start {
            Start::Nothing => None,
            Start::Last => self.current().cloned(),
            Start::Rest(rest) => {
                self.upkeep = Upkeep::of_build(rest.bvh.ray_cost(threads));
                Some(rest.clone())
            }
        };
        if let Some(from) = from {
            from.bvh.refit_into(&mut spare.bvh, &spare.triangles, threads, Level::current());
            self.examine(spare, report, threads);
        } else {
            spare.bvh = grow(&spare.triangles, self.quality(), threads);
            self.watch_from(&spare.bvh, threads);
            report.drift = self.drift;
        }
    }

    /// Measures a tree that was refitted, and replaces it if a better one is found.
    fn examine(&mut self, spare: &mut MeshFrame, report: &mut MeshReport, threads: &Threads) {
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
    fn watch_from(&mut self, tree: &MeshBvh, threads: &Threads) {
        let is_refitted = self.motion == Motion::Deforming;
        self.upkeep = Upkeep::of_build(if is_refitted { tree.ray_cost(threads) } else { None });
        self.drift = 1.0;
    }

    /// If the mesh was posed, a buffer with its vertices. A pose that puts vertices beyond all
    /// numbers is dropped, and nothing else: buffers go back, and other edits are carried out.
    fn write_posed(&mut self, report: &mut MeshReport, threads: &Threads) -> Option<MeshFrame> {
        let pose = match std::mem::replace(&mut self.geometry, Geometry::Unchanged) {
            Geometry::Pose(pose) => pose,
            other => {
                self.geometry = other;
                return None;
            }
        };
        let mut spare = self.claim(report);
        let data = self.mesh.data();
        // Normals that were set by hand since are not bent, and need not be: they replace the bent
        // ones.
        let bends_normals = self.normals.is_none() && !data.normals.is_empty();
        let (mut normals, new_normals) = if bends_normals { self.normal_ring.claim() } else { Default::default() };
        normals.resize(if bends_normals { data.normals.len() } else { 0 }, [0.0; 3]);
        pose.bend(data, spare.triangles.positions_mut(), &mut normals, threads);
        let is_finite = all_finite(spare.triangles.positions());
        if is_finite && bends_normals {
            self.normal_ring.publish(normals);
            self.shared_normals = None;
            report.allocated |= new_normals;
        } else if bends_normals {
            self.normal_ring.give_back(normals);
        }
        if is_finite {
            return Some(spare);
        }
        self.ring.give_back(spare);
        self.edit = self.edit.without_positions();
        report.reason = Reason::PoseNotFinite;
        None
    }

    /// Normals that were set, or those of new triangles; bent ones are there already.
    fn update_normals(&mut self, is_posed: bool, report: &mut MeshReport) {
        if let Some(normals) = self.normals.take() {
            self.normal_ring.publish(normals);
            self.shared_normals = None;
            if report.reason == Reason::NothingChanged {
                report.reason = Reason::NormalsChanged;
            }
        } else if self.edit == Edit::Triangles && !is_posed {
            self.shared_normals = Some(self.data().normals.clone());
        }
    }

    /// A buffer with the vertices where they were given, where they were, or at rest.
    fn write_vertices(&mut self, edit: Edit, report: &mut MeshReport) -> MeshFrame {
        let mut spare = self.claim(report);
        match std::mem::replace(&mut self.geometry, Geometry::Unchanged) {
            Geometry::Positions(mut positions) => {
                spare.triangles.swap_positions(&mut positions);
                self.room = positions;
            }
            Geometry::Unchanged | Geometry::Pose(_) => {
                let last = self.current().filter(|_| edit != Edit::Triangles);
                let positions = last.map_or(&self.data().positions[..], |last| last.triangles.positions());
                spare.triangles.positions_mut().copy_from_slice(positions);
            }
        }
        spare
    }

    /// A buffer for the triangles as they are now.
    fn claim(&mut self, report: &mut MeshReport) -> MeshFrame {
        let (mut spare, is_new) = self.ring.claim();
        report.allocated |= is_new;
        let data = self.mesh.data();
        let fits = Arc::ptr_eq(spare.triangles.shared_indices(), &data.triangles)
            && spare.triangles.positions().len() == data.positions.len();
        if !fits {
            let triangles = Triangles::new(data.positions.clone(), data.triangles.clone());
            spare.triangles = triangles.expect("a mesh has only indices in range");
        }
        spare.precision = data.precision;
        spare
    }
}

impl Edit {
    /// Positions stay after all.
    fn without_positions(self) -> Self {
        if self == Self::Positions { Self::Nothing } else { self }
    }
}
