//! Rays that start at the hits of other rays.

use glam::Vec3;

use crate::ray::{Answer, Ray};
use crate::rng::Rng;
use crate::scene::PinholeCamera;
use crate::soup::Soup;

/// How far a ray starts off the surface, relative to its coordinates and to the distance of the
/// hit.
const OFFSET: f32 = 2e-5;

/// The hits of rays: for each, a point just off the surface, and the normal on the side of the ray.
pub(crate) struct HitPoints(Vec<(Vec3, Vec3)>);

impl HitPoints {
    /// The hits of these rays, in their order.
    pub(crate) fn of(soup: &Soup, rays: &[Ray], answers: &[Answer]) -> Self {
        let hits = rays.iter().zip(answers).filter(|(_, answer)| answer.is_hit());
        Self(hits.filter_map(|(ray, answer)| hit_point(soup, ray, answer)).collect())
    }

    /// `count` starting points in order, each hit about equally often.
    fn spread(&self, count: usize) -> impl Iterator<Item = (Vec3, Vec3)> {
        let count = if self.0.is_empty() { 0 } else { count };
        (0..count).map(move |i| self.0[i * self.0.len() / count])
    }

    /// Rays with cosine-weighted directions about the normals.
    pub(crate) fn diffuse(&self, count: usize, seed: u64, bounce: u64) -> Vec<Ray> {
        let mut rng = Rng::new(seed, 0xd1ff + bounce);
        self.spread(count).map(|(point, normal)| Ray::new(point, rng.diffuse(normal))).collect()
    }

    /// As `diffuse`, with an end at `t_max`.
    pub(crate) fn short(&self, t_max: f32, count: usize, seed: u64) -> Vec<Ray> {
        let mut rng = Rng::new(seed, 0x5047);
        let ray = |(point, normal)| Ray { t_max, ..Ray::new(point, rng.diffuse(normal)) };
        self.spread(count).map(ray).collect()
    }

    /// Rays to a point light; they end just before it.
    pub(crate) fn to_light(&self, light: Vec3, count: usize) -> Vec<Ray> {
        let ray = |(point, _): (Vec3, Vec3)| {
            let offset = light - point;
            let direction = offset.try_normalize()?;
            Some(Ray { t_max: offset.length() * 0.999, ..Ray::new(point, direction) })
        };
        self.spread(count).filter_map(ray).collect()
    }
}

/// A light up and to the right of the camera, at 0.3 times the median distance of hits, so that in
/// a room it is usually within the room.
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
