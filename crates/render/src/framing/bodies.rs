//! What moves in a frame, as bodies: a car with its wheels and its driver is one.

use glam::Vec3;
use kinetree::{InstanceView, Motion};
use kinetree_world::Frame;

/// Moving instances looked at, about; of more, every so many.
const MOST_INSTANCES: usize = 2048;
/// By how much of its size a body reaches beyond its box for parts that belong to it.
const REACH: f32 = 0.05;

/// What is larger than this part of a body is one of its own: trees may grow into each other, and
/// remain trees.
const PART: f32 = 0.6;

/// A moving instance with those that belong to it.
#[derive(Debug, Clone)]
pub(super) struct Body {
    /// World space.
    pub(super) min: Vec3,
    pub(super) max: Vec3,
    /// Numbers of the instances in the frame, the largest first.
    pub(super) parts: Vec<u32>,
    /// In all parts.
    pub(super) triangles: usize,
}

impl Body {
    /// The middle of its box.
    pub(super) fn center(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// The diagonal of its box, metres.
    pub(super) fn size(&self) -> f32 {
        (self.max - self.min).length()
    }

    fn holds(&self, part: &Self) -> bool {
        let reach = Vec3::splat(REACH * self.size());
        let center = part.center();
        part.size() < PART * self.size() && center.cmpge(self.min - reach).all() && center.cmple(self.max + reach).all()
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
        let body = Self { min, max, parts: vec![instance.index()], triangles: instance.triangles().len() };
        (body.size().is_finite() && body.size() > 0.0).then_some(body)
    }
}

/// The moving bodies, the largest first.
pub(super) fn moving_bodies(frame: &Frame) -> Vec<Body> {
    let count = frame.snapshot.instances().filter(moves).count();
    let every = count.div_ceil(MOST_INSTANCES).max(1);
    let mut instances: Vec<Body> =
        frame.snapshot.instances().filter(moves).step_by(every).filter_map(|instance| Body::of(&instance)).collect();
    instances.sort_by(|a, b| b.size().total_cmp(&a.size()));
    join(instances)
}

fn moves(instance: &InstanceView<'_>) -> bool {
    instance.motion() != Motion::Static
}

/// Each belongs to the smallest of the larger ones that its middle lies in, if there is one. Takes
/// the largest first.
fn join(instances: Vec<Body>) -> Vec<Body> {
    let mut bodies: Vec<Body> = Vec::new();
    // As they were before anything joined: a row of things does not grow into one.
    let mut alone: Vec<Body> = Vec::new();
    for instance in instances {
        match alone.iter().rposition(|body| body.holds(&instance)) {
            Some(index) => {
                let body = &mut bodies[index];
                (body.min, body.max) = (body.min.min(instance.min), body.max.max(instance.max));
                body.parts.extend(instance.parts);
                body.triangles += instance.triangles;
            }
            None => {
                alone.push(instance.clone());
                bodies.push(instance);
            }
        }
    }
    bodies
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(center: Vec3, half: Vec3, index: u32) -> Body {
        Body { min: center - half, max: center + half, parts: vec![index], triangles: 1 }
    }

    #[test]
    fn wheels_belong_to_their_car_and_cars_to_nobody() {
        let mut blocks = Vec::new();
        for car in 0..3 {
            let center = Vec3::X * 4.2 * car as f32;
            blocks.push(block(center, Vec3::new(2.0, 0.5, 1.0), car));
        }
        for wheel in 0..12 {
            let side = Vec3::new(if wheel % 2 == 0 { 1.4 } else { -1.4 }, -0.4, if wheel % 4 < 2 { 0.9 } else { -0.9 });
            blocks.push(block(Vec3::X * 4.2 * (wheel / 4) as f32 + side, Vec3::splat(0.3), 3 + wheel));
        }
        let bodies = join(blocks);
        assert_eq!(bodies.len(), 3);
        for (car, body) in bodies.iter().enumerate() {
            let wheels: Vec<u32> = (0..4).map(|wheel| 3 + 4 * car as u32 + wheel).collect();
            assert_eq!((body.parts[0], &body.parts[1..]), (car as u32, &wheels[..]));
        }
    }
}
