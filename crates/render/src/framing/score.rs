//! How good a camera is, judged by a coarse grid of rays.

use glam::Vec3;
use kinetree::Ray;

use super::region::Region;
use crate::camera::Lens;
use crate::sampler::combine;
use crate::shading::ShadingPoint;
use crate::{Camera, Frame};

/// Rays across and down.
const GRID: [u32; 2] = [32, 18];
/// Nearer than this, in radii of the region, things begin to stand in the way.
const TOO_NEAR: f32 = 0.35;
/// The part of the picture that should show the region; more is no better.
const ENOUGH: f32 = 0.55;

/// The part of the region's places that can be seen at once; the others are on the far side.
const MOST_SHOWN: f32 = 0.5;

/// What a camera sees.
#[derive(Debug, Default)]
struct Sight {
    hits: f32,
    in_region: f32,
    /// How near things are, counted more in the middle of the picture.
    blocked: f32,
    /// The part of the region's places that are in the picture and not hidden.
    shown: f32,
    /// Seen from the side that the winding faces away from.
    back: f32,
    triangles: Vec<u32>,
    instances: Vec<u32>,
    facings: Vec<u32>,
    depths: Vec<u32>,
}

/// The score of a camera; larger is better, none is negative.
pub(super) fn score(frame: &Frame, region: &Region, camera: &Camera, aspect: f32) -> f32 {
    let lens = Lens::new(camera, aspect);
    let shown = region.places().iter().filter(|&&place| lens.frames(place) && is_open(frame, camera, place)).count();
    let mut sight = Sight { shown: shown as f32 / region.places().len().max(1) as f32, ..Sight::default() };
    for row in 0..GRID[1] {
        for column in 0..GRID[0] {
            let at = [(column as f32 + 0.5) / GRID[0] as f32, (row as f32 + 0.5) / GRID[1] as f32];
            let ray = lens.ray(at);
            if let Some(hit) = frame.view.closest_hit(&ray) {
                let point = ShadingPoint::new(frame, &hit, ray.direction.into());
                let in_middle = (at[0] - 0.5).abs() < 0.25 && (at[1] - 0.5).abs() < 0.25;
                sight.note(region, &point, hit.t, in_middle);
            }
        }
    }
    sight.judged((GRID[0] * GRID[1]) as f32)
}

/// Whether nothing stands between a camera and a place on a surface, up to just before it.
fn is_open(frame: &Frame, camera: &Camera, place: Vec3) -> bool {
    let eye = Vec3::from(camera.position());
    !frame.view.occluded(&Ray::new(eye.into(), (place - eye).into()).with_range(0.0, 0.99))
}

impl Sight {
    fn note(&mut self, region: &Region, point: &ShadingPoint<'_>, distance: f32, in_middle: bool) {
        self.hits += 1.0;
        self.in_region += f32::from(u8::from(region.contains(point.position)));
        self.back += f32::from(u8::from(!point.front));
        let nearness = (1.0 - distance / (TOO_NEAR * region.radius())).max(0.0);
        self.blocked += nearness * if in_middle { 2.0 } else { 1.0 };
        self.triangles.push(combine(point.instance, point.primitive));
        self.instances.push(point.instance);
        self.facings.push(facing(point.facing));
        self.depths.push(((distance / region.radius()).max(1e-6).log2() * 2.0 + 100.0) as u32);
    }

    fn judged(mut self, rays: f32) -> f32 {
        if self.hits <= 0.0 {
            return 0.0;
        }
        let seen = (self.in_region / rays / ENOUGH).min(1.0);
        let open = (1.0 - self.blocked / rays).max(0.0);
        let right_side = 1.0 - self.back / self.hits;
        let detail = (distinct(&mut self.triangles) / rays).min(1.0).sqrt();
        let variety = 0.4 * detail
            + 0.25 * variety(&mut self.instances, 12.0)
            + 0.2 * variety(&mut self.facings, 10.0)
            + 0.15 * variety(&mut self.depths, 6.0);
        seen * (0.1 + (self.shown / MOST_SHOWN).min(1.0)) * (0.1 + variety) * open * open * right_side * right_side
    }
}

/// One of 26 directions.
fn facing(normal: Vec3) -> u32 {
    let cell = (normal * 1.5 + Vec3::splat(1.5)).clamp(Vec3::ZERO, Vec3::splat(2.0)).as_uvec3();
    cell.x + 3 * cell.y + 9 * cell.z
}

/// How many different values there are.
fn distinct(values: &mut Vec<u32>) -> f32 {
    values.sort_unstable();
    values.dedup();
    values.len() as f32
}

/// How evenly values are spread, from 0 for a single one to 1 for `most` of equal number or more: the exponential of their
/// entropy, on a logarithmic scale.
fn variety(values: &mut [u32], most: f32) -> f32 {
    values.sort_unstable();
    let total = values.len() as f32;
    let entropy: f32 = values
        .chunk_by(|a, b| a == b)
        .map(|run| {
            let part = run.len() as f32 / total;
            -part * part.ln()
        })
        .sum();
    (entropy / most.ln()).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variety_is_nothing_for_one_and_full_for_many() {
        assert!(variety(&mut [7; 20], 4.0) < 1e-6);
        assert!((variety(&mut [1, 2, 3, 4, 1, 2, 3, 4], 4.0) - 1.0).abs() < 1e-6);
        assert!(variety(&mut [1, 1, 1, 1, 1, 1, 1, 2], 4.0) < 0.5);
    }
}
