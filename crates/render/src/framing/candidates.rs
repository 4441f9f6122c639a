//! Candidate cameras for the region of interest.

use std::f32::consts::PI;

use glam::Vec3;
use kinetree_world::Camera;

use super::region::{Objects, Region};

/// Vertical field of view of cameras that look at the region, radians.
pub(super) const OUTSIDE_FOV: f32 = 0.75;
/// Vertical field of view of cameras that stand in the region, radians.
const INSIDE_FOV: f32 = 1.15;

/// Azimuths in turns, in the order in which they are tried: slightly from the side first.
const AZIMUTHS: [f32; 8] = [0.09, 0.91, 0.16, 0.84, 0.34, 0.66, 0.41, 0.59];

/// A region of more objects is treated as a place, which cameras may also show from within.
pub(super) const MAX_FEW_OBJECTS: usize = 8;
/// Objects that are shown whole take up this part of the width or height of the picture.
const FILLED: f32 = 0.88;

/// Cameras that see the region from outside.
pub(super) fn outside(region: &Region, aspect: f32) -> Vec<Camera> {
    match region.objects() {
        Some(objects) if objects.count <= MAX_FEW_OBJECTS => fitting(objects, aspect),
        Some(objects) => fitting(objects, aspect).into_iter().chain(orbit(region, aspect)).collect(),
        None => orbit(region, aspect),
    }
}

/// Cameras from all sides, each as near as it can be with all of the objects in the picture.
fn fitting(objects: &Objects, aspect: f32) -> Vec<Camera> {
    let directions =
        [0.2, 0.35, 0.55].into_iter().flat_map(|elevation| AZIMUTHS.map(|turn| direction(turn, elevation)));
    directions.filter_map(|toward| fitted(&objects.corners, toward, aspect)).collect()
}

/// The nearest camera in a direction that has all points in the picture. Along each axis of the
/// picture the points bound two planes through the eye; the eye is where the pair of planes that is
/// farther back meets.
fn fitted(points: &[Vec3], toward: Vec3, aspect: f32) -> Option<Camera> {
    let right = Vec3::Y.cross(toward).normalize();
    let up = toward.cross(right);
    let tangent = FILLED * (0.5 * OUTSIDE_FOV).tan();
    // Coordinates are relative to one of the points, to keep precision for small objects far from
    // the origin.
    let middle = *points.first()?;
    // Coordinate of the eye along the axis, and its distance backwards.
    let fit = |axis: Vec3, tangent: f32| {
        let (mut low, mut high) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
        for &point in points {
            let (along, back) = ((point - middle).dot(axis), (point - middle).dot(toward) * tangent);
            (low, high) = (low.max(back - along), high.max(back + along));
        }
        (0.5 * (high - low), 0.5 * (high + low) / tangent)
    };
    let ((x, back_x), (y, back_y)) = (fit(right, tangent * aspect), fit(up, tangent));
    let back = back_x.max(back_y);
    let eye = middle + right * x + up * y + toward * back;
    let target = eye - toward * back.max(1e-5);
    eye.is_finite().then(|| Camera::look_at(eye.into(), target.into(), OUTSIDE_FOV))
}

/// Cameras around the region, slightly above it, at several distances.
fn orbit(region: &Region, aspect: f32) -> Vec<Camera> {
    let half_fov = 0.5 * OUTSIDE_FOV;
    let narrow = (half_fov.tan() * aspect).atan().min(half_fov);
    let mut cameras = Vec::new();
    for elevation in [0.3, 0.55] {
        for closeness in [1.05, 0.85, 0.65] {
            for azimuth in AZIMUTHS {
                let toward = direction(azimuth, elevation);
                // The region appears no wider than its projected radius in that direction.
                let distance = closeness * projected_radius(region.half(), toward) / narrow.sin();
                let eye = region.center() + toward * distance.max(1e-5);
                cameras.push(Camera::look_at(eye.into(), region.center().into(), OUTSIDE_FOV));
            }
        }
    }
    cameras
}

/// Cameras inside the region: at the centre and towards the sides, at several heights, looking
/// across.
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

/// Approximate radius of a box with half extents `half`, projected along a unit vector: its half
/// diagonal perpendicular to the view.
pub(super) fn projected_radius(half: Vec3, along: Vec3) -> f32 {
    let depth = half.dot(along.abs());
    (half.length_squared() - 0.5 * depth * depth).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinetree_world::CameraProjection;

    #[test]
    fn objects_that_are_shown_whole_touch_the_margin_and_do_not_cross_it() {
        // A tall object, a wide one, and a small one far away.
        for (size, point) in
            [([0.3, 2.0, 0.4], [0.0; 3]), ([9.0, 0.1, 3.0], [5.0, 0.0, 0.0]), ([1e-3; 3], [50.0, 20.0, -70.0])]
        {
            let corner = |i: u32| {
                Vec3::from(
                    [0, 1, 2].map(|axis| point[axis] + if i >> axis & 1 == 0 { -size[axis] } else { size[axis] }),
                )
            };
            let points: Vec<Vec3> = (0..8).map(corner).collect();
            for turn in AZIMUTHS {
                for aspect in [0.5, 1.0, 16.0 / 9.0] {
                    let camera = fitted(&points, direction(turn, 0.35), aspect).expect("there are points");
                    let within = |part: f32| {
                        let fov_y = 2.0 * (part * (0.5 * camera.fov_y).tan()).atan();
                        let projection = CameraProjection::new(&Camera { fov_y, ..camera }, aspect);
                        points.iter().filter(|&&point| projection.contains(point)).count()
                    };
                    assert!(within(FILLED + 0.02) == 8 && within(FILLED - 0.02) < 8, "{size:?} {turn} {aspect}");
                }
            }
        }
    }
}
