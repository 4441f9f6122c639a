//! A ray prepared for tests against eight boxes at a step.
//!
//! Most rays are prepared in a few vector operations, by the formulas of [`SafeRay`]; those that
//! are parallel to an axis, or huge, or tiny, go through [`SafeRay`] itself.

use crate::geometry::slab::{ErrorBound, SafeRay, Slabs};
use crate::geometry::{AT_LEAST, Aabb, Affine, Ray};
use crate::simd::Isa;
use crate::wide::{LANES, NodeView};

/// Nothing overflows while origins, directions, their reciprocals and boxes are within this.
pub(super) const SINGLE_PRECISION_RANGE: f32 = (1_u64 << 60) as f32;

/// A ray in two registers: the origin with `t_min`, and the direction with `t_max`.
#[derive(Clone, Copy)]
pub(crate) struct RayQuads<I: Isa> {
    pub(super) origin: I::F4,
    pub(super) direction: I::F4,
}

impl<I: Isa> RayQuads<I> {
    #[inline(always)]
    pub(crate) fn new(isa: I, ray: &Ray) -> Self {
        let [origin, direction] = ray.quads();
        Self { origin: isa.load_elementwise(origin), direction: isa.load_elementwise(direction) }
    }

    /// The ray in another space, by the operations of [`Affine::transform_point`] and
    /// [`Affine::transform_vector`].
    #[inline(always)]
    pub(crate) fn moved(isa: I, ray: &Ray, map: &Affine) -> Self {
        let (x, y, z) = (quad(isa, map.x_axis), quad(isa, map.y_axis), quad(isa, map.z_axis));
        let origin = isa.add(turned(isa, (x, y, z), ray.origin), quad(isa, map.translation));
        let direction = turned(isa, (x, y, z), ray.direction);
        Self { origin: isa.with_last(origin, ray.t_min), direction: isa.with_last(direction, ray.t_max) }
    }

    #[inline(always)]
    pub(crate) fn ray(&self, isa: I) -> Ray {
        Ray::of_quads([isa.store(self.origin), isa.store(self.direction)])
    }
}

#[inline(always)]
fn quad<I: Isa>(isa: I, v: [f32; 3]) -> I::F4 {
    isa.load(&[v[0], v[1], v[2], 0.0])
}

/// A vector after the linear part of a map.
#[inline(always)]
fn turned<I: Isa>(isa: I, (x, y, z): (I::F4, I::F4, I::F4), v: [f32; 3]) -> I::F4 {
    let xy = isa.add(isa.mul(x, isa.splat(v[0])), isa.mul(y, isa.splat(v[1])));
    isa.add(xy, isa.mul(z, isa.splat(v[2])))
}

/// Tests a ray against the eight boxes of a node.
pub(crate) trait Boxes<I: Isa>: Copy {
    /// The distances of entry and exit. A box is entered where the entry comes before the exit by
    /// their bits ([`Isa::lt_bits`]). Entries are not negative. `limit` is the float after `t_max`.
    fn enter(&self, isa: I, node: NodeView<'_>, limit: I::F8) -> (I::F8, I::F8);
}

/// A ray in registers: one multiplication and addition per plane. See [`SafeRay`] for its error
/// bounds.
#[derive(Clone, Copy)]
pub(crate) struct RayLanes<I: Isa> {
    near_scale: [I::F8; 3],
    near_offset: [I::F8; 3],
    far_scale: [I::F8; 3],
    far_offset: [I::F8; 3],
    /// Which side of a node's planes is met first.
    near_side: [usize; 3],
    t_min: I::F8,
}

impl<I: Isa> RayLanes<I> {
    /// For boxes within the bounds. `None` when the ray has to be prepared by [`SafeRay`].
    #[inline(always)]
    pub(crate) fn new(isa: I, ray: &RayQuads<I>, bounds: &Aabb, bound: ErrorBound) -> Option<Self> {
        let RayQuads { origin, direction } = *ray;
        let largest = isa.largest_of_three(direction);
        let reciprocal = isa.div(isa.splat(1.0), direction);
        let size = isa.abs(reciprocal);
        // How much flatter the ray runs to an axis' planes than straight ahead.
        let flatness = isa.mul(size, largest);
        let origin_size = isa.abs(origin);
        let [low, high] = bounds.quads();
        let extent = isa.max(isa.abs(isa.load(low)), isa.abs(isa.load(high)));
        let range = isa.splat(SINGLE_PRECISION_RANGE);
        // NaN is the second operand of `max`, or the largest, and fails the comparison.
        let fits = isa.le(isa.max(size, isa.max(largest, origin_size)), range)
            & isa.le(flatness, isa.splat(bound.parallel()))
            & 7;
        if fits != 7 || isa.le(extent, range) != 15 {
            return None;
        }
        let absolute = if bound.origin_error > 0.0 {
            let farthest = isa.largest_of_three(origin);
            let mut origin_error = isa.mul(farthest, isa.splat(bound.origin_error));
            if bound.far.origin_error > 0.0 {
                let beyond = isa.max(isa.sub(farthest, isa.splat(bound.far.padded_for)), isa.splat(0.0));
                origin_error = isa.add(origin_error, isa.mul(beyond, isa.splat(bound.far.origin_error)));
            }
            Some(isa.mul(size, origin_error))
        } else {
            None
        };
        let slabs = Slabs::new(isa, (origin, reciprocal), flatness, absolute, bound);
        // A step of this walk adds where a plane's distance is `position * scale - offset`.
        let near_offset = isa.sub(isa.splat(0.0), slabs.near_offset);
        // A little more, so that a box that the ray only touches, at no distance, is left after it
        // is entered.
        let far_offset = isa.sub(isa.splat(f32::MIN_POSITIVE), slabs.far_offset);
        Some(Self {
            near_scale: spread(isa, slabs.near_scale),
            near_offset: spread(isa, near_offset),
            far_scale: spread(isa, slabs.far_scale),
            far_offset: spread(isa, far_offset),
            near_side: sides(isa, direction),
            t_min: isa.mul(isa.spread8::<3>(origin), isa.splat(AT_LEAST)),
        })
    }

    /// Of a ray that [`SafeRay`] has prepared.
    #[inline(always)]
    pub(crate) fn of(isa: I, ray: &RayQuads<I>, safe: &SafeRay) -> Self {
        let Slabs { near_scale, near_offset, far_scale, far_offset } = safe.slabs;
        let [x, y, z] = far_offset;
        Self {
            near_scale: splat(isa, near_scale),
            near_offset: splat(isa, [-near_offset[0], -near_offset[1], -near_offset[2]]),
            far_scale: splat(isa, far_scale),
            far_offset: splat(isa, [f32::MIN_POSITIVE - x, f32::MIN_POSITIVE - y, f32::MIN_POSITIVE - z]),
            near_side: sides(isa, ray.direction),
            t_min: isa.splat(safe.t_min),
        }
    }

    /// Where the ray meets the planes of an axis that it meets first.
    #[inline(always)]
    fn near(&self, isa: I, node: NodeView<'_>, axis: usize) -> I::F8 {
        let planes = isa.load(node.planes(axis, self.near_side[axis] & 1));
        isa.mul_add(planes, self.near_scale[axis], self.near_offset[axis])
    }

    /// Where the ray meets the opposite planes.
    #[inline(always)]
    fn far(&self, isa: I, node: NodeView<'_>, axis: usize) -> I::F8 {
        let planes = isa.load(node.planes(axis, self.near_side[axis] & 1 ^ 1));
        isa.mul_add(planes, self.far_scale[axis], self.far_offset[axis])
    }
}

#[inline(always)]
fn sides<I: Isa>(isa: I, direction: I::F4) -> [usize; 3] {
    let signs = isa.signs(direction) as usize;
    [signs & 1, signs >> 1 & 1, signs >> 2 & 1]
}

#[inline(always)]
fn spread<I: Isa>(isa: I, x: I::F4) -> [I::F8; 3] {
    [isa.spread8::<0>(x), isa.spread8::<1>(x), isa.spread8::<2>(x)]
}

// Closures and `map` are not always inlined into the kernel, and compiled without its instructions
// then; so axes are written out here.
#[inline(always)]
fn splat<I: Isa>(isa: I, x: [f32; 3]) -> [I::F8; 3] {
    [isa.splat(x[0]), isa.splat(x[1]), isa.splat(x[2])]
}

impl<I: Isa> Boxes<I> for RayLanes<I> {
    #[inline(always)]
    fn enter(&self, isa: I, node: NodeView<'_>, limit: I::F8) -> (I::F8, I::F8) {
        // There is no NaN, since the ray is within `SINGLE_PRECISION_RANGE`; `t_min` is not
        // negative, and an exit that is counts as none. The boxes of lanes that are not in use are
        // inside out, and entered at infinity.
        let entry = isa.max_bits(self.near(isa, node, 0), self.near(isa, node, 1));
        let entry = isa.max_bits(entry, isa.max_bits(self.near(isa, node, 2), self.t_min));
        let exit = isa.min_bits(self.far(isa, node, 0), self.far(isa, node, 1));
        let exit = isa.min_bits(exit, isa.min_bits(self.far(isa, node, 2), limit));
        (entry, exit)
    }
}

/// The box test in double precision, box by box, for rays whose reciprocals overflow.
#[derive(Clone, Copy)]
pub(crate) struct DoublePrecisionRay<'a>(pub(crate) &'a SafeRay);

impl<I: Isa> Boxes<I> for DoublePrecisionRay<'_> {
    #[inline(always)]
    fn enter(&self, isa: I, node: NodeView<'_>, limit: I::F8) -> (I::F8, I::F8) {
        let t_max = f32::from_bits(isa.store(limit)[0].to_bits() - 1);
        let (entry, exit) = self.0.enter_all(node, t_max);
        (isa.load(&entry), isa.load(&exit))
    }
}

impl SafeRay {
    #[cold]
    fn enter_all(&self, node: NodeView<'_>, t_max: f32) -> ([f32; 8], [f32; 8]) {
        let (mut entries, mut exits) = ([0.0; 8], [-1.0; 8]);
        for lane in 0..LANES {
            let planes = |side: usize| [0, 1, 2].map(|axis| node.planes(axis, side)[lane]);
            if let Some(entry) = self.enter(&Aabb::new(planes(0), planes(1)), t_max) {
                (entries[lane], exits[lane]) = (entry, f32::INFINITY);
            }
        }
        (entries, exits)
    }
}
