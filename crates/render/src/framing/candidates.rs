//! Cameras worth trying.

use std::f32::consts::PI;

use glam::Vec3;

use super::region::Region;
use crate::Camera;

/// Vertical field of view of cameras that look at the region, radians.
pub(super) const OUTSIDE_FOV: f32 = 0.75;
/// Vertical field of view of cameras that stand in the region, radians.
const INSIDE_FOV: f32 = 1.15;

/// Azimuths in the order in which they are tried, in turns: a little from the side first.
const AZIMUTHS: [f32; 8] = [0.09, 0.91, 0.16, 0.84, 0.34, 0.66, 0.41, 0.59];

/// Around the region, a little above, near and far.
pub(super) fn around(region: &Region, aspect: f32) -> Vec<Camera> {
    let half_fov = 0.5 * OUTSIDE_FOV;
    let narrow = (half_fov.tan() * aspect).atan().min(half_fov);
    let mut cameras = Vec::new();
    for elevation in [0.3, 0.55] {
        for closeness in [1.05, 0.85, 0.65] {
            for azimuth in AZIMUTHS {
                let toward = direction(azimuth, elevation);
                // What is seen of the region from there is no wider than its shadow in that direction.
                let distance = closeness * shadow(region.half(), toward) / narrow.sin();
                let eye = region.center() + toward * distance.max(1e-5);
                cameras.push(Camera::look_at(eye.into(), region.center().into(), OUTSIDE_FOV));
            }
        }
    }
    cameras
}

/// Inside the region: in the middle and towards the sides, at the height of the middle and above, looking across.
pub(super) fn inside(region: &Region) -> Vec<Camera> {
    let mut cameras = Vec::new();
    for height in [0.15, 0.5, -0.2] {
        for reach in [0.85, 0.6, 0.25] {
            for azimuth in AZIMUTHS {
                let away = direction(azimuth, 0.0) * reach * region.half();
                let eye = region.center() + away + Vec3::Y * height * region.half().y;
                let target = region.center() - away * 0.5 - Vec3::Y * 0.15 * region.half().y;
                cameras.push(Camera::look_at(eye.into(), target.into(), INSIDE_FOV));
            }
        }
    }
    cameras
}

/// Unit vector; azimuth in turns from +z towards +x, elevation in radians.
pub(super) fn direction(azimuth: f32, elevation: f32) -> Vec3 {
    let (sin, cos) = (azimuth * 2.0 * PI).sin_cos();
    Vec3::new(sin * elevation.cos(), elevation.sin(), cos * elevation.cos())
}

/// Radius of a box of half extents `half` as seen along a unit vector, about: its half diagonal across the view.
pub(super) fn shadow(half: Vec3, along: Vec3) -> f32 {
    let depth = half.dot(along.abs());
    (half.length_squared() - 0.5 * depth * depth).max(0.0).sqrt()
}
