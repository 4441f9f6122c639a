//! The ray-triangle test through which no ray slips between neighbours.
//!
//! Vertices are moved to the ray's origin and sheared along its largest axis, so that the ray becomes an axis; three edge functions then
//! say on which side of each edge it passes. All triangles round a vertex see the same sheared point, and the difference of two rounded
//! products is right in sign or exactly zero, so with inclusive edges every ray belongs to one side of an edge or to both.
//!
//! Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection". The six products are rounded separately, never fused. An edge function
//! that comes out as zero is computed again in double precision, where products are exact: otherwise a ray that passes a triangle at a million
//! times its size would see two edges as zero and count as a hit.

use super::{Ray, Triangle};

/// A ray that has become an axis.
#[derive(Debug, Clone, Copy)]
pub struct Sheared {
    origin: [f32; 3],
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
const OTHERS: [[[usize; 2]; 2]; 4] = [[[1, 2], [2, 1]], [[2, 0], [0, 2]], [[0, 1], [1, 0]], [[0, 1], [1, 0]]];

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
        Self { origin: ray.origin, axes: [x, y, z], shear, t_scale }
    }

    #[inline]
    fn project(&self, vertex: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = self.axes.map(|axis| vertex[axis] - self.origin[axis]);
        [x - self.shear[0] * z, y - self.shear[1] * z, self.shear[2] * z]
    }

    /// Where the ray meets the triangle, if it does so within the bounds (inclusive). Edges and corners belong to the triangle.
    #[inline]
    pub fn hit(&self, triangle: &Triangle, t_min: f32, t_max: f32) -> Option<TriangleHit> {
        let [a, b, c] = triangle.corners.map(|corner| self.project(corner));
        let mut u = c[0] * b[1] - c[1] * b[0];
        let mut v = a[0] * c[1] - a[1] * c[0];
        let mut w = b[0] * a[1] - b[1] * a[0];
        if u == 0.0 || v == 0.0 || w == 0.0 {
            (u, v, w) = (exact_edge(c, b), exact_edge(a, c), exact_edge(b, a));
        }
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let determinant = u + v + w;
        // A degenerate triangle, and one seen from its edge, is met by no ray. There is no threshold: small triangles count.
        if !inside || determinant == 0.0 {
            return None;
        }
        let t = (u * a[2] + v * b[2] + w * c[2]) / determinant * self.t_scale;
        if !(t_min <= t && t <= t_max && t.is_finite()) {
            return None;
        }
        // Adding zero turns a negative zero into a positive one.
        Some(TriangleHit { t: t + 0.0, u: v / determinant, v: w / determinant, back: determinant < 0.0 })
    }
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
    fn the_smallest_triangles_are_hit() {
        let size = 1e-12;
        let small = Triangle { corners: FLOOR.corners.map(|corner| corner.map(|x| x * size)) };
        assert!(meets(&Ray::new([size * 0.25, 1.0, size * 0.25], [0.0, -1.0, 0.0]), &small).is_some());
    }
}
