//! Box tests of sixteen rays at a step: [`SafeRay`](crate::geometry::SafeRay) for a packet, by the same operations.

use super::rays::{Column, RayPacket, rows_of};
use crate::geometry::slab::{LEAST_SLOPE, Lean};
use crate::geometry::{Aabb, UNIT_ROUNDOFF};
use crate::simd::Isa;
use crate::wide::WideNode;

/// The rays of a packet, ready for tests against boxes within known bounds: `position * scale - offset` is the distance of a plane.
pub(crate) struct PacketPlanes {
    pub(crate) near_scale: [Column; 3],
    pub(crate) near_offset: [Column; 3],
    pub(crate) far_scale: [Column; 3],
    pub(crate) far_offset: [Column; 3],
    /// Rays that only double precision does justice.
    pub(crate) careful: u64,
}

impl PacketPlanes {
    /// For boxes all within `bounds`.
    #[inline(always)]
    pub(crate) fn new<I: Isa>(isa: I, rays: &RayPacket, bounds: &Aabb, lean: Lean) -> Self {
        let (slack, stray_share, parallel) = (lean.slack, lean.stray, lean.parallel());
        let farthest = bounds.min.iter().chain(&bounds.max).fold(0.0_f32, |most, x| most.max(x.abs()));
        let zero = [Column::splat(0.0); 3];
        let mut all = Self { near_scale: zero, near_offset: zero, far_scale: zero, far_offset: zero, careful: 0 };
        let mut overflowed = Column::splat(0.0);
        for row in 0..zero[0].0.len() {
            for lane in 0..16 {
                let (mut origin, mut direction) = ([0.0; 3], [0.0; 3]);
                let (mut largest, mut reach, mut stray, mut tame) = (0.0, 0.0, 0.0, true);
                for axis in 0..3 {
                    origin[axis] = rays.origin[axis].0[row].0[lane];
                    direction[axis] = rays.direction[axis].0[row].0[lane];
                    largest = larger(largest, direction[axis].abs());
                    reach = larger(reach, (bounds.min[axis] - origin[axis]).abs());
                    reach = larger(reach, (bounds.max[axis] - origin[axis]).abs());
                    stray = larger(stray, stray_share * origin[axis].abs());
                }
                for axis in 0..3 {
                    let step = larger(direction[axis].abs(), LEAST_SLOPE * largest).copysign(direction[axis]);
                    let reciprocal = 1.0 / step;
                    let flatness = reciprocal.abs() * largest;
                    let is_parallel = flatness > parallel;
                    let lean = (if is_parallel { 0.0 } else { flatness } + 1.0) * (slack * UNIT_ROUNDOFF);
                    let far_end = if is_parallel { slack * UNIT_ROUNDOFF * reach } else { 0.0 };
                    let stray = (stray + far_end) * reciprocal.abs();
                    let (near, far) = (reciprocal - reciprocal * lean, reciprocal + reciprocal * lean);
                    let (near_start, far_start) = (origin[axis] * near, origin[axis] * far);
                    let near_offset = near_start + (near_start.abs() * (4.0 * UNIT_ROUNDOFF) + stray);
                    let far_offset = far_start - (far_start.abs() * (4.0 * UNIT_ROUNDOFF) + stray);
                    all.near_scale[axis].0[row].0[lane] = near;
                    all.far_scale[axis].0[row].0[lane] = far;
                    all.near_offset[axis].0[row].0[lane] = near_offset;
                    all.far_offset[axis].0[row].0[lane] = far_offset;
                    tame &= near.abs() >= f32::MIN_POSITIVE;
                    tame &= near.abs() * farthest + near_offset.abs() <= f32::MAX;
                    tame &= far.abs() * farthest + far_offset.abs() <= f32::MAX;
                }
                overflowed.0[row].0[lane] = if tame { 0.0 } else { 1.0 };
            }
        }
        all.careful = overflowed.positive(isa);
        all
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
        for (row, _) in rows_of(set) {
            let (mut entry, mut exit) = (isa.load16(&t_min.0[row]), isa.load16(&t_max.0[row]));
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

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
