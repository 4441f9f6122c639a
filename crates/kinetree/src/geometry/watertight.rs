//! The ray-triangle test through which no ray slips between neighbours.
//!
//! Vertices are moved to the ray's origin and sheared along its largest axis, so that the ray becomes an axis; three edge functions then
//! say on which side of each edge it passes. All triangles round a vertex see the same sheared point, and the difference of two rounded
//! products is right in sign or exactly zero, so with inclusive edges every ray belongs to one side of an edge or to both.
//!
//! Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection". The six products are rounded separately, never fused. Two things are
//! computed again in double precision: edge functions of which one comes out as zero, since a ray that passes a triangle at a million times its size would
//! otherwise see two edges as zero and count as a hit; and the distance, where that of single precision could be off, as it is for long thin triangles.

use glam::DVec3;

use super::{Ray, Triangle};

/// A ray that has become an axis.
#[derive(Debug, Clone, Copy)]
pub struct Sheared {
    origin: [f32; 3],
    direction: [f32; 3],
    /// The axes in the order x, y, z of the sheared space; z is the largest of the direction.
    pub(crate) axes: [usize; 3],
    pub(crate) shear: [f32; 3],
    /// What a length in sheared space is in lengths of the direction: a power of two.
    pub(crate) t_scale: f32,
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    /// In lengths of the ray's direction.
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
    /// The ray comes from the side from which the corners run clockwise.
    pub back: bool,
}

/// Which axes come before the largest one of a direction in sheared space, when the direction runs up and when it runs down that axis: swapping them keeps the
/// winding.
pub(crate) const OTHERS: [[[usize; 2]; 2]; 4] =
    [[[1, 2], [2, 1]], [[2, 0], [0, 2]], [[0, 1], [1, 0]], [[0, 1], [1, 0]]];

impl Sheared {
    /// Of a ray whose direction is zero or not finite, nothing will come of it: it meets no triangle.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let direction = &ray.quads()[1];
        // Sizes order like their bits.
        let size = ray.direction.map(|step| step.to_bits() & 0x7fff_ffff);
        let (largest, after_x) = (size[1].max(size[2]), 1 + usize::from(size[1] < size[2]));
        let z = if size[0] < largest { after_x } else { 0 };
        let largest = largest.max(size[0]);
        let down = usize::from(direction[z & 3].is_sign_negative());
        let [x, y] = OTHERS[z & 3][down];
        // The direction is brought to a length around one by a power of two, so that short and long ones lose nothing.
        let exponent = ((largest >> 23) as i32 - 127).clamp(-126, 126);
        let t_scale = power_of_two(-exponent);
        let along = direction[z & 3] * t_scale;
        let shear = [direction[x & 3] * t_scale / along, direction[y & 3] * t_scale / along, 1.0 / along];
        Self { origin: ray.origin, direction: ray.direction, axes: [x, y, z], shear, t_scale }
    }

    #[inline]
    fn project(&self, vertex: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = self.axes.map(|axis| vertex[axis] - self.origin[axis]);
        let [shear_x, shear_y, shear_z] = self.shear;
        [(-shear_x).mul_add(z, x), (-shear_y).mul_add(z, y), shear_z * z]
    }

    /// Where the ray meets the triangle, if it does so within the bounds (inclusive). Edges and corners belong to the triangle.
    #[inline]
    pub fn hit(&self, triangle: &Triangle, t_min: f32, t_max: f32) -> Option<TriangleHit> {
        let [a, b, c] = triangle.corners.map(|corner| self.project(corner));
        let [(mut u, lost_u), (mut v, lost_v), (mut w, lost_w)] = [edge(c, b), edge(a, c), edge(b, a)];
        if u == 0.0 || v == 0.0 || w == 0.0 {
            (u, v, w) = (exact_edge(c, b), exact_edge(a, c), exact_edge(b, a));
        }
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let determinant = u + v + w;
        // A degenerate triangle, and one seen from its edge, is met by no ray. There is no threshold: small triangles count.
        if !inside || determinant == 0.0 {
            return None;
        }
        let sum = w.mul_add(c[2], v.mul_add(b[2], u * a[2]));
        // Adding zero turns a negative zero into a positive one.
        let t = sum / determinant * self.t_scale + 0.0;
        let hit = TriangleHit { t, u: v / determinant, v: w / determinant, back: determinant < 0.0 };
        let depth = larger(larger(a[2].abs(), b[2].abs()), c[2].abs());
        let (size, off) = (determinant.abs(), depth * (OFF * self.t_scale));
        // When the sum overflows, so does its bound.
        let is_near =
            NEAR * sum.abs() <= size * depth && (f32::INFINITY <= size * depth || t_min - off <= t && t <= t_max + off);
        let is_unsure = is_near || UNSURE * size <= larger(larger(lost_u, lost_v), lost_w);
        let better = if is_unsure { self.hit_in_double(triangle, hit.back) } else { None };
        better.or(Some(hit)).filter(|hit| t_min <= hit.t && hit.t <= t_max && hit.t.is_finite())
    }

    /// The same in single precision throughout: what [`Precision::Fast`](super::Precision::Fast) is.
    #[inline]
    pub fn hit_fast(&self, triangle: &Triangle, t_min: f32, t_max: f32) -> Option<TriangleHit> {
        let [a, b, c] = triangle.corners.map(|corner| self.project(corner));
        let [(u, _), (v, _), (w, _)] = [edge(c, b), edge(a, c), edge(b, a)];
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let determinant = u + v + w;
        let t = w.mul_add(c[2], v.mul_add(b[2], u * a[2])) / determinant * self.t_scale + 0.0;
        // Nothing at all over nothing is no number, and in no bounds.
        let is_hit = inside && t_min <= t && t <= t_max && t.is_finite();
        is_hit.then(|| TriangleHit { t, u: v / determinant, v: w / determinant, back: determinant < 0.0 })
    }

    /// Where the ray meets the plane of the triangle, which it is known to meet, and from which side. `None` where even double precision sees no triangle.
    #[cold]
    fn hit_in_double(&self, triangle: &Triangle, back: bool) -> Option<TriangleHit> {
        let point = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let (origin, direction) = (point(self.origin), point(self.direction));
        let [a, b, c] = triangle.corners.map(|corner| point(corner) - origin);
        let weight = |from: DVec3, to: DVec3| {
            let edge = direction.dot(from.cross(to));
            if back { (-edge).max(0.0) } else { edge.max(0.0) }
        };
        let (u, v, w) = (weight(c, b), weight(a, c), weight(b, a));
        let (z, all) = (self.axes[2], u + v + w);
        let t = (u * a[z] + v * b[z] + w * c[z]) / (all * direction[z]);
        (all > 0.0).then(|| TriangleHit { t: t as f32 + 0.0, u: (v / all) as f32, v: (w / all) as f32, back })
    }
}

/// On which side of an edge the ray passes, and the size of what may be lost of it: one of the two products.
#[inline(always)]
fn edge(from: [f32; 3], to: [f32; 3]) -> (f32, f32) {
    let product = from[1] * to[0];
    (from[0] * to[1] - product, product.abs())
}

/// By how much the products may outweigh the sum of the edge functions before the weights are made in double precision: what is left of them after cancellation is then
/// less than a sixteenth, four bits of 24.
pub(crate) const UNSURE: f32 = 16.0;

/// By how much the depth of a corner may outweigh that of the hit before the weights are made in double precision: they are as good as ever, but their errors count
/// so many times.
pub(crate) const NEAR: f32 = 64.0;

/// By what part of the depth of a corner the distance of such a hit may be off, with room to spare.
pub(crate) const OFF: f32 = 1.0 / (1 << 17) as f32;

/// The second where the first is not larger, or no number.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// An edge function that is zero only if the ray meets the edge's line. Rarely needed, so it stays out of the way.
#[cold]
fn exact_edge(from: [f32; 3], to: [f32; 3]) -> f32 {
    let [from, to] = [from, to].map(|point| point.map(f64::from));
    (from[0] * to[1] - from[1] * to[0]) as f32
}

/// For exponents from -126 to 127.
#[inline(always)]
fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: Triangle = Triangle { corners: [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]] };

    fn meets(ray: &Ray, triangle: &Triangle) -> Option<TriangleHit> {
        Sheared::new(&ray.sane()?).hit(triangle, ray.t_min.max(0.0), ray.t_max)
    }

    #[test]
    fn weights_distance_and_side_are_right() {
        let hit = meets(&Ray::new([0.25, 2.0, 0.5], [0.0, -4.0, 0.0]), &FLOOR).unwrap();
        assert_eq!(hit, TriangleHit { t: 0.5, u: 0.5, v: 0.25, back: false });
        let below = meets(&Ray::new([0.25, -2.0, 0.5], [0.0, 1.0, 0.0]), &FLOOR).unwrap();
        assert_eq!(below, TriangleHit { t: 2.0, u: 0.5, v: 0.25, back: true });
    }

    #[test]
    fn bounds_are_inclusive_and_behind_does_not_count() {
        let ray = Ray::new([0.25, 2.0, 0.25], [0.0, -1.0, 0.0]);
        assert!(meets(&ray.with_range(2.0, 2.0), &FLOOR).is_some());
        assert!(meets(&ray.with_range(0.0, 1.999), &FLOOR).is_none());
        assert!(meets(&ray.with_range(2.001, 9.0), &FLOOR).is_none());
        assert!(meets(&Ray::new([0.25, -2.0, 0.25], [0.0, -1.0, 0.0]), &FLOOR).is_none());
    }

    #[test]
    fn directions_of_any_length_give_the_same_place() {
        for exponent in [-140, -126, -100, -20, 0, 20, 100, 120] {
            let size = 2.0_f64.powi(exponent) as f32;
            let hit = meets(&Ray::new([0.25, 1.0e-3, 0.25], [0.0, -size, 0.0]), &FLOOR);
            let t = 1.0e-3 / f64::from(size);
            if t > f64::from(f32::MAX) {
                assert_eq!(hit, None);
            } else {
                let hit = hit.unwrap_or_else(|| panic!("2^{exponent}"));
                assert!((f64::from(hit.t) / t - 1.0).abs() < 1e-6 && hit.u == 0.25 && hit.v == 0.25, "2^{exponent}");
            }
        }
    }

    #[test]
    fn degenerate_triangles_and_edge_on_ones_are_missed() {
        let point = Triangle { corners: [[0.5, 0.0, 0.5]; 3] };
        let line = Triangle { corners: [[0.0; 3], [1.0, 0.0, 1.0], [0.5, 0.0, 0.5]] };
        let down = Ray::new([0.5, 1.0, 0.5], [0.0, -1.0, 0.0]);
        assert_eq!(meets(&down, &point), None);
        assert_eq!(meets(&down, &line), None);
        assert_eq!(meets(&Ray::new([-1.0, 0.0, 0.2], [1.0, 0.0, 0.0]), &FLOOR), None);
    }

    #[test]
    fn a_ray_far_beside_a_small_triangle_misses() {
        // Seen from so far, the corners are hardly apart.
        let corners = [[0.0, 0.0, 0.0], [0.4, 1.1, 0.0], [0.2, 0.55, 0.3]];
        for distance in [1e3, 1e5, 2e6, 1e7] {
            let ray = Ray::new([distance * 0.4, distance * 1.1, -distance], [0.0, 0.0, 1.0]);
            assert_eq!(meets(&ray, &Triangle { corners }), None, "{distance}");
        }
    }

    #[test]
    fn distances_to_slivers_are_right() {
        // By the normal of the plane, which the test itself does not use; nothing where the ray misses by a hair.
        let exact = |ray: &Ray, triangle: &Triangle| {
            let point = |v: [f32; 3]| DVec3::from(v.map(f64::from));
            let [a, b, c] = triangle.corners.map(point);
            let normal = (b - a).cross(c - a);
            let t = normal.dot(a - point(ray.origin)) / normal.dot(point(ray.direction));
            let at = point(ray.origin) + t * point(ray.direction);
            let is_inside = |from: DVec3, to: DVec3| (to - from).cross(at - from).dot(normal) >= 0.0;
            (is_inside(a, b) && is_inside(b, c) && is_inside(c, a)).then_some(t)
        };
        let mut seed = 0x5eed_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut hits = 0;
        for _ in 0..200_000 {
            let mut somewhere = |size: f32| [(); 3].map(|()| random() * size);
            let (middle, along, aside) = (somewhere(30.0), somewhere(40.0), somewhere(0.02));
            let (one, other) = ([0, 1, 2].map(|k| middle[k] - along[k]), [0, 1, 2].map(|k| middle[k] + along[k]));
            let triangle = Triangle { corners: [one, other, [0, 1, 2].map(|k| middle[k] + aside[k])] };
            let origin = somewhere(30.0);
            let ray = Ray::new(origin, [0, 1, 2].map(|k| middle[k] + aside[k] * 0.4 - origin[k]));
            let (Some(hit), Some(right)) = (meets(&ray, &triangle), exact(&ray, &triangle)) else { continue };
            hits += 1;
            assert!((f64::from(hit.t) / right - 1.0).abs() < 1e-4, "{ray:?}, {triangle:?}: {hit:?}, not {right}");
        }
        assert!(hits > 100_000, "{hits}");
    }

    #[test]
    fn the_smallest_triangles_are_hit() {
        let size = 1e-12;
        let small = Triangle { corners: FLOOR.corners.map(|corner| corner.map(|x| x * size)) };
        assert!(meets(&Ray::new([size * 0.25, 1.0, size * 0.25], [0.0, -1.0, 0.0]), &small).is_some());
    }
}
