//! Statistics of what a camera sees, from a coarse grid of rays.

use glam::Vec3;
use kinetree::Ray;
use kinetree_world::{Camera, CameraProjection, Frame};

use crate::interaction::SurfaceInteraction;
use crate::sampler::combine;

/// Numbers of rays across and down.
const GRID: [u32; 2] = [32, 18];
/// The number of rays.
const RAYS: f32 = (GRID[0] * GRID[1]) as f32;
/// Surfaces nearer than this multiple of the scale of the subject obstruct the view.
const NEAR: f32 = 0.35;
/// Surfaces farther than this multiple of that scale are background.
const FAR: f32 = 4.0;

/// Statistics of the first hits of a grid of camera rays.
#[derive(Debug, Default)]
pub(super) struct ViewStatistics {
    /// Positions of the hits, world space.
    positions: Vec<Vec3>,
    /// Sum of how near obstructing hits are, with double weight in the middle of the picture.
    blocked: f32,
    /// Number of hits on back faces.
    back: f32,
    /// Number of rays that hit the background or nothing.
    far: f32,
    /// A hash of the triangle of each hit.
    triangles: Vec<u32>,
    /// The dense instance index of each hit.
    instances: Vec<u32>,
    /// The quantised normal of each hit.
    facings: Vec<u32>,
    /// The quantised logarithm of the distance of each hit.
    depths: Vec<u32>,
}

/// Whether a point on a surface is visible from a camera. The last hundredth of the distance is not
/// tested, so that the surface itself does not occlude it.
pub(super) fn is_visible(frame: &Frame, camera: &Camera, point: Vec3) -> bool {
    let eye = Vec3::from(camera.position());
    !frame.snapshot.occluded(&Ray::new(eye.into(), (point - eye).into()).with_range(0.0, 0.99))
}

impl ViewStatistics {
    /// Traces the grid of rays. `scale` is the size of the subject, or its distance, metres.
    pub(super) fn sample(frame: &Frame, camera: &Camera, aspect: f32, scale: f32) -> Self {
        let projection = CameraProjection::new(camera, aspect);
        let mut statistics = Self::default();
        for row in 0..GRID[1] {
            for column in 0..GRID[0] {
                let at = [(column as f32 + 0.5) / GRID[0] as f32, (row as f32 + 0.5) / GRID[1] as f32];
                let ray = projection.ray(at);
                if let Some(hit) = frame.snapshot.closest_hit(&ray) {
                    let point = SurfaceInteraction::new(frame, &hit, ray.direction.into());
                    let in_middle = (at[0] - 0.5).abs() < 0.25 && (at[1] - 0.5).abs() < 0.25;
                    statistics.add(&point, hit.t / scale, in_middle);
                } else {
                    statistics.far += 1.0;
                }
            }
        }
        statistics
    }

    fn add(&mut self, point: &SurfaceInteraction<'_>, distance: f32, in_middle: bool) {
        self.positions.push(point.position);
        self.back += f32::from(u8::from(!point.front));
        self.far += f32::from(u8::from(distance > FAR));
        let nearness = (1.0 - distance / NEAR).max(0.0);
        self.blocked += nearness * if in_middle { 2.0 } else { 1.0 };
        self.triangles.push(combine(point.instance, point.primitive));
        self.instances.push(point.instance);
        self.facings.push(facing(point.geometric_normal));
        self.depths.push((distance.max(1e-6).log2() * 2.0 + 100.0) as u32);
    }

    /// The part of the picture whose hits satisfy a condition.
    pub(super) fn part_within(&self, contains: impl Fn(Vec3) -> bool) -> f32 {
        self.positions.iter().filter(|&&position| contains(position)).count() as f32 / RAYS
    }

    /// The part of the picture that shows background or nothing.
    pub(super) fn far(&self) -> f32 {
        self.far / RAYS
    }

    /// 1 when nothing near the camera obstructs the view, 0 when everything is obstructed.
    pub(super) fn clearance(&self) -> f32 {
        (1.0 - self.blocked / RAYS).max(0.0)
    }

    /// The part of the hits that are on front faces.
    pub(super) fn front_facing(&self) -> f32 {
        1.0 - self.back / (self.positions.len() as f32).max(1.0)
    }

    /// How varied the picture is in triangles, instances, normals and distances, from 0 to 1.
    pub(super) fn variety(&self) -> f32 {
        let detail = (distinct(self.triangles.clone()) / RAYS).min(1.0).sqrt();
        0.4 * detail
            + 0.25 * evenness(self.instances.clone(), 12.0)
            + 0.2 * evenness(self.facings.clone(), 10.0)
            + 0.15 * evenness(self.depths.clone(), 6.0)
    }
}

/// Quantises a unit vector to one of 26 directions.
fn facing(normal: Vec3) -> u32 {
    let cell = (normal * 1.5 + Vec3::splat(1.5)).clamp(Vec3::ZERO, Vec3::splat(2.0)).as_uvec3();
    cell.x + 3 * cell.y + 9 * cell.z
}

/// The number of distinct values.
fn distinct(mut values: Vec<u32>) -> f32 {
    values.sort_unstable();
    values.dedup();
    values.len() as f32
}

/// The entropy of values over that of `max` equally frequent ones: from 0 for a single value to 1
/// for `max` or more.
fn evenness(mut values: Vec<u32>, max: f32) -> f32 {
    values.sort_unstable();
    let total = (values.len() as f32).max(1.0);
    let entropy: f32 = values
        .chunk_by(|a, b| a == b)
        .map(|run| {
            let part = run.len() as f32 / total;
            -part * part.ln()
        })
        .sum();
    (entropy / max.ln()).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evenness_is_nothing_for_one_and_full_for_many() {
        assert!(evenness(vec![7; 20], 4.0) < 1e-6);
        assert!((evenness(vec![1, 2, 3, 4, 1, 2, 3, 4], 4.0) - 1.0).abs() < 1e-6);
        assert!(evenness(vec![1, 1, 1, 1, 1, 1, 1, 2], 4.0) < 0.5);
    }
}
