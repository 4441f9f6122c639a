//! Rays that start outside the scene: from the camera, and along the axes.

use glam::Vec3;

use crate::ray::Ray;
use crate::rng::Rng;
use crate::scene::PinholeCamera;
use crate::soup::Soup;

/// Pixels along the side of a tile.
const TILE: usize = 8;

/// One ray through the centre of each pixel of a square picture of about `count` pixels, tile by
/// tile.
pub(crate) fn primary(camera: &PinholeCamera, count: usize) -> Vec<Ray> {
    let tiles = (((count as f64).sqrt() / TILE as f64).round() as usize).max(1);
    let side = tiles * TILE;
    let pixel = |x: usize, y: usize| {
        let [x, y] = [x, y].map(|i| (2 * i + 1) as f32 / side as f32 - 1.0);
        Ray::new(camera.position, (camera.forward + camera.right * x - camera.up * y).normalize())
    };
    let mut rays = Vec::with_capacity(side * side);
    for tile in 0..tiles * tiles {
        let (left, top) = (tile % tiles * TILE, tile / tiles * TILE);
        rays.extend((0..TILE * TILE).map(|at| pixel(left + at % TILE, top + at / TILE)));
    }
    rays
}

/// Rays along the axes, in both directions, from just outside the scene's bounding box.
pub(crate) fn axis_parallel(soup: &Soup, count: usize, seed: u64) -> Vec<Ray> {
    let bounds = soup.bounds();
    let (min, extent) = (Vec3::from(bounds.min), Vec3::from(bounds.extent()));
    let outside = extent.max_element() * 0.01;
    let mut rng = Rng::new(seed, 0xa715);
    (0..count)
        .map(|i| {
            let axis = i * 3 / count.max(1);
            let forwards = i % 2 == 0;
            let mut origin = (min + extent * Vec3::new(rng.uniform(), rng.uniform(), rng.uniform())).to_array();
            origin[axis] = if forwards { bounds.min[axis] - outside } else { bounds.max[axis] + outside };
            let mut direction = [0.0; 3];
            direction[axis] = if forwards { 1.0 } else { -1.0 };
            Ray { origin, t_max: f32::INFINITY, direction }
        })
        .collect()
}
