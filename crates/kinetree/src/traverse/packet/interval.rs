//! One conservative test for all rays of an octant: intervals that contain their origins and
//! reciprocals, against eight boxes at once.

use super::planes::PacketPlanes;
use super::rays::{RayPacket, lanes_of, larger, largest_of_each};
use crate::geometry::UNIT_ROUNDOFF;
use crate::simd::Isa;
use crate::wide::WideNode;

/// Some rays of a packet that share an octant, with the minima and maxima of their coordinates. A
/// box that one of them enters is never ruled out.
///
/// Along each axis, signs are taken such that the rays run upwards: a plane at `position` stands at
/// `position * sign`.
#[derive(Clone, Copy)]
pub(crate) struct Interval<I: Isa> {
    /// Which side of a node's planes is met first.
    pub(crate) sides: [usize; 3],
    pub(crate) set: u64,
    axes: [Range<I>; 3],
}

/// What the distance of a plane is computed from along an axis: `(position - origin) * scale`,
/// within `error`.
#[derive(Clone, Copy)]
struct Range<I: Isa> {
    sign: I::F8,
    /// The farthest origin, from which planes are nearest.
    last: I::F8,
    first: I::F8,
    least: I::F8,
    most: I::F8,
    error: I::F8,
    /// The same, negative.
    minus: I::F8,
}

/// Roundings by which the ranges are widened; a test rounds three times.
const WIDENED: f32 = 4.0 * UNIT_ROUNDOFF;

/// By how many roundings of the scaled origin distances are widened and err: four by which offsets
/// are widened, two in making those, and twice what a test rounds.
const ERROR: f32 = 16.0 * UNIT_ROUNDOFF;

impl<I: Isa> Interval<I> {
    /// Of a set that is not empty and whose rays share an octant.
    #[inline(always)]
    pub(crate) fn new(isa: I, rays: &RayPacket, planes: &PacketPlanes, set: u64) -> Self {
        let first = set.trailing_zeros() & 63;
        let side = |axis: usize| (rays.negative[axis] >> first & 1) as usize;
        let sides = [side(0), side(1), side(2)];
        let ends = [
            ends(isa, rays, planes, (0, sides[0]), set),
            ends(isa, rays, planes, (1, sides[1]), set),
            ends(isa, rays, planes, (2, sides[2]), set),
        ];
        let mut farthest = 0.0_f32;
        for axis in 0..3 {
            let [last, minus_first, ..] = ends[axis];
            farthest = farthest.max(last).max(minus_first);
        }
        let zero = isa.splat(0.0);
        let nothing = Range { sign: zero, last: zero, first: zero, least: zero, most: zero, error: zero, minus: zero };
        let mut axes = [nothing; 3];
        for axis in 0..3 {
            let [last, minus_first, most, minus_least] = ends[axis];
            // Infinity times zero would be NaN.
            let most = (most * (1.0 + WIDENED)).min(f32::MAX);
            let error =
                (last.max(minus_first) * ERROR + planes.bound.origin_error(farthest)) * most + planes.parallel[axis];
            // A little more, so that a box that rays only touch, at no distance, is left after it
            // is entered.
            let error = (error * (1.0 + WIDENED) + f32::MIN_POSITIVE).min(f32::MAX);
            axes[axis] = Range {
                sign: isa.splat(if sides[axis] == 1 { -1.0 } else { 1.0 }),
                last: isa.splat(last),
                first: isa.splat(-minus_first),
                least: isa.splat(-minus_least * (1.0 - WIDENED)),
                most: isa.splat(most),
                error: isa.splat(error),
                minus: isa.splat(-error),
            };
        }
        Self { sides, set, axes }
    }

    /// Where the eight boxes may be entered at the earliest, and left at the latest or reached by
    /// `t_max`: entered are those where the first comes before the second, by their bits
    /// ([`Isa::lt_bits`]). `t_max` is not negative.
    #[inline(always)]
    pub(crate) fn enter(&self, isa: I, node: &WideNode, t_max: f32) -> (I::F8, I::F8) {
        // The float after it.
        let (mut entry, mut exit) = (isa.splat(0.0), isa.splat(f32::from_bits(t_max.to_bits() + 1)));
        for axis in 0..3 {
            let side = self.sides[axis] & 1;
            let Range { sign, last, first, least, most, error, minus } = self.axes[axis];
            let from = isa.mul_sub(isa.load(&node.planes[axis][side]), sign, last);
            let to = isa.mul_sub(isa.load(&node.planes[axis][side ^ 1]), sign, first);
            let from = isa.min(isa.mul_sub(from, least, error), isa.mul_sub(from, most, error));
            let to = isa.max(isa.mul_sub(to, least, minus), isa.mul_sub(to, most, minus));
            // There is no NaN, and entries are not negative. The boxes of lanes that are not in use
            // are inside out, and entered at infinity.
            entry = isa.max_bits(from, entry);
            exit = isa.min_bits(to, exit);
        }
        (entry, exit)
    }
}

/// The maxima of the origins along an axis and of the scales, and of their negatives.
#[inline(always)]
fn ends<I: Isa>(isa: I, rays: &RayPacket, planes: &PacketPlanes, (axis, side): (usize, usize), set: u64) -> [f32; 4] {
    let sign = isa.splat(if side == 1 { -1.0 } else { 1.0 });
    let minus = isa.splat(if side == 1 { 1.0 } else { -1.0 });
    let nothing = isa.splat(f32::NEG_INFINITY);
    let (mut last, mut minus_first, mut most, mut minus_least) = (nothing, nothing, nothing, nothing);
    for row in 0..rays.t_min.0.len() {
        let lanes = lanes_of(set, row);
        if lanes != 0 {
            let origin = isa.load(&rays.origin[axis].0[row]);
            last = larger(isa, last, isa.mul(origin, sign), lanes);
            minus_first = larger(isa, minus_first, isa.mul(origin, minus), lanes);
            most = larger(isa, most, isa.mul(isa.load(&planes.far_scale[axis].0[row]), sign), lanes);
            minus_least = larger(isa, minus_least, isa.mul(isa.load(&planes.near_scale[axis].0[row]), minus), lanes);
        }
    }
    isa.store(largest_of_each(isa, [last, minus_first, most, minus_least]))
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
