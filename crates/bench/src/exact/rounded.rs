//! Hits in double precision: weights and angles, which tell whether a hit is at an edge.
//!
//! Möller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection".

use glam::Vec3;

use crate::ray::Ray;
use crate::soup::Soup;

/// The intersection of a ray's line with a triangle's plane, in double precision.
pub(crate) struct Rounded {
    /// Weight of the second corner.
    pub(crate) u: f64,
    /// Weight of the third corner.
    pub(crate) v: f64,
    /// The absolute cosine between the ray and the normal; 0 for a triangle without area.
    pub(crate) cosine: f64,
    /// Twice the area of the triangle, square metres.
    pub(crate) double_area: f64,
}

impl Rounded {
    /// Möller and Trumbore's formulas.
    pub(crate) fn of(soup: &Soup, ray: &Ray, triangle: u32) -> Self {
        let [a, b, c] = soup.corners(triangle).map(Vec3::as_dvec3);
        let direction = Vec3::from(ray.direction).as_dvec3();
        let (ab, ac, from_a) = (b - a, c - a, Vec3::from(ray.origin).as_dvec3() - a);
        let (p, q) = (direction.cross(ac), from_a.cross(ab));
        let determinant = ab.dot(p);
        let double_area = ab.cross(ac).length();
        let size = double_area * direction.length();
        let cosine = if size > 0.0 { determinant.abs() / size } else { 0.0 };
        Self { u: from_a.dot(p) / determinant, v: direction.dot(q) / determinant, cosine, double_area }
    }
}
