//! How bright a picture of a frame should be: a light meter that knows what it looks at.
//!
//! Two readings, as photographers take them. The *reflected* one is the middle of what the surfaces
//! in the picture send to the camera; what lies behind everything does not count, so that a sky
//! does not make an object dark. The *incident* one is the light of suns and sky that arrives at
//! these surfaces: it knows white from black, and where daylight reaches the scene the exposure
//! stays near it, so that a white thing is not made grey nor a dark wood bright.
//!
//! Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images" (the middle of the
//! reflected light).

use std::f32::consts::PI;

use glam::Vec3;
use kinetree::Ray;

use crate::camera::CameraProjection;
use crate::color::luminance;
use crate::interaction::SurfaceInteraction;
use crate::lights::LightTable;
use crate::sampler::unit_hash;
use crate::tonemap::{automatic_exposure, exposure_of};
use crate::warp::{Basis, cosine_hemisphere};
use crate::{Camera, Film, Frame, framing};

/// Most rays across and down.
const MOST: [u32; 2] = [96, 54];
/// What is farther away than so many radii of the region of interest is background.
const BACKGROUND: f32 = 12.0;
/// Below this part of the picture there is too little to be measured.
const LEAST_PART: f32 = 0.01;
/// How far the exposure may go from that of the incident light: half a stop up, one stop down.
const MOST_OVER: f32 = 1.5;
const MOST_UNDER: f32 = 0.5;
/// The part of the light of an open place from which daylight is what a scene is lit by.
const OUTDOORS: f32 = 0.15;

/// The exposure for the film of a frame as a camera sees it: see [`tone_map`](crate::tone_map). From
/// what the surfaces in the picture send out, without the background, and in daylight near that of
/// the light that arrives at them.
///
/// Traces some ten thousand rays. The same input gives the same exposure.
pub fn metered_exposure(frame: &Frame, camera: &Camera, film: &Film) -> f32 {
    let projection = CameraProjection::new(camera, film.width() as f32 / film.height().max(1) as f32);
    let reach = BACKGROUND * framing::region_radius(frame).unwrap_or(f32::INFINITY);
    let lights = LightTable::new(frame);
    let [columns, rows] = [film.width().min(MOST[0]), film.height().min(MOST[1])];
    let (mut seen, mut arriving) = (Vec::new(), 0.0);
    for index in 0..columns * rows {
        let [column, row] = [index % columns, index / columns];
        let pixel = [(2 * column + 1) * film.width() / (2 * columns), (2 * row + 1) * film.height() / (2 * rows)];
        let at = [0, 1].map(|axis| (pixel[axis] as f32 + 0.5) / [film.width(), film.height()][axis] as f32);
        let ray = projection.ray(at);
        let Some(hit) = frame.view.closest_hit(&ray).filter(|hit| hit.t <= reach) else { continue };
        let point = SurfaceInteraction::new(frame, &hit, ray.direction.into());
        seen.push(film.pixel(pixel));
        arriving += daylight_at(frame, &lights, &point, index);
    }
    if (seen.len() as f32) < LEAST_PART * (columns * rows) as f32 {
        return automatic_exposure(film);
    }
    let reflected = exposure_of(&seen);
    let arriving = arriving / seen.len() as f32;
    let open = lights.daylight();
    // What a grey card would be exposed by that lies where the surfaces are.
    let incident = PI / arriving;
    if arriving <= 0.0 || !incident.is_finite() {
        reflected
    } else if arriving < OUTDOORS * open {
        reflected.min(MOST_OVER * incident)
    } else {
        reflected.clamp(MOST_UNDER * incident, MOST_OVER * incident)
    }
}

/// Luminance of the irradiance that comes from suns and sky without a bounce: one direction of the
/// hemisphere for the sky, by the cosine, and the middle of each sun.
fn daylight_at(frame: &Frame, lights: &LightTable<'_>, point: &SurfaceInteraction<'_>, seed: u32) -> f32 {
    let is_open = |direction: Vec3| {
        let ray = Ray::new(point.offset_origin(direction).into(), direction.into());
        point.geometric_normal.dot(direction) > 0.0 && !frame.view.occluded(&ray)
    };
    let u = [unit_hash(2 * seed), unit_hash(2 * seed + 1)];
    let direction = Basis::around(point.shading_normal).to_world(cosine_hemisphere(u.into())).normalize();
    let sky = if is_open(direction) { PI * luminance(lights.sky(direction)) } else { 0.0 };
    let suns = lights.suns().map(|(toward, irradiance)| {
        let cosine = point.shading_normal.dot(toward);
        if cosine > 0.0 && is_open(toward) { cosine * luminance(irradiance) } else { 0.0 }
    });
    sky + suns.sum::<f32>()
}
