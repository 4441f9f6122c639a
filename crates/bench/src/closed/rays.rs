//! Rays from inside a shape, mostly in directions where tracers err: to edges and corners, along
//! the shape, along axes, with slopes close to zero.

use glam::Vec3;

use super::shape::Shape;
use crate::ray::Ray;
use crate::rng::Rng;

/// Half of the packets of this many rays share one origin and a target ring; the rays of the others
/// are independent.
const PACKET: usize = 64;

/// Rays for shape `number` of a seed.
pub(super) fn rays(shape: &Shape, count: usize, seed: u64, number: u64) -> Vec<Ray> {
    let mut rng = Rng::new(seed, number << 8 | 0xc2);
    let mut rays = Vec::with_capacity(count);
    while rays.len() < count {
        let coherent = rng.below(2) == 0;
        let shared = (origin(shape, &mut rng), f64::from(rng.between(-1.0, 1.0)));
        for _ in 0..PACKET.min(count - rays.len()) {
            let (from, along) =
                if coherent { shared } else { (origin(shape, &mut rng), f64::from(rng.between(-1.0, 1.0))) };
            rays.push(Ray::new(from, direction(shape, from, along, &mut rng)));
        }
    }
    rays
}

fn origin(shape: &Shape, rng: &mut Rng) -> Vec3 {
    let outwards = match rng.below(4) {
        0 => 0.99,
        _ => f64::from(rng.between(0.0, 0.95)),
    };
    shape.inside(rng, outwards)
}

/// A direction that is finite and not zero.
fn direction(shape: &Shape, from: Vec3, along: f64, rng: &mut Rng) -> Vec3 {
    loop {
        let direction = match rng.below(8) {
            0 => rng.direction(),
            1 => nearly_straight(shape, rng),
            2 | 3 => shape.side(rng, along) - from,
            // A point of the wall beside the origin.
            4 => shape.side(rng, shape.along(from)) - from,
            _ => shape.edge(rng) - from,
        };
        let direction = if rng.below(2) == 0 { direction.normalize_or_zero() } else { direction };
        if direction.is_finite() && direction != Vec3::ZERO {
            return direction;
        }
    }
}

/// Along an axis of the world or of the shape, with slopes that are zero or tiny.
fn nearly_straight(shape: &Shape, rng: &mut Rng) -> Vec3 {
    let sign = if rng.below(2) == 0 { 1.0 } else { -1.0 };
    let mut direction = if rng.below(2) == 0 { shape.axis() } else { Vec3::AXES[rng.below(3)] } * sign;
    for axis in 0..3 {
        let slope = [0.0, -0.0, 1e-42, 1e-30, 1e-7, 1e-4][rng.below(6)];
        direction[axis] += if rng.below(2) == 0 { slope } else { -slope };
    }
    direction
}
