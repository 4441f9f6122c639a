//! Commits: every tree is brought up to date, and a frame is published as a snapshot.

use std::collections::HashSet;

use super::contents::Scene;
use super::frame::{Frame, FrameNormals, PlacedInstance};
use super::graph::resolve;
use super::mesh_state::MeshState;
use super::report::{FrameReport, MeshReport, TopLevelMethod, TopLevelReport};
use super::snapshot::Snapshot;
use super::top_level;
use crate::clock::Clock;
use crate::geometry::inverse::Inverse;
use crate::geometry::slab::FarRays;
use crate::geometry::{Aabb, Affine};
use crate::handle::MeshId;
use crate::traverse::FrameStamp;
use crate::wide::InstanceRecord;

impl Scene {
    /// Carries out the edits: meshes are kept, refitted or rebuilt as their
    /// [`Motion`](crate::Motion) and their drift demand, then the tree over all instances is built.
    /// Decisions rest on expected costs, never on measured times: the same edits give the same
    /// trees.
    ///
    /// Later edits and commits never change the returned snapshot, which may outlive the scene.
    pub fn commit(&mut self) -> Snapshot {
        let clock = Clock::start();
        // Frames whose last snapshot was dropped release their meshes first, so that the buffers
        // can be written again.
        self.history.frames.collect(|frame| frame.release_meshes(&mut self.meshes));
        let (mut frame, new_frame) = self.history.frames.claim();
        self.history.count += 1;
        frame.world.stamp = FrameStamp::fresh();

        let meshes = self.commit_meshes();
        let mesh_time = clock.elapsed();

        let top_clock = Clock::start();
        let (left_out, far) = self.place_instances(&mut frame);
        let method = self.combine(&mut frame, far);
        let top_level = TopLevelReport {
            method,
            instances: frame.world.top.instance_count(),
            cost: frame.world.top.cost(1.0, 1.0),
            time: top_clock.elapsed(),
        };
        frame.report = FrameReport {
            frame: self.history.count,
            allocated: usize::from(new_frame) + meshes.iter().filter(|mesh| mesh.allocated).count(),
            meshes,
            top_level,
            left_out,
            memory: self.heap_bytes() + frame.heap_bytes(),
            mesh_time,
            total_time: clock.elapsed(),
        };
        Snapshot::of(self.history.frames.publish(frame))
    }

    /// Bytes held by all meshes.
    fn heap_bytes(&self) -> usize {
        let mut counted = HashSet::new();
        self.meshes.iter().map(|(_, mesh)| mesh.heap_bytes(&mut counted)).sum()
    }

    fn commit_meshes(&mut self) -> Vec<MeshReport> {
        let threads = self.threads.clone();
        for (_, mesh) in self.meshes.iter() {
            mesh.prepare_first_build(&threads);
        }
        let handles: Vec<MeshId> = self.meshes.handles().map(MeshId).collect();
        let mut work: Vec<(MeshId, &mut MeshState, Option<MeshReport>)> =
            handles.into_iter().zip(self.meshes.iter_mut()).map(|(id, (_, mesh))| (id, mesh, None)).collect();
        threads.for_each(&mut work, 1, &|_, (id, mesh, report)| *report = Some(mesh.commit(*id, &threads)));
        work.into_iter().filter_map(|(_, _, report)| report).collect()
    }

    /// Fills instance records and world boxes. Returns the instances that were left out, and the
    /// additional error of rays from far away.
    fn place_instances(&mut self, frame: &mut Frame) -> (Vec<super::InstanceId>, FarRays) {
        let resolved = resolve(&self.nodes);
        frame.placed.clear();
        frame.boxes.clear();
        frame.world.instances.clear();
        frame.world.doubles.clear();
        frame.world.numbers.clear();
        let hierarchy = self.history.hierarchy.updated(&self.nodes, &self.instances);
        frame.world.hierarchy = hierarchy.clone();
        frame.release_meshes(&mut self.meshes);
        frame.world.meshes.resize(self.meshes.end(), self.history.nothing.clone());
        frame.owners.resize(self.meshes.end(), None);
        frame.normals.resize(self.meshes.end(), None);
        // By slot, indices into the report: meshes are reported in the order of their slots.
        let mut reported = vec![0_u32; self.meshes.end()];
        for (index, (slot, mesh)) in (0..).zip(self.meshes.iter()) {
            reported[slot as usize] = index;
            let id = self.meshes.handle_of(slot).into();
            if let Some(current) = mesh.frames.current() {
                frame.world.meshes[slot as usize] = current.clone();
                frame.owners[slot as usize] = mesh.frames.shared().is_none().then_some(id);
            }
            if let Some(current) = mesh.normals.current().filter(|normals| !normals.is_empty()) {
                let owner = mesh.normals.shared().is_none().then_some(id);
                frame.normals[slot as usize] = Some(FrameNormals { owner, normals: current.clone() });
            }
        }
        let (mut left_out, mut skewed) = (Vec::new(), Vec::new());
        let handles: Vec<_> = self.instances.handles().collect();
        for (handle, (_, instance)) in handles.into_iter().zip(self.instances.iter_mut()) {
            let placement = resolved[instance.node as usize].then(&instance.placement);
            let world_from_object = placement.transform;
            // The inverse is cached until the placement changes.
            if instance.inverted.as_ref().is_none_or(|(of, _)| *of != world_from_object) {
                let inverse = world_from_object.is_finite().then(|| Inverse::of(&world_from_object)).flatten();
                instance.inverted = Some((world_from_object, inverse));
            }
            let inverse = instance.inverted.as_ref().and_then(|(_, inverse)| inverse.as_ref());
            let mesh_at = instance.mesh.slot;
            let tree = &frame.world.meshes[mesh_at as usize].bvh;
            let Some((inverse, object_from_world, bounds)) = inverse
                .and_then(|inverse| {
                    let bounds = top_level::world_box(tree, &world_from_object, inverse);
                    Some((inverse, inverse.object_from_world()?, bounds))
                })
                .filter(|(_, _, bounds)| bounds.is_empty() || bounds.is_finite())
            else {
                left_out.push(handle.into());
                continue;
            };
            let number = frame.world.instances.len();
            match inverse {
                Inverse::Single { skew, .. } if top_level::is_skewed(*skew) => skewed.push((number, *skew)),
                Inverse::Single { .. } => {}
                Inverse::Double(double) => frame.world.doubles.push((number as u32, **double)),
            }
            frame.world.instances.push(InstanceRecord {
                object_from_world,
                mesh: mesh_at,
                mask: placement.mask,
                user_id: placement.user_id.unwrap_or(0),
                opaque: instance.opaque,
                identity: world_from_object == Affine::IDENTITY,
                in_double: matches!(inverse, Inverse::Double(_)),
            });
            frame.boxes.push(bounds);
            frame.world.numbers.push(frame.world.hierarchy.number_of(handle.slot));
            frame.placed.push(PlacedInstance {
                id: handle.into(),
                mesh: reported[mesh_at as usize],
                world_from_object,
            });
        }
        let far = top_level::pad_skewed(&mut frame.boxes, &skewed);
        (left_out, far)
    }

    /// Makes the tree over the instances; it is that of the last frame if no box has changed.
    fn combine(&self, frame: &mut Frame, far: FarRays) -> TopLevelMethod {
        if let Some(last) = self.history.frames.current()
            && last.boxes == frame.boxes
        {
            frame.world.top.copy_from(&last.world.top, far);
            return TopLevelMethod::Kept;
        }
        let (top, method) = top_level::build(&frame.boxes, far, &self.threads);
        frame.world.top = top;
        method
    }
}

impl Frame {
    fn heap_bytes(&self) -> usize {
        self.world.top.heap_bytes()
            + self.world.instances.capacity() * size_of::<InstanceRecord>()
            + self.world.hierarchy.heap_bytes()
            + self.world.numbers.capacity() * size_of::<u32>()
            + self.placed.capacity() * size_of::<PlacedInstance>()
            + self.boxes.capacity() * size_of::<Aabb>()
    }
}
