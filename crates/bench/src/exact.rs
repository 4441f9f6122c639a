//! Hits in double precision: the reference for distances, and the slow twin that looks at every triangle.
//!
//! Moeller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection".

use glam::Vec3;
use rayon::prelude::*;

use crate::ray::{Answer, Ray};
use crate::soup::Soup;

/// Where a ray's line meets a triangle's plane, in double precision.
pub(crate) struct Exact {
    /// In lengths of the direction.
    pub(crate) t: f64,
    /// Weight of the second corner.
    pub(crate) u: f64,
    /// Weight of the third corner.
    pub(crate) v: f64,
    /// Between the ray and the normal, without its sign; 0 for a triangle without area.
    pub(crate) cosine: f64,
    /// Of the triangle, square metres.
    pub(crate) double_area: f64,
}

impl Exact {
    /// Moeller and Trumbore's formulas.
    pub(crate) fn of(soup: &Soup, ray: &Ray, triangle: u32) -> Self {
        let [a, b, c] = soup.corners(triangle).map(Vec3::as_dvec3);
        let direction = Vec3::from(ray.direction).as_dvec3();
        let (ab, ac, from_a) = (b - a, c - a, Vec3::from(ray.origin).as_dvec3() - a);
        let (p, q) = (direction.cross(ac), from_a.cross(ab));
        let determinant = ab.dot(p);
        let double_area = ab.cross(ac).length();
        let size = double_area * direction.length();
        let cosine = if size > 0.0 { determinant.abs() / size } else { 0.0 };
        Self {
            t: ac.dot(q) / determinant,
            u: from_a.dot(p) / determinant,
            v: direction.dot(q) / determinant,
            cosine,
            double_area,
        }
    }
}

/// The nearest hit of each ray, by looking at every triangle. Both sides and all edges count.
pub(crate) fn closest_by_looking(soup: &Soup, rays: &[Ray]) -> Vec<Answer> {
    rays.par_iter().map(|ray| look(soup, ray)).collect()
}

fn look(soup: &Soup, ray: &Ray) -> Answer {
    let (mut best, mut nearest) = (Answer::MISS, f64::from(ray.t_max));
    for primitive in 0..soup.len() as u32 {
        let Exact { t, u, v, .. } = Exact::of(soup, ray, primitive);
        // NaN, from a triangle without area or seen edge on, fails the comparisons.
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        if inside && t >= 0.0 && t <= nearest && (t < nearest || !best.is_hit()) {
            nearest = t;
            best = Answer { t: t as f32, u: u as f32, v: v as f32, primitive, mesh: 0 };
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_of_several_is_found_and_ends_count() {
        let mut soup = Soup::default();
        for z in [2.0, 1.0, 1.0, 3.0] {
            soup.add([Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| p + Vec3::Z * z), &[[0, 1, 2]]);
        }
        let ray = Ray::new(Vec3::new(0.25, 0.25, 0.0), Vec3::Z);
        let ends = |t_max| Ray { t_max, ..ray };
        let rays = [ray, ends(1.0), ends(0.99), Ray::new(Vec3::new(-1e-9, 0.25, 0.0), Vec3::Z)];
        let found: Vec<(u32, f32)> =
            closest_by_looking(&soup, &rays).iter().map(|answer| (answer.primitive, answer.t)).collect();
        let miss = (Answer::NOTHING, f32::INFINITY);
        assert_eq!(found, [(1, 1.0), (1, 1.0), miss, miss]);
    }
}
