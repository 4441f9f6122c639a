//! A camera for who brings none.
//!
//! Where most of the surface is, weighed so that a few huge or far triangles do not decide, is the region of interest.
//! Some dozens of cameras are tried, around it and inside it; each looks with a few hundred rays, and the one that sees
//! most of the region, in most variety, is taken. So a car on a plain is seen from outside, and a kitchen from within.

mod candidates;
mod region;
mod score;

use glam::Vec3;

use crate::{Camera, Frame};
use region::Region;

/// A camera that shows the middle of a frame well. The same frame and aspect (width over height) give the same camera.
///
/// Tries some dozens of cameras with a few hundred rays each. A frame without triangles is seen from some way off.
pub fn default_camera(frame: &Frame, aspect: f32) -> Camera {
    let Some(region) = Region::of(frame) else {
        return Camera::look_at([3.0, 2.0, 4.0], [0.0; 3], candidates::OUTSIDE_FOV);
    };
    let aspect = if aspect.is_finite() { aspect.clamp(0.1, 10.0) } else { 1.0 };
    let mut best: Option<(f32, Camera)> = None;
    for camera in candidates::around(&region, aspect).into_iter().chain(candidates::inside(&region)) {
        let score = score::score(frame, &region, &camera, aspect);
        // The first of equals stays.
        if best.is_none_or(|(most, _)| score > most) {
            best = Some((score, camera));
        }
    }
    best.map_or_else(
        || Camera::look_at((region.center() + Vec3::ONE * region.radius()).into(), region.center().into(), 0.8),
        |(_, camera)| camera,
    )
}
