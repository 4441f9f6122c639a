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
    pub(crate) lanes: u32,
    /// Lanes that only exact arithmetic can decide; not in `lanes`.
    pub(crate) ambiguous: u32,
    pub(crate) back: u32,
    pub(crate) t: I::F16,
    v: I::F16,
    w: I::F16,
    determinant: I::F16,
}

impl<I: Isa> RowHits<I> {
    /// Weights of the second and the third corner.
    #[inline(always)]
    pub(crate) fn weights(&self, isa: I) -> [I::F16; 2] {
        [isa.div(self.v, self.determinant), isa.div(self.w, self.determinant)]
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
        (row, lanes): (usize, u32),
        t_max: &Column,
    ) -> RowHits<I> {
        let (mut origin, mut shear) = ([isa.splat(0.0); 3], [isa.splat(0.0); 3]);
        for axis in 0..3 {
            origin[axis] = isa.load(&rays.origin[axes[axis] % 3].0[row]);
            shear[axis] = isa.load(&self.shear[axis].0[row]);
        }
        let a = project(isa, &corners[0], &origin, &shear);
        let b = project(isa, &corners[1], &origin, &shear);
        let c = project(isa, &corners[2], &origin, &shear);
        let (u, v, w) = (edge(isa, &c, &b), edge(isa, &a, &c), edge(isa, &b, &a));
        let least = isa.min(isa.min(u, v), w);
        let most = isa.max(isa.max(u, v), w);
        let zero = isa.splat(0.0);
        let (mut lateral, mut size) = (zero, zero);
        let (possible, sure) = if WATERTIGHT {
            let reach = isa.max(isa.abs(shear[2]), isa.splat(REACH));
            size = isa.fused(isa.splat(extent), reach, isa.abs(a[2]));
            lateral = isa.fused(size, isa.splat(EDGE_BY_SIZE), isa.splat(extent * EDGE_BY_EXTENT));
            let error = isa.fused(size, lateral, isa.splat(LEAST_EDGE_ERROR));
            let minus = isa.sub(zero, error);
            let possible = !(isa.le(least, minus) & isa.le(error, most)) & lanes;
            (possible, possible & (isa.le(error, least) | isa.le(most, minus)))
        } else {
            let inside = (isa.le(zero, least) | isa.le(most, zero)) & lanes;
            (inside, inside)
        };
        let determinant = isa.add(isa.add(u, v), w);
        let back = isa.le(determinant, zero);
        if possible == 0 {
            return RowHits { lanes: 0, ambiguous: 0, back, t: zero, v, w, determinant };
        }
        let sum = isa.fused(w, c[2], isa.fused(v, b[2], isa.mul(u, a[2])));
        let t_scale = isa.load(&self.t_scale.0[row]);
        let t = isa.mul(isa.div(sum, determinant), t_scale);
        let (t_min, t_max) = (isa.load(&rays.t_min.0[row]), isa.load(&t_max.0[row]));
        let (mut close, mut ambiguous) = (sure, 0);
        if WATERTIGHT {
            let lateral = isa.mul(lateral, isa.splat(LATERAL));
            let error = distance_error(isa, [&a, &b, &c], [lateral, size], determinant);
            let bound = isa.mul(isa.abs(sum), isa.splat(MOST_DISTANCE_ERROR));
            close &= isa.le(error, bound) & isa.le(bound, isa.splat(f32::MAX));
            ambiguous = possible & !close;
            if ambiguous & sure != 0 {
                let scale = isa.mul(isa.splat(UNIT_ROUNDOFF), t_scale);
                let error = isa.mul(isa.div(error, isa.abs(determinant)), scale);
                let (nearest, farthest) = (isa.sub(t, error), isa.add(t, error));
                let outside = isa.le(farthest, t_min) & !isa.le(t_min, farthest)
                    | isa.le(t_max, nearest) & !isa.le(nearest, t_max);
                ambiguous &= !(sure & outside);
            }
        }
        let met = isa.le(t_min, t) & isa.le(t, t_max) & isa.le(t, isa.splat(f32::MAX));
        // Adding zero turns a negative zero into a positive one.
        RowHits { lanes: close & met, ambiguous, back, t: isa.add(t, zero), v, w, determinant }
    }
}

#[inline(always)]
fn project<I: Isa>(isa: I, corner: &[I::F16; 3], origin: &[I::F16; 3], shear: &[I::F16; 3]) -> [I::F16; 3] {
    let (x, y, z) = (isa.sub(corner[0], origin[0]), isa.sub(corner[1], origin[1]), isa.sub(corner[2], origin[2]));
    [isa.fused_less(shear[0], z, x), isa.fused_less(shear[1], z, y), isa.mul(shear[2], z)]
}

#[inline(always)]
fn edge<I: Isa>(isa: I, from: &[I::F16; 3], to: &[I::F16; 3]) -> I::F16 {
    isa.sub(isa.mul(from[0], to[1]), isa.mul(from[1], to[0]))
}

/// See [`crate::geometry::watertight`].
#[inline(always)]
fn distance_error<I: Isa>(
    isa: I,
    [a, b, c]: [&[I::F16; 3]; 3],
    [lateral, size]: [I::F16; 2],
    determinant: I::F16,
) -> I::F16 {
    let one = [isa.sub(b[0], a[0]), isa.sub(b[1], a[1]), isa.sub(b[2], a[2])];
    let other = [isa.sub(c[0], a[0]), isa.sub(c[1], a[1]), isa.sub(c[2], a[2])];
    let x = isa.abs(isa.fused_less(other[2], one[0], isa.mul(one[2], other[0])));
    let y = isa.abs(isa.fused_less(other[2], one[1], isa.mul(one[2], other[1])));
    let depth = isa.add(isa.abs(one[2]), isa.abs(other[2]));
    let lateral = isa.mul(isa.mul(lateral, lateral), isa.splat(DEPTH_BY_LATERAL));
    let weights = isa.fused(isa.abs(determinant), isa.splat(DEPTH_BY_AREA), lateral);
    let slope = isa.mul(isa.add(x, y), isa.splat(SLOPE_BY_SIZE));
    let depth = isa.fused(depth, weights, isa.splat(LEAST_DISTANCE_ERROR));
    isa.fused(slope, size, depth)
}
