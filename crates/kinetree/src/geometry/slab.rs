//! Does a ray enter a box, and where? Never no when a triangle in the box is hit.
//!
//! Hits of triangles are exact ([`watertight`](super::watertight)), but the box test rounds. So it leans
//! outwards by at least as much (compare Ize 2013, "Robust BVH Ray Traversal"), and over instances by
//! what taking a ray into their space may round. Everything is paid for once per ray:
//!
//! * along each axis the reciprocal is moved by a few roundings, more of them the flatter the ray runs
//!   to the planes of that axis;
//! * the scaled origin is moved by a few roundings of itself;
//! * along an axis on which the ray hardly moves, by a few roundings of the distance to the far end of
//!   everything.

use glam::Vec3A;

use super::{AT_LEAST, Aabb, Ray, UNIT_ROUNDOFF};

/// By how much box tests lean outwards.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lean {
    /// Roundings of distances along an axis.
    pub(crate) slack: f32,
    /// Share of the largest coordinate of a ray's origin by which the ray strays.
    pub(crate) stray: f32,
    /// What boxes are not already padded for.
    pub(crate) far: FarRays,
}

/// How rays stray whose origins are far away, over boxes that are padded for nearer ones.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FarRays {
    /// Boxes are padded for origins whose largest coordinate is at most this, metres.
    pub(crate) padded_for: f32,
    /// Share of what the largest coordinate exceeds that by.
    pub(crate) stray: f32,
}

impl FarRays {
    /// There is nothing that a far origin would make worse.
    pub(crate) const NONE: Self = Self { padded_for: 0.0, stray: 0.0 };
}

impl Lean {
    /// Over boxes of triangles, where a ray is made ready the long way or in a packet: more than is
    /// needed.
    pub(crate) const TRIANGLES: Self = Self { slack: 16.0, stray: 0.0, far: FarRays::NONE };

    /// Over boxes of triangles, by the roundings of the box test alone.
    pub(crate) const BARE: Self = Self { slack: 0.0, stray: 0.0, far: FarRays::NONE };

    /// Over world boxes of instances. Taking a ray to an instance mixes its coordinates, so that
    /// roundings of the largest one count on every axis: five of the origin, and twelve of `t`
    /// directions, those of the triangle test included, for each unit that a row of `|M||N|` sums
    /// to (see [`inverse`](super::inverse)). This is enough for
    /// [`PAID_BY_RAYS`](super::inverse::PAID_BY_RAYS) of them.
    pub(crate) const INSTANCES: Self = Self { slack: 64.0, stray: 16.0 * UNIT_ROUNDOFF, far: FarRays::NONE };

    /// Over world boxes of instances, some of which are skewed.
    #[inline(always)]
    pub(crate) const fn instances(far: FarRays) -> Self {
        Self { far, ..Self::INSTANCES }
    }

    /// By how much a ray strays whose origin has this as its largest coordinate, metres.
    #[inline(always)]
    pub(crate) fn stray(&self, farthest: f32) -> f32 {
        self.stray * farthest + self.far.stray * (farthest - self.far.padded_for).max(0.0)
    }

    /// A ray that runs flatter than this to the planes of an axis counts as parallel to them; leaning in proportion would lead nowhere.
    #[inline(always)]
    pub(crate) const fn parallel(self) -> f32 {
        let slack = if self.slack < Self::TRIANGLES.slack { Self::TRIANGLES.slack } else { self.slack };
        1.0 / (4.0 * slack * UNIT_ROUNDOFF)
    }
}

/// Direction components are at least this fraction of the largest one, with their sign kept.
pub(crate) const LEAST_SLOPE: f32 = 1.0 / (1 << 30) as f32;

/// A ray made ready for box tests against boxes within known bounds.
#[derive(Debug, Clone, Copy)]
pub struct SafeRay {
    pub(crate) near: Planes,
    pub(crate) far: Planes,
    /// The ray runs down this axis, so that the upper plane is met first.
    pub(crate) downwards: [bool; 3],
    pub(crate) t_min: f32,
    /// Present when single precision does not suffice for this ray.
    careful: Option<CarefulRay>,
}

/// Distances of planes along the ray, for each axis: `position * scale - offset`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Planes {
    pub(crate) scale: Vec3A,
    pub(crate) offset: Vec3A,
}

impl SafeRay {
    /// For boxes all within `bounds`. The ray is as [`Ray::sane`] made it.
    pub(crate) fn new(ray: &Ray, bounds: &Aabb, lean: Lean) -> Self {
        let (origin, direction) = (Vec3A::from(ray.origin), Vec3A::from(ray.direction));
        let (slack, stray) = (lean.slack, lean.stray(origin.abs().max_element()));
        let largest = direction.abs().max_element();
        let step = direction.abs().max(Vec3A::splat(LEAST_SLOPE * largest)).copysign(direction);
        let reciprocal = step.recip();
        // How much flatter the ray runs to an axis' planes than straight ahead.
        let flatness = reciprocal.abs() * largest;
        let parallel = lean.parallel();
        let (mut lean, mut stray_by) = (flatness, Vec3A::splat(stray));
        if flatness.max_element() > parallel {
            let is_parallel = flatness.cmpgt(Vec3A::splat(parallel));
            lean = Vec3A::select(is_parallel, Vec3A::ZERO, lean);
            let far_end = stray + slack * UNIT_ROUNDOFF * reach(ray.origin, bounds);
            stray_by = Vec3A::select(is_parallel, Vec3A::splat(far_end), stray_by);
        }
        let (lean, stray_by) = ((lean + 1.0) * (slack * UNIT_ROUNDOFF), stray_by * reciprocal.abs());
        let (near, far) = (reciprocal - reciprocal * lean, reciprocal + reciprocal * lean);
        let (near_origin, far_origin) = (origin * near, origin * far);
        let outwards = |scaled: Vec3A| scaled.abs() * (4.0 * UNIT_ROUNDOFF) + stray_by;
        let near = Planes { scale: near, offset: near_origin + outwards(near_origin) };
        let far = Planes { scale: far, offset: far_origin - outwards(far_origin) };
        // The distances must be finite too, or a plane far away would be no number instead of far away. The far side has the larger ones; a
        // scale of nothing would make no number of the planes of an empty box.
        let farthest = Vec3A::from(bounds.min).abs().max(Vec3A::from(bounds.max).abs());
        let most = far.scale.abs() * farthest + near.offset.abs().max(far.offset.abs());
        let is_tame = most.is_finite() && near.scale.abs().min_element() >= f32::MIN_POSITIVE;
        let careful = (!is_tame).then(|| CarefulRay {
            origin: ray.origin,
            direction: ray.direction,
            slack: slack * UNIT_ROUNDOFF * reach(ray.origin, bounds) + stray,
        });
        Self { near, far, downwards: ray.direction.map(f32::is_sign_negative), t_min: ray.t_min * AT_LEAST, careful }
    }

    /// Whether only double precision does this ray justice.
    #[inline(always)]
    pub(crate) fn needs_care(&self) -> bool {
        self.careful.is_some()
    }

    /// Where the ray enters the box, at the earliest, if it does so before `t_max`.
    #[inline]
    pub fn enter(&self, bounds: &Aabb, t_max: f32) -> Option<f32> {
        if let Some(careful) = &self.careful {
            return careful.enter(bounds, self.t_min, t_max);
        }
        let (mut entry, mut exit) = (self.t_min, t_max);
        for axis in 0..3 {
            let (low, high) = (bounds.min[axis], bounds.max[axis]);
            let (first, second) = if self.downwards[axis] { (high, low) } else { (low, high) };
            let near = first * self.near.scale[axis] - self.near.offset[axis];
            let far = second * self.far.scale[axis] - self.far.offset[axis];
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
struct CarefulRay {
    origin: [f32; 3],
    direction: [f32; 3],
    /// Metres by which boxes are widened.
    slack: f32,
}

impl CarefulRay {
    fn enter(&self, bounds: &Aabb, t_min: f32, t_max: f32) -> Option<f32> {
        let (mut entry, mut exit) = (f64::from(t_min), f64::from(t_max));
        if bounds.is_empty() {
            return None;
        }
        for axis in 0..3 {
            let (origin, step) = (f64::from(self.origin[axis]), f64::from(self.direction[axis]));
            let slack = f64::from(self.slack);
            let low = f64::from(bounds.min[axis]) - slack - origin;
            let high = f64::from(bounds.max[axis]) + slack - origin;
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
        SafeRay::new(&ray.sane().unwrap(), &bounds, Lean::TRIANGLES).enter(&bounds, ray.t_max)
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
            let safe = SafeRay::new(&ray, &Aabb::new([-1.0; 3], [1.0; 3]), Lean::TRIANGLES);
            assert_eq!(safe.enter(&Aabb::EMPTY, f32::INFINITY), None);
        }
    }
}
