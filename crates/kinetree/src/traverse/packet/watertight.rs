//! One triangle against sixteen rays: the test of [`watertight`](crate::geometry::watertight) with
//! a ray in each lane.

use super::super::WatertightLanes;
use super::rays::{Column, RayPacket};
use crate::geometry::{Edges, LaneHits, REACH, Ray};
use crate::simd::Isa;

/// A packet whose rays have become axes.
pub(crate) struct WatertightPacket {
    shear: [Column; 3],
    t_scale: Column,
    /// Rays whose direction is largest along each axis.
    pub(crate) along: [u64; 3],
}

impl WatertightPacket {
    #[inline(always)]
    pub(crate) fn new<I: Isa>(isa: I, rays: &RayPacket) -> Self {
        let zero = Column::splat(0.0);
        let mut all = Self { shear: [zero; 3], t_scale: zero, along: [0; 3] };
        let mut along = [zero; 3];
        for row in 0..zero.0.len() {
            for lane in 0..16 {
                let (x, y) = (rays.direction[0].0[row].0[lane], rays.direction[1].0[row].0[lane]);
                let z = rays.direction[2].0[row].0[lane];
                let (a, b, c) = (x.abs(), y.abs(), z.abs());
                let is_x = a >= b && a >= c;
                let is_y = !is_x && b >= c;
                // The direction in the order of the sheared space, before it is scaled and turned.
                let (x, y, z) = if is_x {
                    (y, z, x)
                } else if is_y {
                    (z, x, y)
                } else {
                    (x, y, z)
                };
                let exponent = ((z.to_bits() >> 23 & 0xff) as i32 - 127).clamp(-126, 126);
                let scale = f32::from_bits(((127 - exponent) as u32) << 23);
                let (x, y, z) = (x * scale, y * scale, z * scale);
                let (x, y) = if z < 0.0 { (y, x) } else { (x, y) };
                all.shear[0].0[row].0[lane] = x / z;
                all.shear[1].0[row].0[lane] = y / z;
                all.shear[2].0[row].0[lane] = 1.0 / z;
                all.t_scale.0[row].0[lane] = scale;
                along[0].0[row].0[lane] = if is_x { 1.0 } else { 0.0 };
                along[1].0[row].0[lane] = if is_y { 1.0 } else { 0.0 };
            }
        }
        all.along[0] = along[0].positive(isa);
        all.along[1] = along[1].positive(isa);
        all.along[2] = !(all.along[0] | all.along[1]);
        all
    }

    /// One ray for tests of four triangles; `alone` is the same ray, and its sheared space has
    /// these axes.
    #[inline(always)]
    pub(crate) fn alone<'a, I: Isa, const WATERTIGHT: bool>(
        &self,
        isa: I,
        ray: usize,
        alone: &'a Ray,
        axes: [usize; 3],
    ) -> WatertightLanes<'a, I, WATERTIGHT> {
        let shear = [self.shear[0].get(ray), self.shear[1].get(ray), self.shear[2].get(ray)];
        WatertightLanes::of_parts(isa, alone, axes, shear, self.t_scale.get(ray))
    }

    /// The bits of what belongs to one ray.
    #[cfg(test)]
    pub(super) fn of(&self, ray: usize) -> ([u32; 3], u32) {
        ([0, 1, 2].map(|axis| self.shear[axis].get(ray).to_bits()), self.t_scale.get(ray).to_bits())
    }

    /// The axes of the sheared space, in the order x, y, z, for rays along an axis, up or down.
    #[inline(always)]
    pub(crate) fn axes(along: usize, downwards: bool) -> [usize; 3] {
        let (x, y) = ([1, 2, 0][along % 3], [2, 0, 1][along % 3]);
        if downwards { [y, x, along] } else { [x, y, along] }
    }

    /// The hits of a row's `lanes`, whose sheared space has these axes, on a triangle, between the
    /// bounds, inclusive. The coordinates of corners stand in the order of the axes. `None` if no
    /// lane may be a hit.
    #[inline(always)]
    pub(crate) fn hits<I: Isa, const WATERTIGHT: bool>(
        &self,
        isa: I,
        rays: &RayPacket,
        axes: [usize; 3],
        (corners, extent): (&[[I::F16; 3]; 3], f32),
        (row, lanes): (usize, u32),
        t_max: &Column,
    ) -> Option<LaneHits<I::F16>> {
        let (mut origin, mut shear) = ([isa.splat(0.0); 3], [isa.splat(0.0); 3]);
        for axis in 0..3 {
            origin[axis] = isa.load(&rays.origin[axes[axis] % 3].0[row]);
            shear[axis] = isa.load(&self.shear[axis].0[row]);
        }
        let reach = isa.max(isa.abs(shear[2]), isa.splat(REACH));
        let edges = Edges::<_, WATERTIGHT>::new(isa, *corners, (origin, shear), [isa.splat(extent), reach], lanes);
        if !edges.is_possible() {
            return None;
        }
        let t_max = isa.min(isa.load(&t_max.0[row]), isa.splat(f32::MAX));
        let bounds = (isa.load(&rays.t_min.0[row]), t_max);
        Some(edges.intersect(isa, isa.load(&self.t_scale.0[row]), bounds))
    }
}
