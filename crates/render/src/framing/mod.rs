//! The default camera for worlds without cameras.
//!
//! If something moves, the picture shows it: `moving_objects` finds what moves, `subject` chooses
//! the group to be shown, and `portrait` the camera that shows it best.
//!
//! If nothing moves, or it cannot be seen, the picture shows the region of interest, where most of
//! the surface area is; areas are weighted so that a few huge or distant triangles do not decide
//! (`region`). Some dozens of `candidates` are tried, around the region and inside it; each is
//! scored by a few hundred rays (`score`), and the camera that sees most of the region, in most
//! variety, is chosen. So a car on a plain is shown from outside, as a whole, and a kitchen from
//! within.

mod backdrop;
mod moving_objects;
mod candidates;
mod dense;
mod screen;
mod portrait;
mod region;
mod samples;
mod score;
mod view_statistics;
mod subject;

use glam::Vec3;
use kinetree_world::{Camera, Frame};

use region::Region;
use score::Score;
use subject::Subject;

/// A camera that shows what moves in a frame, or else the region of interest. The same frame and
/// aspect (width over height) give the same camera.
///
/// Tries some hundreds of cameras with a few hundred rays each. A frame without triangles gets a
/// fixed camera.
pub fn default_camera(frame: &Frame, aspect: f32) -> Camera {
    let Some(region) = Region::of(frame) else {
        return Camera::look_at([3.0, 2.0, 4.0], [0.0; 3], candidates::OUTSIDE_FOV);
    };
    let aspect = if aspect.is_finite() { aspect.clamp(0.1, 10.0) } else { 1.0 };
    let portrait = Subject::of(frame, &region).and_then(|subject| portrait::portrait(frame, &subject, aspect));
    portrait.unwrap_or_else(|| overview(frame, &region, aspect))
}

/// If more than this part of the region is visible from outside, and it consists of few objects, no
/// camera inside it is tried.
const SEEN_FROM_OUTSIDE: f32 = 0.2;

/// The camera that shows a region best.
fn overview(frame: &Frame, region: &Region, aspect: f32) -> Camera {
    let best_of = |cameras: Vec<Camera>| {
        let mut best: Option<(Score, Camera)> = None;
        for camera in cameras {
            let score = score::score(frame, region, &camera, aspect);
            // Of equal scores the first is kept.
            if best.is_none_or(|(most, _)| score.value > most.value) {
                best = Some((score, camera));
            }
        }
        best
    };
    let outside = best_of(candidates::outside(region, aspect));
    let is_of_objects = region.objects().is_some_and(|objects| objects.count <= candidates::MAX_FEW_OBJECTS);
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
