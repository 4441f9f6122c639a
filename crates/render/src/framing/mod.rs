//! A camera for who brings none.
//!
//! Where something moves, that is what the picture is about: `moving_objects` finds what moves, `subject`
//! the group to be shown, and `portrait` the camera that shows it best. Where nothing does, or it
//! cannot be seen, the place itself is shown. Where most of the surface is, weighed so that a few
//! huge or far triangles do not decide, is the region of interest. Some dozens of cameras are
//! tried, around it and inside it; each looks with a few hundred rays, and the one that sees most
//! of the region, in most variety, is taken. So a car on a plain is seen from outside, as a whole,
//! and a kitchen from within.

mod backdrop;
mod moving_objects;
mod candidates;
mod picture;
mod portrait;
mod region;
mod score;
mod view_statistics;
mod subject;

use glam::Vec3;
use kinetree_world::{Camera, Frame};

use region::Region;
use score::Score;
use subject::Subject;

/// A camera that shows what moves in a frame, or else the middle of it. The same frame and aspect
/// (width over height) give the same camera.
///
/// Tries some hundreds of cameras with a few hundred rays each. A frame without triangles is seen
/// from some way off.
pub fn default_camera(frame: &Frame, aspect: f32) -> Camera {
    let Some(region) = Region::of(frame) else {
        return Camera::look_at([3.0, 2.0, 4.0], [0.0; 3], candidates::OUTSIDE_FOV);
    };
    let aspect = if aspect.is_finite() { aspect.clamp(0.1, 10.0) } else { 1.0 };
    let portrait = Subject::of(frame, &region).and_then(|subject| portrait::portrait(frame, &subject, aspect));
    portrait.unwrap_or_else(|| overview(frame, &region, aspect))
}

/// Objects of which this part is seen from outside are looked at from there; less is seen of a
/// room.
const SEEN_FROM_OUTSIDE: f32 = 0.2;

/// The camera that shows a region best.
fn overview(frame: &Frame, region: &Region, aspect: f32) -> Camera {
    let best_of = |cameras: Vec<Camera>| {
        let mut best: Option<(Score, Camera)> = None;
        for camera in cameras {
            let score = score::score(frame, region, &camera, aspect);
            // The first of equals stays.
            if best.is_none_or(|(most, _)| score.value > most.value) {
                best = Some((score, camera));
            }
        }
        best
    };
    let outside = best_of(candidates::outside(region, aspect));
    let is_of_objects = region.objects().is_some_and(|objects| objects.count <= candidates::FEW);
    let inside = match outside {
        Some((score, _)) if is_of_objects && score.value > 0.0 && score.shown > SEEN_FROM_OUTSIDE => None,
        _ => best_of(candidates::inside(region)),
    };
    let best = match (outside, inside) {
        (Some(outside), Some(inside)) if inside.0.value > outside.0.value => Some(inside),
        (outside, inside) => outside.or(inside),
    };
    best.map_or_else(
        || Camera::look_at((region.center() + Vec3::ONE * region.radius()).into(), region.center().into(), 0.8),
        |(_, camera)| camera,
    )
}

/// The radius of the region of interest, metres; `None` for a frame without triangles.
pub(crate) fn region_radius(frame: &Frame) -> Option<f32> {
    Region::of(frame).map(|region| region.radius())
}
