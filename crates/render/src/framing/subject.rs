//! The subject of a picture of a moving scene: the densest group of moving objects, or everything
//! when nearly everything moves.

use glam::Vec3;
use kinetree_world::Frame;

use super::moving_objects::{MovingObject, moving_objects};
use super::region::Region;

/// Everything counts as moving if this part of all triangles moves, and also the box of what moves
/// is large enough, see [`MIN_EXTENT_OF_ALL`].
const MOVING_OF_ALL: f32 = 0.6;
/// The diagonal of the box around what moves over that of the box around everything, from which on
/// everything counts as moving.
const MIN_EXTENT_OF_ALL: f32 = 0.3;
/// A group with less than this part of the moving triangles is too small to be the subject.
const MIN_GROUP: f32 = 0.1;
/// An object larger than this multiple of the region's radius is scenery, not part of a group.
const SCENERY: f32 = 0.5;
/// The distance within which objects are neighbours, in sizes of the object.
const NEIGHBOURHOOD: f32 = 6.0;
/// An object this many times as large as its neighbour does not belong to its group.
const MUCH_LARGER: f32 = 2.5;
/// An object smaller than this multiple of the size of the group's seed is left out of the group.
const MUCH_SMALLER: f32 = 0.25;
/// Of more objects than about this many, a regular subset is sampled.
const MAX_OBJECTS: usize = 96;
/// The approximate number of points on all objects together.
const POINTS: usize = 384;

/// The objects to be shown, and how.
#[derive(Debug)]
pub(super) struct Subject {
    pub(super) objects: Vec<SampledObject>,
    /// The bounding box of the objects, world space.
    pub(super) min: Vec3,
    pub(super) max: Vec3,
    /// Whether the objects are everything there is to see, to be shown whole, instead of a group in
    /// its surroundings.
    pub(super) is_all: bool,
}

/// A moving object with points on its surface.
#[derive(Debug)]
pub(super) struct SampledObject {
    pub(super) center: Vec3,
    /// The diagonal of its box, metres.
    pub(super) size: f32,
    /// World space.
    pub(super) points: Vec<Vec3>,
}

impl Subject {
    /// `None` when too little moves for a picture. `region` is the region of interest.
    pub(super) fn of(frame: &Frame, region: &Region) -> Option<Self> {
        let objects = moving_objects(frame);
        let is_all = is_all(frame, &objects);
        let chosen = if is_all { objects } else { group(&objects, SCENERY * region.radius()) };
        // A single moving object is either everything there is, or lost in its surroundings: the
        // region of interest shows it better.
        if chosen.len() < 2 {
            return None;
        }
        let (min, max) = bounding_box(&chosen);
        let sampled: Vec<&MovingObject> = chosen.iter().step_by(chosen.len().div_ceil(MAX_OBJECTS)).collect();
        let each = (POINTS / sampled.len()).clamp(4, 24);
        let objects: Vec<SampledObject> =
            sampled.into_iter().map(|object| SampledObject::of(frame, object, each)).collect();
        Some(Self { objects, min, max, is_all })
    }

    pub(super) fn center(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Half extents: from the centre to a face, per axis.
    pub(super) fn half(&self) -> Vec3 {
        self.max * 0.5 - self.min * 0.5
    }
}

impl SampledObject {
    fn of(frame: &Frame, object: &MovingObject, count: usize) -> Self {
        let mut points = Vec::new();
        let triangles = |part: &u32| frame.snapshot.instance_at(*part).triangles().len();
        let stride = object.parts.iter().map(triangles).sum::<usize>().div_ceil(count).max(1);
        // Index of the next point's triangle, counted from the first triangle of the part.
        let mut next = stride / 2;
        for &part in &object.parts {
            let instance = frame.snapshot.instance_at(part);
            while next < instance.triangles().len() {
                let corners = instance.triangles()[next].map(|vertex| {
                    Vec3::from(instance.world_from_object().transform_point(instance.positions()[vertex as usize]))
                });
                points.push(corners.iter().sum::<Vec3>() / 3.0);
                next += stride;
            }
            next -= instance.triangles().len();
        }
        Self { center: object.center(), size: object.size(), points }
    }
}

/// Whether nearly everything in the frame moves.
fn is_all(frame: &Frame, objects: &[MovingObject]) -> bool {
    let total: usize = frame.snapshot.instances().map(|instance| instance.triangles().len()).sum();
    let (min, max) = bounding_box(objects);
    let everything = frame.snapshot.bounds();
    let all = Vec3::from(everything.max).distance(everything.min.into());
    triangles(objects) > MOVING_OF_ALL * total as f32 && min.distance(max) > MIN_EXTENT_OF_ALL * all
}

/// The densest group of objects up to a size; empty if it has too few triangles to be the subject.
fn group(objects: &[MovingObject], largest: f32) -> Vec<MovingObject> {
    let objects: Vec<MovingObject> = objects.iter().filter(|object| object.size() < largest).cloned().collect();
    let group = densest(&objects);
    if triangles(&group) >= MIN_GROUP * triangles(&objects) { group } else { Vec::new() }
}

fn triangles(objects: &[MovingObject]) -> f32 {
    objects.iter().map(|object| object.triangles).sum::<usize>() as f32
}

/// The bounding box of objects.
fn bounding_box(objects: &[MovingObject]) -> (Vec3, Vec3) {
    objects
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), object| (min.min(object.min), max.max(object.max)))
}

/// The object with most around it, the seed, and its neighbours.
fn densest(objects: &[MovingObject]) -> Vec<MovingObject> {
    let mut best: Option<(f32, &MovingObject)> = None;
    for seed in objects {
        // Objects that are small beside the seed count little, so that a train does not form a
        // group with birds.
        let weight = neighbours(objects, seed).map(|object| (object.size() / seed.size()).min(1.0)).sum();
        // Of equal groups the first is kept.
        if best.is_none_or(|(most, _)| weight > most) {
            best = Some((weight, seed));
        }
    }
    best.map_or_else(Vec::new, |(_, seed)| {
        neighbours(objects, seed).filter(|object| object.size() > MUCH_SMALLER * seed.size()).cloned().collect()
    })
}

fn neighbours<'a>(objects: &'a [MovingObject], seed: &'a MovingObject) -> impl Iterator<Item = &'a MovingObject> {
    let (center, size) = (seed.center(), seed.size());
    objects.iter().filter(move |object| {
        object.size() < MUCH_LARGER * size && object.center().distance(center) < NEIGHBOURHOOD * size
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn object(center: [f32; 3], size: f32) -> MovingObject {
        let (center, half) = (Vec3::from(center), Vec3::splat(0.5 * size / 3.0_f32.sqrt()));
        MovingObject { min: center - half, max: center + half, parts: Vec::new(), triangles: 1 }
    }

    #[test]
    fn the_densest_group_is_the_cars_and_neither_the_train_nor_the_birds() {
        let mut objects = vec![object([300.0, 0.0, 0.0], 60.0), object([12.0, 5.0, 0.0], 30.0)];
        // Five cars near each other, three further on.
        objects.extend([0.0, 6.0, 11.0, 17.0, 22.0, 80.0, 87.0, 94.0].map(|x| object([x, 0.0, 0.0], 4.0)));
        objects.extend((0..4).map(|bird| object([200.0 + 3.0 * bird as f32, 90.0, 0.0], 0.5)));
        let group = densest(&objects);
        assert_eq!(group.len(), 5, "{group:?}");
        assert!(group.iter().all(|object| object.center().x < 30.0 && object.size() < 5.0), "{group:?}");
    }

    #[test]
    fn nothing_has_no_group() {
        assert!(densest(&[]).is_empty());
    }
}
