//! Box tests of sixteen rays at a step: [`SafeRay`](crate::geometry::SafeRay) for a packet, by the
//! same operations.

use super::super::lanes::SINGLE_PRECISION_RANGE;
use super::rays::{Column, PACKET, RayPacket, lanes_of, size};
use crate::geometry::slab::{ErrorBound, Slabs};
use crate::geometry::{AT_LEAST, AT_MOST, Aabb, SafeRay};
use crate::simd::Isa;
use crate::wide::WideNode;

/// The rays of a packet, ready for tests against boxes within known bounds: `position * scale -
/// offset` is the distance of a plane.
pub(crate) struct PacketPlanes {
    pub(crate) near_scale: [Column; 3],
    pub(crate) near_offset: [Column; 3],
    pub(crate) far_scale: [Column; 3],
    pub(crate) far_offset: [Column; 3],
    /// Rays for which single precision overflows.
    pub(crate) in_double: u64,
    /// By how much offsets are widened in proportion to the largest coordinate of a ray's origin,
    /// among others.
    pub(super) bound: ErrorBound,
    /// By how much more they are widened along each axis, at most, where rays run parallel to its
    /// planes.
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

    /// Prepares rays by vector instructions. Returns those for which that is right: they are
    /// neither parallel to an axis, nor is anything about them huge or tiny.
    #[inline(always)]
    fn set_quickly<I: Isa>(&mut self, isa: I, rays: &RayPacket, bounds: &Aabb, bound: ErrorBound) -> u64 {
        let range = isa.splat(SINGLE_PRECISION_RANGE);
        let mut fit = 0;
        for row in 0..rays.t_min.0.len() {
            let [x, y, z] = [&rays.direction[0].0[row], &rays.direction[1].0[row], &rays.direction[2].0[row]];
            let largest = isa.max(size(isa, isa.load(x)), size(isa, isa.load(y)));
            let largest = isa.max(largest, size(isa, isa.load(z)));
            let [x, y, z] = [&rays.origin[0].0[row], &rays.origin[1].0[row], &rays.origin[2].0[row]];
            let farthest = isa.max(size(isa, isa.load(x)), size(isa, isa.load(y)));
            let farthest = isa.max(farthest, size(isa, isa.load(z)));
            let mut origin_error = isa.mul(farthest, isa.splat(bound.origin_error));
            if bound.far.origin_error > 0.0 {
                let beyond = isa.max(isa.sub(farthest, isa.splat(bound.far.padded_for)), isa.splat(0.0));
                origin_error = isa.add(origin_error, isa.mul(beyond, isa.splat(bound.far.origin_error)));
            }
            let mut lanes = isa.le(isa.max(largest, farthest), range);
            for axis in 0..3 {
                let origin = isa.load(&rays.origin[axis].0[row]);
                let reciprocal = isa.load(&rays.reciprocal[axis].0[row]);
                let steepness = size(isa, reciprocal);
                let flatness = isa.mul(steepness, largest);
                lanes &= isa.le(steepness, range) & isa.le(flatness, isa.splat(bound.parallel()));
                let absolute = isa.mul(origin_error, steepness);
                let slabs = Slabs::new(isa, (origin, reciprocal), flatness, Some(absolute), bound);
                self.near_scale[axis].0[row] = isa.store(slabs.near_scale);
                self.far_scale[axis].0[row] = isa.store(slabs.far_scale);
                self.near_offset[axis].0[row] = isa.store(slabs.near_offset);
                self.far_offset[axis].0[row] = isa.store(slabs.far_offset);
            }
            fit |= u64::from(lanes) << (16 * row);
        }
        let fits = bounds.min.iter().chain(&bounds.max).all(|x| x.abs() <= SINGLE_PRECISION_RANGE);
        if fits { fit } else { 0 }
    }

    /// Prepares any rays, one by one.
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
                self.near_scale[axis].set(at, safe.slabs.near_scale[axis]);
                self.near_offset[axis].set(at, safe.slabs.near_offset[axis]);
                self.far_scale[axis].set(at, safe.slabs.far_scale[axis]);
                self.far_offset[axis].set(at, safe.slabs.far_offset[axis]);
                let widened = safe.slabs.near_offset[axis] - ray.origin[axis] * safe.slabs.near_scale[axis];
                let widened = widened.max(ray.origin[axis] * safe.slabs.far_scale[axis] - safe.slabs.far_offset[axis]);
                self.parallel[axis] = self.parallel[axis].max(widened);
            }
        }
    }

    /// Which rays of the set, all of one octant, enter the box of a lane between their bounds.
    /// `sides` are the planes that they meet first.
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
        let (mut near, mut far) = ([isa.splat::<I::F16>(0.0); 3], [isa.splat(0.0); 3]);
        for axis in 0..3 {
            near[axis] = isa.splat(node.planes[axis][sides[axis] & 1][lane & 7]);
            far[axis] = isa.splat(node.planes[axis][sides[axis] & 1 ^ 1][lane & 7]);
        }
        let mut entering = 0;
        for row in 0..t_min.0.len() {
            if lanes_of(set, row) == 0 {
                continue;
            }
            let mut entry = isa.mul(isa.load(&t_min.0[row]), isa.splat(AT_LEAST));
            let mut exit = isa.mul(isa.load(&t_max.0[row]), isa.splat(AT_MOST));
            for axis in 0..3 {
                let (near_scale, near_offset) = (&self.near_scale[axis].0[row], &self.near_offset[axis].0[row]);
                let (far_scale, far_offset) = (&self.far_scale[axis].0[row], &self.far_offset[axis].0[row]);
                // New value first: on NaN, `max` and `min` keep the second.
                entry = isa.max(isa.mul_sub(near[axis], isa.load(near_scale), isa.load(near_offset)), entry);
                exit = isa.min(isa.mul_sub(far[axis], isa.load(far_scale), isa.load(far_offset)), exit);
            }
            entering |= u64::from(isa.le(entry, exit)) << (16 * row);
        }
        entering & set
    }
}
