//! The moving objects of a frame, each with its parts: a car with its wheels and its driver is one.

use glam::Vec3;
use kinetree::{InstanceView, Motion};
use kinetree_world::Frame;

/// Of more moving instances than about this many, a regular subset is taken.
const MAX_INSTANCES: usize = 2048;
/// Parts may lie outside the box of their object by this fraction of its size.
const REACH: f32 = 0.05;

/// An instance larger than this fraction of an object is no part of it but an object of its own:
/// trees whose crowns overlap stay separate.
const MAX_PART_SIZE: f32 = 0.6;

/// A moving instance together with the smaller ones that belong to it.
#[derive(Debug, Clone)]
pub(super) struct MovingObject {
    /// Bounding box, world space.
    pub(super) min: Vec3,
    pub(super) max: Vec3,
    /// Dense indices of the instances, the largest first.
    pub(super) parts: Vec<u32>,
    /// Number of triangles of all parts.
    pub(super) triangles: usize,
}

impl MovingObject {
    /// The centre of its box.
    pub(super) fn center(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// The diagonal of its box, metres.
    pub(super) fn size(&self) -> f32 {
        (self.max - self.min).length()
    }

    fn contains_part(&self, part: &Self) -> bool {
        let reach = Vec3::splat(REACH * self.size());
        let center = part.center();
        part.size() < MAX_PART_SIZE * self.size()
            && center.cmpge(self.min - reach).all()
            && center.cmple(self.max + reach).all()
    }

    fn of(instance: &InstanceView<'_>) -> Option<Self> {
        let bounds = instance.bvh().bounds();
        let (low, high) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for corner in 0..8 {
            let choose = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            let corner: Vec3 = instance.world_from_object().transform_point([choose(0), choose(1), choose(2)]).into();
            (min, max) = (min.min(corner), max.max(corner));
        }
        let object = Self { min, max, parts: vec![instance.index()], triangles: instance.triangles().len() };
        (object.size().is_finite() && object.size() > 0.0).then_some(object)
    }
}

/// The moving objects, the largest first.
pub(super) fn moving_objects(frame: &Frame) -> Vec<MovingObject> {
    let count = frame.snapshot.instances().filter(moves).count();
    let every = count.div_ceil(MAX_INSTANCES).max(1);
    let mut instances: Vec<MovingObject> = frame
        .snapshot
        .instances()
        .filter(moves)
        .step_by(every)
        .filter_map(|instance| MovingObject::of(&instance))
        .collect();
    instances.sort_by(|a, b| b.size().total_cmp(&a.size()));
    merge_parts(instances)
}

fn moves(instance: &InstanceView<'_>) -> bool {
    instance.motion() != Motion::Static
}

/// Merges each instance into the smallest of the larger objects that contains its centre, if there
/// is one. Expects the largest first.
fn merge_parts(instances: Vec<MovingObject>) -> Vec<MovingObject> {
    let mut objects: Vec<MovingObject> = Vec::new();
    // The objects without their parts: tested against these, a row of instances does not merge into
    // one object.
    let mut unmerged: Vec<MovingObject> = Vec::new();
    for instance in instances {
        match unmerged.iter().rposition(|object| object.contains_part(&instance)) {
            Some(index) => {
                let object = &mut objects[index];
                (object.min, object.max) = (object.min.min(instance.min), object.max.max(instance.max));
                object.parts.extend(instance.parts);
                object.triangles += instance.triangles;
            }
            None => {
                unmerged.push(instance.clone());
                objects.push(instance);
            }
        }
    }
    objects
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(center: Vec3, half: Vec3, index: u32) -> MovingObject {
        MovingObject { min: center - half, max: center + half, parts: vec![index], triangles: 1 }
    }

    #[test]
    fn wheels_are_parts_of_their_car_and_cars_are_separate() {
        let mut blocks = Vec::new();
        for car in 0..3 {
            let center = Vec3::X * 4.2 * car as f32;
            blocks.push(block(center, Vec3::new(2.0, 0.5, 1.0), car));
        }
        for wheel in 0..12 {
            let side = Vec3::new(if wheel % 2 == 0 { 1.4 } else { -1.4 }, -0.4, if wheel % 4 < 2 { 0.9 } else { -0.9 });
            blocks.push(block(Vec3::X * 4.2 * (wheel / 4) as f32 + side, Vec3::splat(0.3), 3 + wheel));
        }
        let objects = merge_parts(blocks);
        assert_eq!(objects.len(), 3);
        for (car, object) in objects.iter().enumerate() {
            let wheels: Vec<u32> = (0..4).map(|wheel| 3 + 4 * car as u32 + wheel).collect();
            assert_eq!((object.parts[0], &object.parts[1..]), (car as u32, &wheels[..]));
        }
    }
}
