//! Automatic exposure that takes the scene into account, from two readings of a light meter.
//!
//! The *reflected* reading is the log-average luminance of the surfaces in the picture; the
//! background is left out, so that a bright sky does not make an object dark. The *incident*
//! reading is the irradiance of suns and sky at these surfaces, which does not depend on their
//! reflectance. Where daylight reaches the scene the exposure stays near the incident reading, so
//! that white objects are not exposed as grey, nor dark ones as bright.
//!
//! Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images" (log-average
//! luminance).

use std::f32::consts::PI;

use glam::Vec3;
use kinetree::Ray;
use kinetree_world::{Camera, CameraProjection, Frame};

use crate::color::luminance;
use crate::interaction::SurfaceInteraction;
use crate::lights::LightTable;
use crate::sampler::unit_hash;
use crate::tonemap::{automatic_exposure, exposure_of};
use crate::warp::{Basis, cosine_hemisphere};
use crate::{Film, framing};

/// Largest numbers of rays across and down.
const MAX_RAYS: [u32; 2] = [96, 54];
/// Surfaces farther away than this multiple of the radius of the region of interest are background.
const BACKGROUND: f32 = 12.0;
/// Below this part of the picture there are too few surfaces to be metered.
const MIN_COVERAGE: f32 = 0.01;
/// The range of the exposure over that of the incident reading: half a stop up, one stop down.
const MAX_OVEREXPOSURE: f32 = 1.5;
const MIN_UNDEREXPOSURE: f32 = 0.5;
/// The part of the unoccluded daylight above which a scene counts as lit by daylight.
const OUTDOORS: f32 = 0.15;

/// The exposure, for [`tone_map`](crate::tone_map), of a film that shows a frame through a camera:
/// from the light that the surfaces in the picture reflect, and in daylight near that of the light
/// that arrives at them.
///
/// Traces some ten thousand rays. The same input gives the same exposure.
pub fn metered_exposure(frame: &Frame, camera: &Camera, film: &Film) -> f32 {
    let projection = CameraProjection::new(camera, film.width() as f32 / film.height().max(1) as f32);
    let reach = BACKGROUND * framing::region_radius(frame).unwrap_or(f32::INFINITY);
    let lights = LightTable::new(frame);
    let [columns, rows] = [film.width().min(MAX_RAYS[0]), film.height().min(MAX_RAYS[1])];
    let (mut metered, mut irradiance) = (Vec::new(), 0.0);
    for index in 0..columns * rows {
        let [column, row] = [index % columns, index / columns];
        let pixel = [(2 * column + 1) * film.width() / (2 * columns), (2 * row + 1) * film.height() / (2 * rows)];
        let at = [0, 1].map(|axis| (pixel[axis] as f32 + 0.5) / [film.width(), film.height()][axis] as f32);
        let ray = projection.ray(at);
        let Some(hit) = frame.snapshot.closest_hit(&ray).filter(|hit| hit.t <= reach) else { continue };
        let point = SurfaceInteraction::new(frame, &hit, ray.direction.into());
        metered.push(film.pixel(pixel));
        irradiance += daylight_at(frame, &lights, &point, index);
    }
    if (metered.len() as f32) < MIN_COVERAGE * (columns * rows) as f32 {
        return automatic_exposure(film);
    }
    let reflected = exposure_of(&metered);
    let irradiance = irradiance / metered.len() as f32;
    let unoccluded = lights.daylight();
    // The exposure that makes a white diffuse surface at these places 1.
    let incident = PI / irradiance;
    if irradiance <= 0.0 || !incident.is_finite() {
        reflected
    } else if irradiance < OUTDOORS * unoccluded {
        reflected.min(MAX_OVEREXPOSURE * incident)
    } else {
        reflected.clamp(MIN_UNDEREXPOSURE * incident, MAX_OVEREXPOSURE * incident)
    }
}

/// Luminance of the direct irradiance of suns and sky at a point: one cosine-weighted direction for
/// the sky, and the centre of each sun.
fn daylight_at(frame: &Frame, lights: &LightTable<'_>, point: &SurfaceInteraction<'_>, seed: u32) -> f32 {
    let is_open = |direction: Vec3| {
        let ray = Ray::new(point.offset_origin(direction).into(), direction.into());
        point.geometric_normal.dot(direction) > 0.0 && !frame.snapshot.occluded(&ray)
    };
    let u = [unit_hash(2 * seed), unit_hash(2 * seed + 1)];
    let direction = Basis::around(point.shading_normal).to_world(cosine_hemisphere(u.into())).normalize();
    let sky = if is_open(direction) { PI * luminance(lights.sky(direction)) } else { 0.0 };
    let suns = lights.suns().map(|(toward, sun)| {
        let cosine = point.shading_normal.dot(toward);
        if cosine > 0.0 && is_open(toward) { cosine * luminance(sun) } else { 0.0 }
    });
    sky + suns.sum::<f32>()
}
