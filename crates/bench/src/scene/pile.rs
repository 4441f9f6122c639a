//! Overlapping spheres of many sizes, so that boxes overlap everywhere.

use glam::Vec3;

use super::shapes::sphere;
use crate::rng::Rng;
use crate::soup::Soup;

/// How often each edge of a sphere's octahedron is divided.
const CUTS: usize = 16;

/// About this many triangles.
pub(crate) fn pile(seed: u64, triangles: usize) -> Soup {
    let mut rng = Rng::new(seed, 2);
    let mut soup = Soup::default();
    let (ball, faces) = sphere(CUTS);
    for _ in 0..triangles.div_ceil(faces.len()) {
        let radius = 0.05 + 0.25 * rng.uniform() * rng.uniform();
        let middle = Vec3::new(rng.between(-1.0, 1.0), rng.between(-0.5, 0.5), rng.between(-1.0, 1.0));
        soup.add(ball.iter().map(|p| middle + *p * radius), &faces);
    }
    soup
}
