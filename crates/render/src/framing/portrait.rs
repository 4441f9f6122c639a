//! A camera for moving objects: slightly above them, at a distance at which they are neither too
//! small nor cut off.
//!
//! Some hundreds of cameras around the subject are tried. Visibility rays to points on its objects
//! measure how much of each is in the picture; the best cameras are then judged by statistics of
//! the whole picture.

use glam::Vec2;
use kinetree_world::{Camera, Frame};

use super::candidates::{OUTSIDE_FOV, direction, projected_radius};
use super::screen::{ScreenBounds, ScreenProjection};
use super::subject::Subject;
use super::view_statistics::{ViewStatistics, is_visible};

/// Number of directions from which cameras are tried.
const AZIMUTHS: u32 = 20;
/// Elevations of cameras, radians: low ones show the horizon, high ones see over what is in front.
const ELEVATIONS: [f32; 4] = [0.18, 0.25, 0.34, 0.43];
/// Distances, relative to that at which the subject just fits.
const DISTANCES: [f32; 6] = [0.45, 0.6, 0.8, 1.05, 1.4, 1.9];
/// The number of cameras that are judged by the whole picture.
const FINALISTS: usize = 40;
/// The part of an object's points that can be visible at once; the others are on its far side.
const MAX_VISIBLE: f32 = 0.4;
/// An object is recognisable when its size is this part of the picture's width.
const RECOGNISED: f32 = 0.08;
/// Objects that take up more of the width are in the foreground.
const FOREGROUND: f32 = 0.3;
/// Points beyond this coordinate are cut off; the edge of the picture is at 1.
const MARGIN: f32 = 0.96;
/// How far the centre of the picture is above the centre of a group, in halves of the picture's
/// height.
const RAISED: f32 = 0.12;
/// The part of the picture's width or height that the subject should take up, if it is everything
/// or a group.
const FILLED_BY_ALL: f32 = 0.85;
const FILLED_BY_GROUP: f32 = 0.5;
/// Below this visibility a subject counts as hidden.
const HIDDEN: f32 = 0.2;

/// The best camera; `None` if the subject is hidden from all of them.
pub(super) fn portrait(frame: &Frame, subject: &Subject, aspect: f32) -> Option<Camera> {
    let mut cameras: Vec<(f32, Camera)> =
        candidates(subject, aspect).map(|camera| (shown(frame, subject, &camera, aspect), camera)).collect();
    // The sort is stable: of equal cameras the first is kept.
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
        let fits = projected_radius(half, toward) / wide.sin();
        DISTANCES.map(|distance| {
            let eye = center + toward * (distance * fits).max(1e-5);
            aimed(subject, &Camera::look_at(eye.into(), center.into(), OUTSIDE_FOV), aspect)
        })
    })
}

/// The camera turned so that the subject is in the centre of the picture, or slightly below it
/// where the horizon is shown.
fn aimed(subject: &Subject, camera: &Camera, aspect: f32) -> Camera {
    let screen = ScreenProjection::new(camera, aspect);
    let mut extent = ScreenBounds::default();
    for &point in subject.objects.iter().flat_map(|object| &object.points) {
        match screen.project(point) {
            Some(at) => extent.add(at),
            // A camera among the objects looks at their centre.
            None => return *camera,
        }
    }
    let raised = if subject.is_all { Vec2::ZERO } else { Vec2::Y * RAISED };
    let middle = (extent.min + extent.max) * 0.5 + raised;
    if !middle.is_finite() {
        return *camera;
    }
    let target = screen.ray(middle);
    Camera::look_at(screen.eye.into(), (screen.eye + target).into(), camera.fov_y)
}

/// How well a camera shows the objects, from 0 to 1.
fn shown(frame: &Frame, subject: &Subject, camera: &Camera, aspect: f32) -> f32 {
    let screen = ScreenProjection::new(camera, aspect);
    let recognised = recognised(subject);
    let (mut seen, mut cut, mut places, mut crowding) = (0.0, 0.0, 0.0, 0.0_f32);
    let mut extent = ScreenBounds::default();
    for object in &subject.objects {
        let (mut framed, mut open) = (0.0, 0.0);
        for &point in &object.points {
            let Some(at) = screen.project(point).filter(|at| at.abs().max_element() < MARGIN) else { continue };
            framed += 1.0;
            if is_visible(frame, camera, point) {
                open += 1.0;
                extent.add(at);
            }
        }
        let all = (object.points.len() as f32).max(1.0);
        let width = screen.width_of(object);
        seen += (open / all / MAX_VISIBLE).min(1.0) * (width / recognised).min(1.0);
        cut += all - framed;
        places += all;
        crowding = crowding.max(if framed > 0.0 { (width / FOREGROUND - 1.0).clamp(0.0, 1.0) } else { 0.0 });
    }
    let whole = (1.0 - cut / places.max(1.0)).powi(if subject.is_all { 4 } else { 1 });
    let fill = (extent.largest() / if subject.is_all { FILLED_BY_ALL } else { FILLED_BY_GROUP }).min(1.0);
    seen / (subject.objects.len() as f32).max(1.0) * whole * fill * (1.0 - 0.8 * crowding)
}

/// The size at which an object is recognisable: of many objects, not all need to be large.
fn recognised(subject: &Subject) -> f32 {
    RECOGNISED * (8.0 / subject.objects.len().max(1) as f32).sqrt().clamp(0.3, 1.5)
}

/// How good the picture around the objects is.
fn surroundings(frame: &Frame, subject: &Subject, camera: &Camera, aspect: f32) -> f32 {
    let distance = subject.center().distance(camera.position().into());
    let statistics = ViewStatistics::sample(frame, camera, aspect, distance);
    // Some sky or background shows where the subject is; too much of it shows nothing else.
    let far = statistics.far();
    let horizon = if subject.is_all { 1.0 } else { (far / 0.12).min(1.0) * ((1.0 - far) / 0.5).min(1.0) };
    statistics.clearance() * statistics.front_facing() * (0.5 + statistics.variety()) * (0.6 + 0.4 * horizon)
}
