//! One triangle against sixteen rays: the watertight test, operation for operation as in
//! [`WatertightRay::hit`](crate::geometry::WatertightRay::hit), so that hits agree to the bit.

use super::super::WatertightLanes;
use super::rays::{Column, RayPacket};
use crate::geometry::{
    DEPTH_BY_AREA, DEPTH_BY_LATERAL, EDGE_BY_EXTENT, EDGE_BY_SIZE, LATERAL, LEAST_DISTANCE_ERROR, LEAST_EDGE_ERROR,
    MOST_DISTANCE_ERROR, REACH, Ray, SLOPE_BY_SIZE, UNIT_ROUNDOFF,
};
use crate::simd::Isa;

/// A packet whose rays have become axes.
pub(crate) struct WatertightPacket {
    shear: [Column; 3],
    t_scale: Column,
    /// Rays whose direction is largest along each axis.
    pub(crate) along: [u64; 3],
}

/// Where the rays of a row meet a triangle.
#[derive(Clone, Copy)]
pub(crate) struct RowHits<I: Isa> {
    pub(crate) lanes: u16,
    /// Lanes that only exact arithmetic can decide; not in `lanes`.
    pub(crate) ambiguous: u16,
    pub(crate) back: u16,
    pub(crate) t: I::F16,
    v: I::F16,
    w: I::F16,
    determinant: I::F16,
}

impl<I: Isa> RowHits<I> {
    /// Weights of the second and the third corner.
    #[inline(always)]
    pub(crate) fn weights(&self, isa: I) -> [I::F16; 2] {
        [isa.div16(self.v, self.determinant), isa.div16(self.w, self.determinant)]
    }
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

    /// One ray for tests of four triangles; `alone` is the same ray, and its sheared space has these axes.
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

    /// Watertight or in single precision throughout, the hits of those `lanes` of a row whose sheared space has these axes, between the bounds, inclusive. The corners' numbers stand in the order of the axes.
    #[inline(always)]
    pub(crate) fn hits<I: Isa, const WATERTIGHT: bool>(
        &self,
        isa: I,
        rays: &RayPacket,
        axes: [usize; 3],
        (corners, extent): (&[[I::F16; 3]; 3], f32),
        (row, lanes): (usize, u16),
        t_max: &Column,
    ) -> RowHits<I> {
        let (mut origin, mut shear) = ([isa.splat16(0.0); 3], [isa.splat16(0.0); 3]);
        for axis in 0..3 {
            origin[axis] = isa.load16(&rays.origin[axes[axis] % 3].0[row]);
            shear[axis] = isa.load16(&self.shear[axis].0[row]);
        }
        let a = project(isa, &corners[0], &origin, &shear);
        let b = project(isa, &corners[1], &origin, &shear);
        let c = project(isa, &corners[2], &origin, &shear);
        let (u, v, w) = (edge(isa, &c, &b), edge(isa, &a, &c), edge(isa, &b, &a));
        let least = isa.min16(isa.min16(u, v), w);
        let most = isa.max16(isa.max16(u, v), w);
        let zero = isa.splat16(0.0);
        let (mut lateral, mut size) = (zero, zero);
        let (possible, sure) = if WATERTIGHT {
            let reach = isa.max16(isa.abs16(shear[2]), isa.splat16(REACH));
            size = isa.fused16(isa.splat16(extent), reach, isa.abs16(a[2]));
            lateral = isa.fused16(size, isa.splat16(EDGE_BY_SIZE), isa.splat16(extent * EDGE_BY_EXTENT));
            let error = isa.fused16(size, lateral, isa.splat16(LEAST_EDGE_ERROR));
            let minus = isa.sub16(zero, error);
            let possible = !(isa.le16(least, minus) & isa.le16(error, most)) & lanes;
            (possible, possible & (isa.le16(error, least) | isa.le16(most, minus)))
        } else {
            let inside = (isa.le16(zero, least) | isa.le16(most, zero)) & lanes;
            (inside, inside)
        };
        let determinant = isa.add16(isa.add16(u, v), w);
        let back = isa.le16(determinant, zero);
        if possible == 0 {
            return RowHits { lanes: 0, ambiguous: 0, back, t: zero, v, w, determinant };
        }
        let sum = isa.fused16(w, c[2], isa.fused16(v, b[2], isa.mul16(u, a[2])));
        let t_scale = isa.load16(&self.t_scale.0[row]);
        let t = isa.mul16(isa.div16(sum, determinant), t_scale);
        let (t_min, t_max) = (isa.load16(&rays.t_min.0[row]), isa.load16(&t_max.0[row]));
        let (mut close, mut ambiguous) = (sure, 0);
        if WATERTIGHT {
            let lateral = isa.mul16(lateral, isa.splat16(LATERAL));
            let error = distance_error(isa, [&a, &b, &c], [lateral, size], determinant);
            let bound = isa.mul16(isa.abs16(sum), isa.splat16(MOST_DISTANCE_ERROR));
            close &= isa.le16(error, bound) & isa.le16(bound, isa.splat16(f32::MAX));
            ambiguous = possible & !close;
            if ambiguous & sure != 0 {
                let scale = isa.mul16(isa.splat16(UNIT_ROUNDOFF), t_scale);
                let error = isa.mul16(isa.div16(error, isa.abs16(determinant)), scale);
                let (nearest, farthest) = (isa.sub16(t, error), isa.add16(t, error));
                let outside = isa.le16(farthest, t_min) & !isa.le16(t_min, farthest)
                    | isa.le16(t_max, nearest) & !isa.le16(nearest, t_max);
                ambiguous &= !(sure & outside);
            }
        }
        let met = isa.le16(t_min, t) & isa.le16(t, t_max) & isa.le16(t, isa.splat16(f32::MAX));
        // Adding zero turns a negative zero into a positive one.
        RowHits { lanes: close & met, ambiguous, back, t: isa.add16(t, zero), v, w, determinant }
    }
}

#[inline(always)]
fn project<I: Isa>(isa: I, corner: &[I::F16; 3], origin: &[I::F16; 3], shear: &[I::F16; 3]) -> [I::F16; 3] {
    let (x, y, z) = (isa.sub16(corner[0], origin[0]), isa.sub16(corner[1], origin[1]), isa.sub16(corner[2], origin[2]));
    [isa.fused_less16(shear[0], z, x), isa.fused_less16(shear[1], z, y), isa.mul16(shear[2], z)]
}

#[inline(always)]
fn edge<I: Isa>(isa: I, from: &[I::F16; 3], to: &[I::F16; 3]) -> I::F16 {
    isa.sub16(isa.mul16(from[0], to[1]), isa.mul16(from[1], to[0]))
}

/// See [`crate::geometry::watertight`].
#[inline(always)]
fn distance_error<I: Isa>(
    isa: I,
    [a, b, c]: [&[I::F16; 3]; 3],
    [lateral, size]: [I::F16; 2],
    determinant: I::F16,
) -> I::F16 {
    let one = [isa.sub16(b[0], a[0]), isa.sub16(b[1], a[1]), isa.sub16(b[2], a[2])];
    let other = [isa.sub16(c[0], a[0]), isa.sub16(c[1], a[1]), isa.sub16(c[2], a[2])];
    let x = isa.abs16(isa.fused_less16(other[2], one[0], isa.mul16(one[2], other[0])));
    let y = isa.abs16(isa.fused_less16(other[2], one[1], isa.mul16(one[2], other[1])));
    let depth = isa.add16(isa.abs16(one[2]), isa.abs16(other[2]));
    let lateral = isa.mul16(isa.mul16(lateral, lateral), isa.splat16(DEPTH_BY_LATERAL));
    let weights = isa.fused16(isa.abs16(determinant), isa.splat16(DEPTH_BY_AREA), lateral);
    let slope = isa.mul16(isa.add16(x, y), isa.splat16(SLOPE_BY_SIZE));
    let depth = isa.fused16(depth, weights, isa.splat16(LEAST_DISTANCE_ERROR));
    isa.fused16(slope, size, depth)
}
