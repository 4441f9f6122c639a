//! What the picture of a moving scene is about: the densest group of what moves, or all of it when
//! nearly all moves.

use glam::Vec3;
use kinetree_world::Frame;

use super::moving_objects::{MovingObject, moving_objects};
use super::region::Region;

/// From this part of all triangles on, everything is said to move, if it also takes [this
/// part](ALL_ROUND) of the room.
const NEARLY_ALL: f32 = 0.6;
/// The box around what moves over the box around everything, by their diagonals, from which nothing
/// else is worth a look.
const ALL_ROUND: f32 = 0.3;
/// The part of the moving triangles below which a group is decoration.
const WORTH_A_LOOK: f32 = 0.1;
/// What is larger than this part of the region where most things are is no body in it but a part of
/// the world.
const PART_OF_THE_WORLD: f32 = 0.5;
/// How far neighbours are, in sizes of the body they are neighbours of.
const NEIGHBOURHOOD: f32 = 6.0;
/// What is so many times as large as its neighbours is no part of their group.
const MUCH_LARGER: f32 = 2.5;
/// What is so many times smaller than the typical body of a group is not worth a look of its own.
const MUCH_SMALLER: f32 = 0.25;
/// Bodies that are looked at, about; of more, every so many.
const MAX_OBJECTS: usize = 96;
/// Places looked for, about, in all bodies together.
const PLACES: usize = 384;

/// Bodies to be shown, and how.
#[derive(Debug)]
pub(super) struct Subject {
    pub(super) objects: Vec<SampledObject>,
    /// The box around the bodies, world space.
    pub(super) min: Vec3,
    pub(super) max: Vec3,
    /// Whether this is all there is to see, to be shown whole; else a group in its surroundings.
    pub(super) is_all: bool,
}

/// A body with places on its surface.
#[derive(Debug)]
pub(super) struct SampledObject {
    pub(super) center: Vec3,
    /// The diagonal of its box, metres.
    pub(super) size: f32,
    /// World space.
    pub(super) places: Vec<Vec3>,
}

impl Subject {
    /// `None` when too little moves to make a picture of. `region` is where most things are.
    pub(super) fn of(frame: &Frame, region: &Region) -> Option<Self> {
        let objects = moving_objects(frame);
        let is_all = is_all(frame, &objects);
        let chosen = if is_all { objects } else { group(&objects, PART_OF_THE_WORLD * region.radius()) };
        // One thing that moves is no scene: it is either all there is, or lost in it.
        if chosen.len() < 2 {
            return None;
        }
        let (min, max) = around(&chosen);
        let sampled: Vec<&MovingObject> = chosen.iter().step_by(chosen.len().div_ceil(MAX_OBJECTS)).collect();
        let each = (PLACES / sampled.len()).clamp(4, 24);
        let objects: Vec<SampledObject> =
            sampled.into_iter().map(|object| SampledObject::of(frame, object, each)).collect();
        Some(Self { objects, min, max, is_all })
    }

    pub(super) fn center(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// From the middle to a face, per axis.
    pub(super) fn half(&self) -> Vec3 {
        self.max * 0.5 - self.min * 0.5
    }
}

impl SampledObject {
    fn of(frame: &Frame, object: &MovingObject, count: usize) -> Self {
        let mut places = Vec::new();
        let triangles = |part: &u32| frame.snapshot.instance_at(*part).triangles().len();
        let stride = object.parts.iter().map(triangles).sum::<usize>().div_ceil(count).max(1);
        // Where the next place lies, counted from the first triangle of the part.
        let mut next = stride / 2;
        for &part in &object.parts {
            let instance = frame.snapshot.instance_at(part);
            while next < instance.triangles().len() {
                let corners = instance.triangles()[next].map(|vertex| {
                    Vec3::from(instance.world_from_object().transform_point(instance.positions()[vertex as usize]))
                });
                places.push(corners.iter().sum::<Vec3>() / 3.0);
                next += stride;
            }
            next -= instance.triangles().len();
        }
        Self { center: object.center(), size: object.size(), places }
    }
}

/// Whether there is nothing to see but what moves.
fn is_all(frame: &Frame, objects: &[MovingObject]) -> bool {
    let total: usize = frame.snapshot.instances().map(|instance| instance.triangles().len()).sum();
    let (min, max) = around(objects);
    let everything = frame.snapshot.bounds();
    let all = Vec3::from(everything.max).distance(everything.min.into());
    triangles(objects) > NEARLY_ALL * total as f32 && min.distance(max) > ALL_ROUND * all
}

/// The densest group of bodies up to some size, if it is more than decoration.
fn group(objects: &[MovingObject], largest: f32) -> Vec<MovingObject> {
    let objects: Vec<MovingObject> = objects.iter().filter(|object| object.size() < largest).cloned().collect();
    let group = densest(&objects);
    if triangles(&group) >= WORTH_A_LOOK * triangles(&objects) { group } else { Vec::new() }
}

fn triangles(objects: &[MovingObject]) -> f32 {
    objects.iter().map(|object| object.triangles).sum::<usize>() as f32
}

/// The box around bodies.
fn around(objects: &[MovingObject]) -> (Vec3, Vec3) {
    objects
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), object| (min.min(object.min), max.max(object.max)))
}

/// The body with most around it, and those around it.
fn densest(objects: &[MovingObject]) -> Vec<MovingObject> {
    let mut best: Option<(f32, &MovingObject)> = None;
    for seed in objects {
        // What is small beside the seed counts little, so that a train does not gather birds.
        let weight = neighbours(objects, seed).map(|object| (object.size() / seed.size()).min(1.0)).sum();
        // The first of equals stays.
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
