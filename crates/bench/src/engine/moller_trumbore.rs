//! A triangle test for engines that leave it, or the barycentric weights, to their users.
//!
//! Möller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection".

use glam::Vec3;

use crate::ray::Ray;

/// Distance and weights of the second and third corner, where the ray's line meets the triangle at
/// `t >= 0`; both sides count.
#[inline]
pub(crate) fn hit(ray: &Ray, [a, b, c]: &[Vec3; 3]) -> Option<(f32, f32, f32)> {
    let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
    let (ab, ac) = (*b - *a, *c - *a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    let reciprocal = 1.0 / determinant;
    let from_a = origin - *a;
    let u = from_a.dot(p) * reciprocal;
    let q = from_a.cross(ab);
    let v = direction.dot(q) * reciprocal;
    let t = ac.dot(q) * reciprocal;
    // A triangle that is seen edge on gives NaN, which fails the first comparison.
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t.is_finite()).then_some((t, u, v))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_are_hit_and_edge_on_is_not() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let ray = |origin: [f32; 3], direction: [f32; 3]| Ray::new(origin.into(), direction.into());
        assert_eq!(hit(&ray([0.25, 0.5, 2.0], [0.0, 0.0, -1.0]), &triangle), Some((2.0, 0.25, 0.5)));
        assert_eq!(hit(&ray([0.25, 0.5, -2.0], [0.0, 0.0, 1.0]), &triangle), Some((2.0, 0.25, 0.5)));
        assert_eq!(hit(&ray([0.25, 0.5, 2.0], [0.0, 0.0, 1.0]), &triangle), None);
        assert_eq!(hit(&ray([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0]), &triangle), None);
    }
}
