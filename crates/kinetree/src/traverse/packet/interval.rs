//! All rays of an octant in one: intervals that hold their origins and reciprocals, tested against eight boxes at once.

use super::planes::PacketPlanes;
use super::rays::{RayPacket, rows_of};
use crate::geometry::UNIT_ROUNDOFF;
use crate::simd::{Isa, Row};
use crate::wide::WideNode;

/// Some rays of a packet that share an octant, and the least and most of their numbers. A box that one of them enters is never ruled out.
///
/// Along each axis, signs are taken such that the rays run upwards: a plane at `position` stands at `position * sign`.
#[derive(Clone, Copy)]
pub(crate) struct Interval<I: Isa> {
    /// Which side of a node's planes is met first.
    pub(crate) sides: [usize; 3],
    pub(crate) set: u64,
    near: [Bound<I>; 3],
    far: [Bound<I>; 3],
    sign: [I::F8; 3],
    t_min: I::F8,
}

/// What the distance of a plane is computed from: `(position - origin) * scale - slack`, with the scale at one end of its range or the other.
#[derive(Clone, Copy)]
struct Bound<I: Isa> {
    origin: I::F8,
    least: I::F8,
    most: I::F8,
    slack: I::F8,
}

/// Roundings by which the ranges are widened; a test rounds three times.
const WIDENED: f32 = 4.0 * UNIT_ROUNDOFF;

impl<I: Isa> Interval<I> {
    /// Of a set that is not empty and whose rays share an octant.
    #[inline(always)]
    pub(crate) fn new(isa: I, rays: &RayPacket, planes: &PacketPlanes, set: u64) -> Self {
        let first = set.trailing_zeros() & 63;
        let sides = rays.negative.map(|negative| (negative >> first & 1) as usize);
        let zero = isa.splat8(0.0);
        let nothing = Bound { origin: zero, least: zero, most: zero, slack: zero };
        let t_min = isa.splat8(rays.t_min.smallest(isa, set, f32::INFINITY));
        let mut all = Self { sides, set, near: [nothing; 3], far: [nothing; 3], sign: [zero; 3], t_min };
        for axis in 0..3 {
            let (near, far) = (
                (&planes.near_scale[axis], &planes.near_offset[axis]),
                (&planes.far_scale[axis], &planes.far_offset[axis]),
            );
            all.near[axis] = Bound::new(isa, rays, near, (axis, sides[axis], true), set);
            all.far[axis] = Bound::new(isa, rays, far, (axis, sides[axis], false), set);
            all.sign[axis] = isa.splat8(if sides[axis] == 1 { -1.0 } else { 1.0 });
        }
        all
    }

    /// Which of the eight boxes may be entered before `t_max`, and where at the earliest.
    #[inline(always)]
    pub(crate) fn enter(&self, isa: I, node: &WideNode, t_max: I::F8) -> (u8, I::F8) {
        let (mut entry, mut exit) = (self.t_min, t_max);
        for axis in 0..3 {
            let side = self.sides[axis] & 1;
            let (near, far) = (&self.near[axis], &self.far[axis]);
            let from = isa.mul_sub8(isa.load8(&node.planes[axis][side]), self.sign[axis], near.origin);
            let to = isa.mul_sub8(isa.load8(&node.planes[axis][side ^ 1]), self.sign[axis], far.origin);
            let from = isa.min8(isa.mul_sub8(from, near.least, near.slack), isa.mul_sub8(from, near.most, near.slack));
            let to = isa.max8(isa.mul_sub8(to, far.least, far.slack), isa.mul_sub8(to, far.most, far.slack));
            // New value first: on NaN, `max` and `min` keep the second.
            entry = isa.max8(from, entry);
            exit = isa.min8(to, exit);
        }
        (isa.le8(entry, exit) & node.in_use, entry)
    }
}

impl<I: Isa> Bound<I> {
    #[inline(always)]
    fn new(
        isa: I,
        rays: &RayPacket,
        (scale, offset): (&super::Column, &super::Column),
        (axis, side, is_near): (usize, usize, bool),
        set: u64,
    ) -> Self {
        let sign = isa.splat16(if side == 1 { -1.0 } else { 1.0 });
        // The origin from which a plane is nearest, or farthest, and the most that the rays lean.
        let outwards = isa.splat16(if is_near { 1.0 } else { -1.0 });
        let zero = isa.splat16(0.0);
        let [mut least, mut most, mut origin, mut slack] =
            [f32::INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY, 0.0].map(|x| Row([x; 16]));
        for (row, lanes) in rows_of(set) {
            let at = isa.load16(&rays.origin[axis].0[row]);
            let (signed, scale) = (isa.load16(&scale.0[row]), isa.mul16(isa.load16(&scale.0[row]), sign));
            let scaled = isa.mul16(at, signed);
            let size = isa.max16(scaled, isa.sub16(zero, scaled));
            let lean = isa.mul16(isa.sub16(isa.load16(&offset.0[row]), scaled), outwards);
            let lean = isa.add16(lean, isa.mul16(size, isa.splat16(2.0 * WIDENED)));
            let start = isa.mul16(isa.mul16(at, sign), outwards);
            let low = isa.min16(scale, isa.load16(&least));
            isa.keep16(&mut least, lanes, low);
            let high = isa.max16(scale, isa.load16(&most));
            isa.keep16(&mut most, lanes, high);
            let start = isa.max16(start, isa.load16(&origin));
            isa.keep16(&mut origin, lanes, start);
            let lean = isa.max16(lean, isa.load16(&slack));
            isa.keep16(&mut slack, lanes, lean);
        }
        let outwards = if is_near { 1.0 } else { -1.0 };
        Self {
            origin: isa.splat8(least_or_most(&origin, true) * outwards),
            least: isa.splat8(least_or_most(&least, false) * (1.0 - WIDENED)),
            most: isa.splat8(least_or_most(&most, true) * (1.0 + WIDENED)),
            slack: isa.splat8(least_or_most(&slack, true) * (1.0 + WIDENED) * outwards),
        }
    }
}

#[inline(always)]
fn least_or_most(row: &Row, most: bool) -> f32 {
    super::rays::across(row, |a, b| if (a > b) == most { a } else { b })
}

/// The set, octant by octant.
#[inline(always)]
pub(crate) fn octants(mut set: u64, negative: [u64; 3]) -> impl Iterator<Item = u64> {
    std::iter::from_fn(move || {
        if set == 0 {
            return None;
        }
        let first = set.trailing_zeros() & 63;
        let alike = negative.iter().fold(set, |alike, axis| alike & if axis >> first & 1 == 1 { *axis } else { !axis });
        set &= !alike;
        Some(alike)
    })
}
