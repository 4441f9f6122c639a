//! The conservative slab test: does a ray enter a box, and where? Never "no" when a triangle in the
//! box is hit.
//!
//! Hits of triangles are exact ([`watertight`](super::watertight)), but the box test rounds. So
//! boxes are widened by a bound of that error (compare Ize 2013, "Robust BVH Ray Traversal"), and
//! those of instances by a bound of what transforming the ray may round too. All of it is computed
//! once per ray:
//!
//! * along each axis the reciprocal is moved by a few roundings, more of them the flatter the ray runs
//!   to the planes of that axis;
//! * the scaled origin is moved by a few roundings of itself;
//! * along an axis on which the ray hardly moves, by a few roundings of the distance to the far end of
//!   everything.

use glam::Vec3A;

use super::{AT_LEAST, Aabb, Ray, UNIT_ROUNDOFF};
use crate::simd::{Isa, Lanes, Scalar};

/// A bound of the errors that a box test has to allow for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ErrorBound {
    /// Roundings of distances along an axis.
    pub(crate) roundings: f32,
    /// Error of the origin, as a fraction of its largest coordinate.
    pub(crate) origin_error: f32,
    /// What boxes are not already padded for.
    pub(crate) far: FarRays,
}

/// The further error of rays from far away, over boxes that are padded for origins that are nearer.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FarRays {
    /// Boxes are padded for origins whose largest coordinate is at most this, metres.
    pub(crate) padded_for: f32,
    /// Error as a fraction of what the largest coordinate exceeds that by.
    pub(crate) origin_error: f32,
}

impl FarRays {
    /// There is nothing that a far origin would make worse.
    pub(crate) const NONE: Self = Self { padded_for: 0.0, origin_error: 0.0 };
}

impl ErrorBound {
    /// Over boxes of triangles, for rays that [`SafeRay`] prepares and for packets: more than is
    /// needed.
    pub(crate) const TRIANGLES: Self = Self { roundings: 16.0, origin_error: 0.0, far: FarRays::NONE };

    /// Over boxes of triangles: the roundings of the box test alone.
    pub(crate) const BOX_TEST: Self = Self { roundings: 0.0, origin_error: 0.0, far: FarRays::NONE };

    /// Over world boxes of instances. Taking a ray to an instance mixes its coordinates, so that
    /// roundings of the largest one count on every axis: five of the origin, and twelve of `t`
    /// directions, those of the triangle test included, for each unit that a row of `|M||N|` sums
    /// to (see [`inverse`](super::inverse)). This is enough for
    /// [`COVERED_SKEW`](super::inverse::COVERED_SKEW) of them.
    pub(crate) const INSTANCES: Self = Self { roundings: 64.0, origin_error: 16.0 * UNIT_ROUNDOFF, far: FarRays::NONE };

    /// Over world boxes of instances, some of which are skewed.
    #[inline(always)]
    pub(crate) const fn instances(far: FarRays) -> Self {
        Self { far, ..Self::INSTANCES }
    }

    /// Error of an origin whose largest coordinate is `farthest`, metres.
    #[inline(always)]
    pub(crate) fn origin_error(&self, farthest: f32) -> f32 {
        self.origin_error * farthest + self.far.origin_error * (farthest - self.far.padded_for).max(0.0)
    }

    /// A ray that runs flatter than this to the planes of an axis counts as
    /// parallel to them: an error in proportion to the flatness would exceed everything.
    #[inline(always)]
    pub(crate) const fn parallel(self) -> f32 {
        let roundings =
            if self.roundings < Self::TRIANGLES.roundings { Self::TRIANGLES.roundings } else { self.roundings };
        1.0 / (4.0 * roundings * UNIT_ROUNDOFF)
    }
}

/// Direction components are at least this fraction of the largest one, with their sign kept.
pub(crate) const LEAST_SLOPE: f32 = 1.0 / (1 << 30) as f32;

/// A ray prepared for tests against boxes within known bounds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SafeRay {
    /// Along each axis.
    pub(crate) slabs: Slabs<[f32; 3]>,
    /// The ray runs down this axis, so that the upper plane is met first.
    pub(crate) downwards: [bool; 3],
    pub(crate) t_min: f32,
    /// Present when reciprocals or scaled origins overflow in single precision.
    in_double: Option<DoublePrecisionSlabs>,
}

/// Distances of planes along rays: `position * scale - offset`, for the planes that are met first
/// and for the opposite ones. A lane is an axis of a ray, or a ray along one axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slabs<V> {
    pub(crate) near_scale: V,
    pub(crate) near_offset: V,
    pub(crate) far_scale: V,
    pub(crate) far_offset: V,
}

impl<V: Copy> Slabs<V> {
    /// `flatness` is how much flatter the ray runs to the planes than straight ahead, and
    /// `absolute` a further error of distances.
    #[inline(always)]
    pub(crate) fn new<I: Isa>(
        isa: I,
        (origin, reciprocal): (V, V),
        flatness: V,
        absolute: Option<V>,
        bound: ErrorBound,
    ) -> Self
    where
        V: Lanes<I>,
    {
        let (near, far) = if bound.roundings > 0.0 {
            let relative = isa.mul(isa.add(flatness, isa.splat(1.0)), isa.splat(bound.roundings * UNIT_ROUNDOFF));
            let error = isa.mul(reciprocal, relative);
            (isa.sub(reciprocal, error), isa.add(reciprocal, error))
        } else {
            // Two roundings for each of two axes, and as many again.
            (reciprocal, isa.mul(reciprocal, isa.splat(1.0 + 8.0 * UNIT_ROUNDOFF)))
        };
        let (near_start, far_start) = (isa.mul(origin, near), isa.mul(origin, far));
        let four = isa.splat(4.0 * UNIT_ROUNDOFF);
        let (mut near_error, mut far_error) = (isa.mul(isa.abs(near_start), four), isa.mul(isa.abs(far_start), four));
        if let Some(absolute) = absolute {
            (near_error, far_error) = (isa.add(near_error, absolute), isa.add(far_error, absolute));
        }
        Self {
            near_scale: near,
            near_offset: isa.add(near_start, near_error),
            far_scale: far,
            far_offset: isa.sub(far_start, far_error),
        }
    }
}

impl SafeRay {
    /// For boxes all within `bounds`. The ray is as [`Ray::validated`] made it.
    pub(crate) fn new(ray: &Ray, bounds: &Aabb, bound: ErrorBound) -> Self {
        let (origin, direction) = (Vec3A::from(ray.origin), Vec3A::from(ray.direction));
        let (roundings, origin_error) = (bound.roundings, bound.origin_error(origin.abs().max_element()));
        let largest = direction.abs().max_element();
        let step = direction.abs().max(Vec3A::splat(LEAST_SLOPE * largest)).copysign(direction);
        let reciprocal = step.recip();
        // How much flatter the ray runs to an axis' planes than straight ahead.
        let flatness = reciprocal.abs() * largest;
        let parallel = bound.parallel();
        let (mut relative, mut absolute) = (flatness, Vec3A::splat(origin_error));
        if flatness.max_element() > parallel {
            let is_parallel = flatness.cmpgt(Vec3A::splat(parallel));
            relative = Vec3A::select(is_parallel, Vec3A::ZERO, relative);
            let at_far_end = origin_error + roundings * UNIT_ROUNDOFF * reach(ray.origin, bounds);
            absolute = Vec3A::select(is_parallel, Vec3A::splat(at_far_end), absolute);
        }
        let absolute = (absolute * reciprocal.abs()).to_array();
        let ray_along = (ray.origin, reciprocal.to_array());
        let slabs = Slabs::new(Scalar, ray_along, relative.to_array(), Some(absolute), bound);
        // The distances must be finite too, or a plane far away would be NaN instead of far away.
        // The far side has the larger ones; a scale of zero would make NaN of the planes of an
        // empty box.
        let farthest = Vec3A::from(bounds.min).abs().max(Vec3A::from(bounds.max).abs());
        let (near_offset, far_offset) = (Vec3A::from(slabs.near_offset), Vec3A::from(slabs.far_offset));
        let most = Vec3A::from(slabs.far_scale).abs() * farthest + near_offset.abs().max(far_offset.abs());
        let fits_single = most.is_finite() && Vec3A::from(slabs.near_scale).abs().min_element() >= f32::MIN_POSITIVE;
        let in_double = (!fits_single).then(|| DoublePrecisionSlabs {
            origin: ray.origin,
            direction: ray.direction,
            padding: roundings * UNIT_ROUNDOFF * reach(ray.origin, bounds) + origin_error,
        });
        Self { slabs, downwards: ray.direction.map(f32::is_sign_negative), t_min: ray.t_min * AT_LEAST, in_double }
    }

    /// Whether single precision overflows for this ray.
    #[inline(always)]
    pub(crate) fn needs_double_precision(&self) -> bool {
        self.in_double.is_some()
    }

    /// Where the ray enters the box, at the earliest, if it does so before `t_max`.
    #[inline]
    pub(crate) fn enter(&self, bounds: &Aabb, t_max: f32) -> Option<f32> {
        if let Some(in_double) = &self.in_double {
            return in_double.enter(bounds, self.t_min, t_max);
        }
        let (mut entry, mut exit) = (self.t_min, t_max);
        for axis in 0..3 {
            let (low, high) = (bounds.min[axis], bounds.max[axis]);
            let (first, second) = if self.downwards[axis] { (high, low) } else { (low, high) };
            let near = first * self.slabs.near_scale[axis] - self.slabs.near_offset[axis];
            let far = second * self.slabs.far_scale[axis] - self.slabs.far_offset[axis];
            entry = if near > entry { near } else { entry };
            exit = if far < exit { far } else { exit };
        }
        (entry <= exit).then_some(entry)
    }
}

/// The largest distance along an axis between a point and anything in the bounds.
#[cold]
fn reach(origin: [f32; 3], bounds: &Aabb) -> f32 {
    (0..3).fold(0.0, |most, axis| {
        most.max((bounds.min[axis] - origin[axis]).abs()).max((bounds.max[axis] - origin[axis]).abs())
    })
}

/// The same question in double precision, for rays whose reciprocals or scaled origins overflow.
#[derive(Debug, Clone, Copy)]
struct DoublePrecisionSlabs {
    origin: [f32; 3],
    direction: [f32; 3],
    /// Metres by which boxes are widened.
    padding: f32,
}

impl DoublePrecisionSlabs {
    fn enter(&self, bounds: &Aabb, t_min: f32, t_max: f32) -> Option<f32> {
        let (mut entry, mut exit) = (f64::from(t_min), f64::from(t_max));
        if bounds.is_empty() {
            return None;
        }
        for axis in 0..3 {
            let (origin, step) = (f64::from(self.origin[axis]), f64::from(self.direction[axis]));
            let padding = f64::from(self.padding);
            let low = f64::from(bounds.min[axis]) - padding - origin;
            let high = f64::from(bounds.max[axis]) + padding - origin;
            if step == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (one, other) = (low / step, high / step);
            entry = entry.max(one.min(other));
            exit = exit.min(one.max(other));
        }
        // Rounded down when it becomes an `f32`.
        (entry <= exit).then(|| (entry as f32).next_down().max(t_min))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn enters(ray: &Ray, bounds: Aabb) -> Option<f32> {
        SafeRay::new(&ray.validated().unwrap(), &bounds, ErrorBound::TRIANGLES).enter(&bounds, ray.t_max)
    }

    #[test]
    fn a_box_is_entered_where_it_stands() {
        let bounds = Aabb::new([1.0, -1.0, -1.0], [2.0, 1.0, 1.0]);
        let entry = enters(&Ray::new([0.0; 3], [1.0, 0.0, 0.0]), bounds).unwrap();
        assert!((entry - 1.0).abs() < 1e-5 && entry <= 1.0);
        assert!(enters(&Ray::new([0.0; 3], [-1.0, 0.0, 0.0]), bounds).is_none());
        assert!(enters(&Ray::new([0.0; 3], [1.0, 0.0, 0.0]).with_range(0.0, 0.9), bounds).is_none());
        assert!(enters(&Ray::new([0.0, 1.1, 0.0], [1.0, 0.0, 0.0]), bounds).is_none());
    }

    #[test]
    fn rays_in_the_plane_of_a_face_enter() {
        let ground = Aabb::new([-500.0, 0.0, -500.0], [500.0, 0.0, 500.0]);
        for direction in [[1.0, 0.0, 0.0], [1.0, -0.0, 0.3], [0.0, 0.0, -1.0], [1.0, 1e-20, 1.0]] {
            assert!(
                enters(&Ray::new([-600.0 * direction[0], 0.0, -600.0 * direction[2]], direction), ground).is_some()
            );
            assert!(enters(&Ray::new([0.0; 3], direction), ground).is_some());
        }
    }

    #[test]
    fn short_and_long_directions_keep_their_slope() {
        let bounds = Aabb::new([1.0, 2.0, -1.0], [1.1, 2.2, 1.0]);
        for size in [1e-38_f32, 1e-30, 1e-25, 1.0, 1e25, 1e37] {
            assert!(enters(&Ray::new([0.0; 3], [size, 2.0 * size, 0.0]), bounds).is_some(), "{size}");
            assert!(enters(&Ray::new([0.0; 3], [size, size, 0.0]), bounds).is_none(), "{size}");
        }
    }

    #[test]
    fn an_empty_box_is_never_entered() {
        for direction in [[1.0, 0.0, 0.0], [1.0, 1.0, 1.0], [-1.0, 1e-30, 0.0]] {
            let ray = Ray::new([0.0; 3], direction);
            let safe = SafeRay::new(&ray, &Aabb::new([-1.0; 3], [1.0; 3]), ErrorBound::TRIANGLES);
            assert_eq!(safe.enter(&Aabb::EMPTY, f32::INFINITY), None);
        }
    }
}
