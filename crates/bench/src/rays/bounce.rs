//! Rays that start where others ended.

use glam::Vec3;

use crate::ray::{Answer, Ray};
use crate::rng::Rng;
use crate::scene::PinholeCamera;
use crate::soup::Soup;

/// How far a ray starts off the surface, as a fraction of its coordinates and of the way of the ray
/// before.
const OFFSET: f32 = 2e-5;

/// Where rays ended: a point just off the surface, and the normal on the side they came from.
pub(crate) struct HitPoints(Vec<(Vec3, Vec3)>);

impl HitPoints {
    /// Of those rays that hit something, in their order.
    pub(crate) fn of(soup: &Soup, rays: &[Ray], answers: &[Answer]) -> Self {
        let hits = rays.iter().zip(answers).filter(|(_, answer)| answer.is_hit());
        Self(hits.filter_map(|(ray, answer)| hit_point(soup, ray, answer)).collect())
    }

    /// `count` starting points, in order: each end about equally often.
    fn spread(&self, count: usize) -> impl Iterator<Item = (Vec3, Vec3)> {
        let count = if self.0.is_empty() { 0 } else { count };
        (0..count).map(move |i| self.0[i * self.0.len() / count])
    }

    /// On by the cosine.
    pub(crate) fn diffuse(&self, count: usize, seed: u64, bounce: u64) -> Vec<Ray> {
        let mut rng = Rng::new(seed, 0xd1ff + bounce);
        self.spread(count).map(|(point, normal)| Ray::new(point, rng.diffuse(normal))).collect()
    }

    /// Every way, but not far.
    pub(crate) fn short(&self, t_max: f32, count: usize, seed: u64) -> Vec<Ray> {
        let mut rng = Rng::new(seed, 0x5047);
        let ray = |(point, normal)| Ray { t_max, ..Ray::new(point, rng.diffuse(normal)) };
        self.spread(count).map(ray).collect()
    }

    /// To a light.
    pub(crate) fn to_light(&self, light: Vec3, count: usize) -> Vec<Ray> {
        let ray = |(point, _): (Vec3, Vec3)| {
            let offset = light - point;
            let direction = offset.try_normalize()?;
            Some(Ray { t_max: offset.length() * 0.999, ..Ray::new(point, direction) })
        };
        self.spread(count).filter_map(ray).collect()
    }
}

/// A light up and to the right of the camera, by a third of the usual distance: in a room, within
/// the room as a rule.
pub(crate) fn light(camera: &PinholeCamera, hit_points: &HitPoints) -> Vec3 {
    let mut distances: Vec<f32> = hit_points.0.iter().map(|(point, _)| point.distance(camera.position)).collect();
    distances.sort_unstable_by(f32::total_cmp);
    let usual = distances.get(distances.len() / 2).copied().unwrap_or(1.0);
    let offset = camera.up.normalize_or(Vec3::Y) + camera.right.normalize_or(Vec3::X);
    camera.position + offset * usual * 0.3
}

fn hit_point(soup: &Soup, ray: &Ray, answer: &Answer) -> Option<(Vec3, Vec3)> {
    let normal = soup.normal(answer.primitive)?;
    let normal = if normal.dot(Vec3::from(ray.direction)) > 0.0 { -normal } else { normal };
    let point = ray.at(answer.t);
    let offset = OFFSET * (point.abs().max_element() + answer.t);
    let start = point + normal * offset;
    start.is_finite().then_some((start, normal))
}
