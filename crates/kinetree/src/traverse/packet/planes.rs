//! Box tests of sixteen rays at a step: [`SafeRay`](crate::geometry::SafeRay) for a packet, by the same operations.

use super::super::lanes::SINGLE_PRECISION_RANGE;
use super::rays::{Column, PACKET, RayPacket, lanes_of, size};
use crate::geometry::slab::ErrorBound;
use crate::geometry::{AT_LEAST, AT_MOST, Aabb, SafeRay, UNIT_ROUNDOFF};
use crate::simd::Isa;
use crate::wide::WideNode;

/// The rays of a packet, ready for tests against boxes within known bounds: `position * scale - offset` is the distance of a plane.
pub(crate) struct PacketPlanes {
    pub(crate) near_scale: [Column; 3],
    pub(crate) near_offset: [Column; 3],
    pub(crate) far_scale: [Column; 3],
    pub(crate) far_offset: [Column; 3],
    /// Rays that only double precision does justice.
    pub(crate) in_double: u64,
    /// By how much offsets are widened in proportion to the largest coordinate of a ray's origin, among others.
    pub(super) bound: ErrorBound,
    /// By how much more they are widened along each axis, at most, where rays run parallel to its planes.
    pub(super) parallel: [f32; 3],
}

impl PacketPlanes {
    /// Of the rays in the set, for boxes all within `bounds`.
    #[inline(always)]
    pub(crate) fn new<I: Isa>(isa: I, rays: &RayPacket, set: u64, bounds: &Aabb, bound: ErrorBound) -> Self {
        let zero = [Column::splat(0.0); 3];
        let mut all = Self {
            near_scale: zero,
            near_offset: zero,
            far_scale: zero,
            far_offset: zero,
            in_double: 0,
            bound,
            parallel: [0.0; 3],
        };
        if all.set_quickly(isa, rays, bounds, bound) & set != set {
            all.set_slowly(rays, set, bounds, bound);
        }
        all
    }

    /// The rays for which the short way is right: nothing about them is huge or tiny, and none is parallel to an axis.
    #[inline(always)]
    fn set_quickly<I: Isa>(&mut self, isa: I, rays: &RayPacket, bounds: &Aabb, bound: ErrorBound) -> u64 {
        let (error, four) = (isa.splat16(bound.roundings * UNIT_ROUNDOFF), isa.splat16(4.0 * UNIT_ROUNDOFF));
        let (range, one) = (isa.splat16(SINGLE_PRECISION_RANGE), isa.splat16(1.0));
        let mut fit = 0;
        for row in 0..rays.t_min.0.len() {
            let [x, y, z] = [&rays.direction[0].0[row], &rays.direction[1].0[row], &rays.direction[2].0[row]];
            let largest = isa.max16(size(isa, isa.load16(x)), size(isa, isa.load16(y)));
            let largest = isa.max16(largest, size(isa, isa.load16(z)));
            let [x, y, z] = [&rays.origin[0].0[row], &rays.origin[1].0[row], &rays.origin[2].0[row]];
            let farthest = isa.max16(size(isa, isa.load16(x)), size(isa, isa.load16(y)));
            let farthest = isa.max16(farthest, size(isa, isa.load16(z)));
            let mut origin_error = isa.mul16(farthest, isa.splat16(bound.origin_error));
            if bound.far.origin_error > 0.0 {
                let beyond = isa.max16(isa.sub16(farthest, isa.splat16(bound.far.padded_for)), isa.splat16(0.0));
                origin_error = isa.add16(origin_error, isa.mul16(beyond, isa.splat16(bound.far.origin_error)));
            }
            let mut lanes = isa.le16(isa.max16(largest, farthest), range);
            for axis in 0..3 {
                let origin = isa.load16(&rays.origin[axis].0[row]);
                let reciprocal = isa.load16(&rays.reciprocal[axis].0[row]);
                let steepness = size(isa, reciprocal);
                let flatness = isa.mul16(steepness, largest);
                lanes &= isa.le16(steepness, range) & isa.le16(flatness, isa.splat16(bound.parallel()));
                let bound = isa.mul16(reciprocal, isa.mul16(isa.add16(flatness, one), error));
                let (near, far) = (isa.sub16(reciprocal, bound), isa.add16(reciprocal, bound));
                let (near_start, far_start) = (isa.mul16(origin, near), isa.mul16(origin, far));
                let origin_error = isa.mul16(origin_error, steepness);
                let near_error = isa.add16(isa.mul16(size(isa, near_start), four), origin_error);
                let far_error = isa.add16(isa.mul16(size(isa, far_start), four), origin_error);
                self.near_scale[axis].0[row] = isa.store16(near);
                self.far_scale[axis].0[row] = isa.store16(far);
                self.near_offset[axis].0[row] = isa.store16(isa.add16(near_start, near_error));
                self.far_offset[axis].0[row] = isa.store16(isa.sub16(far_start, far_error));
            }
            fit |= u64::from(lanes) << (16 * row);
        }
        let fits = bounds.min.iter().chain(&bounds.max).all(|x| x.abs() <= SINGLE_PRECISION_RANGE);
        if fits { fit } else { 0 }
    }

    /// The long way, for any ray.
    #[cold]
    #[inline(never)]
    fn set_slowly(&mut self, rays: &RayPacket, set: u64, bounds: &Aabb, bound: ErrorBound) {
        for at in (0..PACKET).filter(|at| set >> at & 1 == 1) {
            let ray = rays.ray(at);
            let safe = SafeRay::new(&ray, bounds, bound);
            if safe.needs_double_precision() {
                self.in_double |= 1 << at;
                continue;
            }
            for axis in 0..3 {
                self.near_scale[axis].set(at, safe.near.scale[axis]);
                self.near_offset[axis].set(at, safe.near.offset[axis]);
                self.far_scale[axis].set(at, safe.far.scale[axis]);
                self.far_offset[axis].set(at, safe.far.offset[axis]);
                let leaning = safe.near.offset[axis] - ray.origin[axis] * safe.near.scale[axis];
                let leaning = leaning.max(ray.origin[axis] * safe.far.scale[axis] - safe.far.offset[axis]);
                self.parallel[axis] = self.parallel[axis].max(leaning);
            }
        }
    }

    /// Which rays of the set, all of one octant, enter the box of a lane between their bounds. `sides` are the planes that they meet first.
    #[inline(always)]
    pub(crate) fn enter<I: Isa>(
        &self,
        isa: I,
        (node, lane): (&WideNode, usize),
        sides: [usize; 3],
        set: u64,
        t_min: &Column,
        t_max: &Column,
    ) -> u64 {
        let (mut near, mut far) = ([isa.splat16(0.0); 3], [isa.splat16(0.0); 3]);
        for axis in 0..3 {
            near[axis] = isa.splat16(node.planes[axis][sides[axis] & 1][lane & 7]);
            far[axis] = isa.splat16(node.planes[axis][sides[axis] & 1 ^ 1][lane & 7]);
        }
        let mut entering = 0;
        for row in 0..t_min.0.len() {
            if lanes_of(set, row) == 0 {
                continue;
            }
            let mut entry = isa.mul16(isa.load16(&t_min.0[row]), isa.splat16(AT_LEAST));
            let mut exit = isa.mul16(isa.load16(&t_max.0[row]), isa.splat16(AT_MOST));
            for axis in 0..3 {
                let (near_scale, near_offset) = (&self.near_scale[axis].0[row], &self.near_offset[axis].0[row]);
                let (far_scale, far_offset) = (&self.far_scale[axis].0[row], &self.far_offset[axis].0[row]);
                // New value first: on NaN, `max` and `min` keep the second.
                entry = isa.max16(isa.mul_sub16(near[axis], isa.load16(near_scale), isa.load16(near_offset)), entry);
                exit = isa.min16(isa.mul_sub16(far[axis], isa.load16(far_scale), isa.load16(far_offset)), exit);
            }
            entering |= u64::from(isa.le16(entry, exit)) << (16 * row);
        }
        entering & set
    }
}
