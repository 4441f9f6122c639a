//! A camera for what moves: from a little above it, at the distance from which it is neither lost
//! nor too much.
//!
//! Some hundreds of cameras stand around the subject. Rays to places on its bodies tell how much of
//! each is in the picture and open to sight; the best of the cameras are then judged by the whole
//! of what they see.

use glam::Vec2;
use kinetree_world::{Camera, Frame};

use super::candidates::{OUTSIDE_FOV, direction, shadow};
use super::picture::{Extent, Picture};
use super::subject::Subject;
use super::view_statistics::{ViewStatistics, is_visible};

/// Directions in which cameras stand.
const AZIMUTHS: u32 = 20;
/// Elevations of cameras, radians: low ones have the horizon in the picture, high ones see over
/// what is in front.
const ELEVATIONS: [f32; 4] = [0.18, 0.25, 0.34, 0.43];
/// Distances, over that from which the subject just fits.
const DISTANCES: [f32; 6] = [0.45, 0.6, 0.8, 1.05, 1.4, 1.9];
/// How many cameras are looked through.
const FINALISTS: usize = 40;
/// The part of a body's places that can be seen at once; the others are on its far side.
const MOST_SHOWN: f32 = 0.4;
/// A body is recognised when its size is this part of the picture's width.
const RECOGNISED: f32 = 0.08;
/// Bodies that take more of the width stand in the foreground.
const FOREGROUND: f32 = 0.3;
/// Places nearer to the edge of the picture, which is at 1, are cut off.
const MARGIN: f32 = 0.96;
/// By how much the middle of a picture lies above the middle of a group, in halves of the picture's
/// height.
const RAISED: f32 = 0.12;
/// The part of the width or height of the picture that the subject takes up at least.
const FILLED_BY_ALL: f32 = 0.85;
const FILLED_BY_GROUP: f32 = 0.5;
/// Below this a subject is not to be seen.
const HIDDEN: f32 = 0.2;

/// The best camera, or none if the subject cannot be seen well from anywhere near.
pub(super) fn portrait(frame: &Frame, subject: &Subject, aspect: f32) -> Option<Camera> {
    let mut cameras: Vec<(f32, Camera)> =
        candidates(subject, aspect).map(|camera| (shown(frame, subject, &camera, aspect), camera)).collect();
    // Stable: the first of equals stays.
    cameras.sort_by(|a, b| b.0.total_cmp(&a.0));
    cameras.truncate(FINALISTS);
    let mut best: Option<(f32, Camera)> = None;
    for (shown, camera) in cameras.into_iter().filter(|&(shown, _)| shown > HIDDEN) {
        let score = shown * surroundings(frame, subject, &camera, aspect);
        if best.is_none_or(|(most, _)| score > most) {
            best = Some((score, camera));
        }
    }
    best.map(|(_, camera)| camera)
}

fn candidates(subject: &Subject, aspect: f32) -> impl Iterator<Item = Camera> {
    let (center, half) = (subject.center(), subject.half());
    let half_fov = 0.5 * OUTSIDE_FOV;
    let wide = (half_fov.tan() * aspect).atan().min(half_fov * 1.5);
    let turns = (0..AZIMUTHS).map(|index| (index as f32 + 0.3) / AZIMUTHS as f32);
    let directions = turns.flat_map(|turn| ELEVATIONS.map(|elevation| direction(turn, elevation)));
    directions.flat_map(move |toward| {
        let fits = shadow(half, toward) / wide.sin();
        DISTANCES.map(|distance| {
            let eye = center + toward * (distance * fits).max(1e-5);
            aimed(subject, &Camera::look_at(eye.into(), center.into(), OUTSIDE_FOV), aspect)
        })
    })
}

/// Turned so that the subject is in the middle of the picture, or a little below where there is a
/// horizon to be seen.
fn aimed(subject: &Subject, camera: &Camera, aspect: f32) -> Camera {
    let picture = Picture::new(camera, aspect);
    let mut extent = Extent::default();
    for &place in subject.objects.iter().flat_map(|object| &object.places) {
        match picture.project(place) {
            Some(at) => extent.add(at),
            // Who stands among the bodies looks at their middle.
            None => return *camera,
        }
    }
    let raised = if subject.is_all { Vec2::ZERO } else { Vec2::Y * RAISED };
    let middle = (extent.min + extent.max) * 0.5 + raised;
    if !middle.is_finite() {
        return *camera;
    }
    let target = picture.ray(middle);
    Camera::look_at(picture.eye.into(), (picture.eye + target).into(), camera.fov_y)
}

/// How well a camera shows the bodies, from 0 to 1.
fn shown(frame: &Frame, subject: &Subject, camera: &Camera, aspect: f32) -> f32 {
    let picture = Picture::new(camera, aspect);
    let recognised = recognised(subject);
    let (mut seen, mut cut, mut places, mut crowding) = (0.0, 0.0, 0.0, 0.0_f32);
    let mut extent = Extent::default();
    for object in &subject.objects {
        let (mut framed, mut open) = (0.0, 0.0);
        for &place in &object.places {
            let Some(at) = picture.project(place).filter(|at| at.abs().max_element() < MARGIN) else { continue };
            framed += 1.0;
            if is_visible(frame, camera, place) {
                open += 1.0;
                extent.add(at);
            }
        }
        let all = (object.places.len() as f32).max(1.0);
        let width = picture.width_of(object);
        seen += (open / all / MOST_SHOWN).min(1.0) * (width / recognised).min(1.0);
        cut += all - framed;
        places += all;
        crowding = crowding.max(if framed > 0.0 { (width / FOREGROUND - 1.0).clamp(0.0, 1.0) } else { 0.0 });
    }
    let whole = (1.0 - cut / places.max(1.0)).powi(if subject.is_all { 4 } else { 1 });
    let fill = (extent.largest() / if subject.is_all { FILLED_BY_ALL } else { FILLED_BY_GROUP }).min(1.0);
    seen / (subject.objects.len() as f32).max(1.0) * whole * fill * (1.0 - 0.8 * crowding)
}

/// Many bodies need not all be large.
fn recognised(subject: &Subject) -> f32 {
    RECOGNISED * (8.0 / subject.objects.len().max(1) as f32).sqrt().clamp(0.3, 1.5)
}

/// How good the picture around the bodies is.
fn surroundings(frame: &Frame, subject: &Subject, camera: &Camera, aspect: f32) -> f32 {
    let distance = subject.center().distance(camera.position().into());
    let statistics = ViewStatistics::sample(frame, camera, aspect, distance);
    // Some sky or distance says where one is; a picture of nothing else says nothing.
    let far = statistics.far();
    let horizon = if subject.is_all { 1.0 } else { (far / 0.12).min(1.0) * ((1.0 - far) / 0.5).min(1.0) };
    statistics.clearance() * statistics.front_facing() * (0.5 + statistics.variety()) * (0.6 + 0.4 * horizon)
}
