//! The ray-triangle test through which no ray slips between neighbours.
//!
//! Vertices are moved to the ray's origin and sheared along its largest axis, so that the ray
//! becomes an axis; three edge functions then say on which side of each edge it passes. That is
//! done in single precision, with a bound of its error at hand: where an edge function is within
//! the bound, or the distance might be off by more than [`DISTANCE_ERROR`], the triangle is tested
//! again without rounding errors ([`exact`]). So every decision is the one of exact arithmetic,
//! whatever the processor, the tree and the batch, and what is closed in exact arithmetic is closed
//! for rays.
//!
//! Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection", for the sheared space;
//! Shewchuk 1997 for deciding exactly only what is in doubt. Decision 18 derives the bounds.

use super::{DISTANCE_ERROR, Ray, Triangle, UNIT_ROUNDOFF, exact};
use crate::simd::{Isa, Lanes, Scalar};

/// A ray that has become an axis.
#[derive(Debug, Clone, Copy)]
pub struct WatertightRay {
    ray: Ray,
    /// The axes in the order x, y, z of the sheared space; z is the largest of the direction.
    pub(crate) axes: [usize; 3],
    pub(crate) shear: [f32; 3],
    /// The length of a unit of sheared space in lengths of the direction: a power of two.
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

/// The axes that come before the largest one of a direction in sheared space, for directions that
/// run up and down that axis: swapping them keeps the winding.
pub(crate) const OTHERS: [[[usize; 2]; 2]; 4] =
    [[[1, 2], [2, 1]], [[2, 0], [0, 2]], [[0, 1], [1, 0]], [[0, 1], [1, 0]]];

impl WatertightRay {
    /// A ray whose direction is zero or not finite meets no triangle.
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
        // A power of two brings the direction to a length around one, so that short and long ones
        // lose no precision.
        let exponent = ((largest >> 23) as i32 - 127).clamp(-126, 126);
        let t_scale = power_of_two(-exponent);
        let along = direction[z & 3] * t_scale;
        let shear = [direction[x & 3] * t_scale / along, direction[y & 3] * t_scale / along, 1.0 / along];
        Self { ray: *ray, axes: [x, y, z], shear, t_scale }
    }

    /// [`REACH`], or what depths are stretched by where that is more, as it is for denormal
    /// directions.
    #[inline(always)]
    pub(crate) fn reach(&self) -> f32 {
        if self.shear[2].abs() > REACH { self.shear[2].abs() } else { REACH }
    }

    /// Where the ray meets the triangle, if it does so within the bounds (inclusive). Edges and
    /// corners belong to the triangle. Nothing meets a triangle without area, or one seen from its
    /// edge; there is no threshold: small triangles count.
    #[inline]
    pub fn hit(&self, triangle: &Triangle, t_min: f32, t_max: f32) -> Option<TriangleHit> {
        let hits = self.test::<true>(triangle, t_min, t_max)?;
        if hits.ambiguous != 0 { exact::hit(&self.ray, triangle, t_min, t_max) } else { hits.first() }
    }

    /// The same in single precision throughout: what [`Precision::Fast`](super::Precision::Fast)
    /// is.
    #[inline]
    pub fn hit_fast(&self, triangle: &Triangle, t_min: f32, t_max: f32) -> Option<TriangleHit> {
        self.test::<false>(triangle, t_min, t_max)?.first()
    }

    /// One ray against one triangle: the test with a single lane.
    #[inline]
    fn test<const WATERTIGHT: bool>(&self, triangle: &Triangle, t_min: f32, t_max: f32) -> Option<LaneHits<[f32; 1]>> {
        let along_axes = |v: [f32; 3]| self.axes.map(|axis| [v[axis]]);
        let corners = triangle.corners.map(along_axes);
        let (origin, shear) = (along_axes(self.ray.origin), self.shear.map(|x| [x]));
        let edges =
            Edges::<_, WATERTIGHT>::new(Scalar, corners, (origin, shear), [[triangle.extent()], [self.reach()]], 1);
        let bounds = ([t_min], [t_max.min(f32::MAX)]);
        edges.is_possible().then(|| edges.intersect(Scalar, [self.t_scale], bounds))
    }
}

impl LaneHits<[f32; 1]> {
    fn first(&self) -> Option<TriangleHit> {
        let ([t], [[u], [v]]) = (self.t(Scalar), self.weights(Scalar));
        (self.hits != 0).then(|| TriangleHit { t, u, v, back: self.back(Scalar) != 0 })
    }
}

/// On which side of a triangle's edges rays pass. A lane is a ray and a triangle: one of each, four
/// triangles and a ray, or a triangle and sixteen rays. All give the same hits to the bit.
pub(crate) struct Edges<V, const WATERTIGHT: bool> {
    /// Corners in sheared space.
    corners: [[V; 3]; 3],
    weights: [V; 3],
    /// Lanes that may be hits.
    possible: u32,
    /// Those of them where no edge is in doubt.
    sure: u32,
    /// How far the corners are across the ray, times [`EDGE_ERROR`]; and from its origin.
    lateral: V,
    size: V,
}

/// The lanes that are hit, and where.
#[derive(Clone, Copy)]
pub(crate) struct LaneHits<V> {
    pub(crate) hits: u32,
    /// Lanes that only exact arithmetic can decide; not in `hits`.
    pub(crate) ambiguous: u32,
    t: V,
    v: V,
    w: V,
    determinant: V,
}

impl<V: Copy> LaneHits<V> {
    /// In lengths of the rays' directions. Adding zero turns a negative zero into a positive one.
    #[inline(always)]
    pub(crate) fn t<I: Isa>(&self, isa: I) -> V
    where
        V: Lanes<I>,
    {
        isa.add(self.t, isa.splat(0.0))
    }

    /// Lanes whose ray comes from the side from which the corners run clockwise.
    #[inline(always)]
    pub(crate) fn back<I: Isa>(&self, isa: I) -> u32
    where
        V: Lanes<I>,
    {
        isa.le(self.determinant, isa.splat(0.0))
    }

    /// Weights of the second and the third corner.
    #[inline(always)]
    pub(crate) fn weights<I: Isa>(&self, isa: I) -> [V; 2]
    where
        V: Lanes<I>,
    {
        [isa.div(self.v, self.determinant), isa.div(self.w, self.determinant)]
    }
}

impl<V: Copy, const WATERTIGHT: bool> Edges<V, WATERTIGHT> {
    /// Origins, shears and the coordinates of corners stand in the order of the axes of sheared
    /// space. `extent` is that of each triangle, and `reach` as [`WatertightRay::reach`]; single
    /// precision throughout needs neither.
    #[inline(always)]
    pub(crate) fn new<I: Isa>(
        isa: I,
        corners: [[V; 3]; 3],
        (origin, shear): ([V; 3], [V; 3]),
        [extent, reach]: [V; 2],
        lanes: u32,
    ) -> Self
    where
        V: Lanes<I>,
    {
        let a = project(isa, corners[0], origin, shear);
        let b = project(isa, corners[1], origin, shear);
        let c = project(isa, corners[2], origin, shear);
        let (u, v, w) = (edge(isa, c, b), edge(isa, a, c), edge(isa, b, a));
        let least = isa.min(isa.min(u, v), w);
        let most = isa.max(isa.max(u, v), w);
        let zero = isa.splat(0.0);
        let (corners, weights) = ([a, b, c], [u, v, w]);
        if !WATERTIGHT {
            let inside = (isa.le(zero, least) | isa.le(most, zero)) & lanes;
            return Self { corners, weights, possible: inside, sure: inside, lateral: zero, size: zero };
        }
        let size = isa.fused(extent, reach, isa.abs(a[2]));
        let lateral = isa.fused(size, isa.splat(EDGE_BY_SIZE), isa.mul(extent, isa.splat(EDGE_BY_EXTENT)));
        let error = isa.fused(size, lateral, isa.splat(LEAST_EDGE_ERROR));
        let minus = isa.sub(zero, error);
        // Where corners are NaN, as those of unused lanes are, neither side is ruled out.
        let possible = !(isa.le(least, minus) & isa.le(error, most)) & lanes;
        let sure = possible & (isa.le(error, least) | isa.le(most, minus));
        Self { corners, weights, possible, sure, lateral, size }
    }

    /// Whether any lane may be a hit.
    #[inline(always)]
    pub(crate) fn is_possible(&self) -> bool {
        self.possible != 0
    }

    /// The hits within the bounds, inclusive. Both are finite.
    #[inline(always)]
    pub(crate) fn intersect<I: Isa>(&self, isa: I, t_scale: V, (t_min, t_max): (V, V)) -> LaneHits<V>
    where
        V: Lanes<I>,
    {
        let Self { corners: [a, b, c], weights: [u, v, w], possible, sure, .. } = *self;
        let determinant = isa.add(isa.add(u, v), w);
        let sum = isa.fused(w, c[2], isa.fused(v, b[2], isa.mul(u, a[2])));
        let t = isa.mul(isa.div(sum, determinant), t_scale);
        let (mut close, mut ambiguous) = (sure, 0);
        if WATERTIGHT {
            let error = self.distance_error(isa, determinant);
            let bound = isa.mul(isa.abs(sum), isa.splat(MOST_DISTANCE_ERROR));
            close &= isa.le(error, bound) & isa.le(bound, isa.splat(f32::MAX));
            ambiguous = possible & !close;
            if ambiguous & sure != 0 {
                let scale = isa.mul(isa.splat(UNIT_ROUNDOFF), t_scale);
                let error = isa.mul(isa.div(error, isa.abs(determinant)), scale);
                let (nearest, farthest) = (isa.sub(t, error), isa.add(t, error));
                // Where either is NaN, it is not outside.
                let outside = isa.le(farthest, t_min) & !isa.le(t_min, farthest)
                    | isa.le(t_max, nearest) & !isa.le(nearest, t_max);
                ambiguous &= !(sure & outside);
            }
        }
        LaneHits { hits: close & isa.le(t_min, t) & isa.le(t, t_max), ambiguous, t, v, w, determinant }
    }

    /// By how many roundings the sum of the weighted depths may be off, over those that grow with
    /// the sum itself: what moves a corner across the ray counts by the slope of the triangle, and
    /// what is lost of a weight by the depth of the triangle.
    #[inline(always)]
    fn distance_error<I: Isa>(&self, isa: I, determinant: V) -> V
    where
        V: Lanes<I>,
    {
        let [a, b, c] = self.corners;
        let lateral = isa.mul(self.lateral, isa.splat(LATERAL));
        let one = [isa.sub(b[0], a[0]), isa.sub(b[1], a[1]), isa.sub(b[2], a[2])];
        let other = [isa.sub(c[0], a[0]), isa.sub(c[1], a[1]), isa.sub(c[2], a[2])];
        let x = isa.abs(isa.fused_less(other[2], one[0], isa.mul(one[2], other[0])));
        let y = isa.abs(isa.fused_less(other[2], one[1], isa.mul(one[2], other[1])));
        let depth = isa.add(isa.abs(one[2]), isa.abs(other[2]));
        let lateral = isa.mul(isa.mul(lateral, lateral), isa.splat(DEPTH_BY_LATERAL));
        let weights = isa.fused(isa.abs(determinant), isa.splat(DEPTH_BY_AREA), lateral);
        let slope = isa.mul(isa.add(x, y), isa.splat(SLOPE_BY_SIZE));
        let depth = isa.fused(depth, weights, isa.splat(LEAST_DISTANCE_ERROR));
        isa.fused(slope, self.size, depth)
    }
}

/// A corner in sheared space.
#[inline(always)]
fn project<I: Isa, V: Lanes<I>>(isa: I, corner: [V; 3], origin: [V; 3], shear: [V; 3]) -> [V; 3] {
    let (x, y, z) = (isa.sub(corner[0], origin[0]), isa.sub(corner[1], origin[1]), isa.sub(corner[2], origin[2]));
    [isa.fused_less(shear[0], z, x), isa.fused_less(shear[1], z, y), isa.mul(shear[2], z)]
}

/// On which side of an edge the ray passes. Both products are rounded, never fused.
#[inline(always)]
fn edge<I: Isa, V: Lanes<I>>(isa: I, from: [V; 3], to: [V; 3]) -> V {
    isa.sub(isa.mul(from[0], to[1]), isa.mul(from[1], to[0]))
}

/// The error of an edge function is below 41 roundings of the lateral size times the size: how far
/// the corners are across the ray, and in all. Some more, to be sure.
const EDGE_ERROR: f32 = 48.0 * UNIT_ROUNDOFF;

/// The lateral size, times that error, is the sum of two parts: of a triangle that the ray meets,
/// corners are at most twice its extent across the ray, ...
const EDGE_BY_EXTENT: f32 = 2.0 * EDGE_ERROR;
/// ... and as much farther as they may have been moved.
const EDGE_BY_SIZE: f32 = 16.0 * UNIT_ROUNDOFF * EDGE_ERROR;
/// What leads back to the lateral size itself.
const LATERAL: f32 = 1.0 / EDGE_ERROR;

/// The depth of any corner is at most the depth of the first plus this many extents of the
/// triangle; so is its distance across the ray.
pub(crate) const REACH: f32 = 2.0;

/// What is added to that, far above what products can lose when they are denormal.
const LEAST_EDGE_ERROR: f32 = 16.0 * f32::MIN_POSITIVE;

/// The error of a distance that counts as small enough, in roundings: [`DISTANCE_ERROR`], less what
/// [`distance_error`] leaves out.
const MOST_DISTANCE_ERROR: f32 = DISTANCE_ERROR / UNIT_ROUNDOFF - 24.0;

/// Roundings by which a corner is moved across the ray, as a multiple of the size of everything.
const SLOPE_BY_SIZE: f32 = 9.0;
/// Roundings of the products in the three weights, as a multiple of the squared lateral size.
const DEPTH_BY_LATERAL: f32 = 6.0;
/// Roundings of the weights, the depths and their sums, as a multiple of the determinant.
const DEPTH_BY_AREA: f32 = 8.0;
/// Far above what is lost of a sum that is denormal.
const LEAST_DISTANCE_ERROR: f32 = 64.0 * f32::MIN_POSITIVE;

/// For exponents from -126 to 127.
#[inline(always)]
fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    const FLOOR: Triangle = Triangle { corners: [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]] };

    fn meets(ray: &Ray, triangle: &Triangle) -> Option<TriangleHit> {
        WatertightRay::new(&ray.validated()?).hit(triangle, ray.t_min.max(0.0), ray.t_max)
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
        // By the normal of the plane, which the test itself does not use; nothing where the ray
        // misses by a hair.
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
