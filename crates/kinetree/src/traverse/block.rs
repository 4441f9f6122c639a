//! Four triangles against one ray: the watertight test, operation for operation as in
//! [`WatertightRay::hit`], so that hits agree to the bit.

use super::RayQuads;
use crate::geometry::{
    DEPTH_BY_AREA, DEPTH_BY_LATERAL, EDGE_BY_EXTENT, EDGE_BY_SIZE, LATERAL, LEAST_DISTANCE_ERROR, LEAST_EDGE_ERROR,
    MOST_DISTANCE_ERROR, OTHERS, REACH, Ray, SLOPE_BY_SIZE, TriangleHit, UNIT_ROUNDOFF, WatertightRay, exact,
};
use crate::simd::Isa;
use crate::wide::TriangleBlock;

/// A sheared ray in registers, for tests that are watertight or in single precision throughout ([`WatertightRay::hit_fast`]).
#[derive(Clone, Copy)]
pub(crate) struct WatertightLanes<'a, I: Isa, const WATERTIGHT: bool> {
    ray: &'a Ray,
    axes: [usize; 3],
    origin: [I::F4; 3],
    shear: [I::F4; 3],
    t_scale: I::F4,
    t_min: I::F4,
    /// See [`WatertightRay::reach`].
    reach: f32,
}

impl<'a, I: Isa, const WATERTIGHT: bool> WatertightLanes<'a, I, WATERTIGHT> {
    #[inline(always)]
    pub(crate) fn new(isa: I, ray: &'a Ray) -> Self {
        let WatertightRay { axes, shear, t_scale, .. } = WatertightRay::new(ray);
        Self::of_parts(isa, ray, axes, shear, t_scale)
    }

    /// Of a ray that has been watertight.
    #[inline(always)]
    pub(super) fn of_parts(isa: I, ray: &'a Ray, axes: [usize; 3], shear: [f32; 3], t_scale: f32) -> Self {
        let origin = &ray.quads()[0];
        Self {
            ray,
            axes,
            origin: [isa.splat(origin[axes[0] & 3]), isa.splat(origin[axes[1] & 3]), isa.splat(origin[axes[2] & 3])],
            shear: [isa.splat(shear[0]), isa.splat(shear[1]), isa.splat(shear[2])],
            t_scale: isa.splat(t_scale),
            t_min: isa.splat(ray.t_min),
            reach: shear[2].abs().max(REACH),
        }
    }

    /// The same of a ray with no step beyond [`MODERATE`](super::lanes::MODERATE) and none whose reciprocal is: nothing overflows then, or vanishes.
    #[inline(always)]
    pub(crate) fn in_range(isa: I, quads: &RayQuads<I>, ray: &'a Ray) -> Self {
        let largest = isa.largest_of_three(quads.direction);
        let z = (isa.le(largest, isa.abs(quads.direction)) & 7).trailing_zeros() as usize & 3;
        let order = &ORDERS[z][isa.signs(quads.direction) as usize >> z & 1];
        // The largest step without its digits.
        let unit = isa.first(largest).to_bits() & 0x7f80_0000;
        let (origin, direction) = (isa.permute(quads.origin, order), isa.permute(quads.direction, order));
        // A quotient does not depend on powers of two in both of its parts.
        let shear = isa.div(isa.with_last(direction, f32::from_bits(unit)), isa.spread4::<2>(direction));
        Self {
            ray,
            axes: [order[0] as usize, order[1] as usize, order[2] as usize],
            origin: [isa.spread4::<0>(origin), isa.spread4::<1>(origin), isa.spread4::<2>(origin)],
            shear: [isa.spread4::<0>(shear), isa.spread4::<1>(shear), isa.spread4::<3>(shear)],
            t_scale: isa.splat(f32::from_bits((254 << 23) - unit)),
            t_min: isa.spread4::<3>(origin),
            reach: REACH,
        }
    }

    #[inline(always)]
    fn project(&self, isa: I, block: &TriangleBlock, corner: usize) -> [I::F4; 3] {
        let rows = block.rows();
        let x = isa.sub(isa.load(&rows[corner * 3 + (self.axes[0] & 3)]), self.origin[0]);
        let y = isa.sub(isa.load(&rows[corner * 3 + (self.axes[1] & 3)]), self.origin[1]);
        let z = isa.sub(isa.load(&rows[corner * 3 + (self.axes[2] & 3)]), self.origin[2]);
        let [shear_x, shear_y, shear_z] = self.shear;
        [isa.fused_less(shear_x, z, x), isa.fused_less(shear_y, z, y), isa.mul(shear_z, z)]
    }

    /// The hits between the bounds, inclusive. A `t` that overflowed is not excluded when `t_max` is infinite.
    #[inline(always)]
    pub(crate) fn hits(&self, isa: I, block: &TriangleBlock, farthest: f32) -> BlockHits {
        let a = self.project(isa, block, 0);
        let b = self.project(isa, block, 1);
        let c = self.project(isa, block, 2);
        let (u, v, w) = (edge(isa, c, b), edge(isa, a, c), edge(isa, b, a));
        let least = isa.min(isa.min(u, v), w);
        let most = isa.max(isa.max(u, v), w);
        if WATERTIGHT {
            let extents = isa.load(block.extents());
            let size = isa.fused(extents, isa.splat(self.reach), isa.abs(a[2]));
            let lateral = isa.fused(size, isa.splat(EDGE_BY_SIZE), isa.mul(extents, isa.splat(EDGE_BY_EXTENT)));
            let error = isa.fused(size, lateral, isa.splat(LEAST_EDGE_ERROR));
            let minus = isa.sub(isa.splat(0.0), error);
            // Corners that are no numbers, as those of unused lanes, are on no side.
            let possible = !(isa.le(least, minus) & isa.le(error, most)) & block.lanes_in_use();
            if possible == 0 {
                return BlockHits::NONE;
            }
            let sure = possible & (isa.le(error, least) | isa.le(most, minus));
            let determinant = isa.add(isa.add(u, v), w);
            let sum = isa.fused(w, c[2], isa.fused(v, b[2], isa.mul(u, a[2])));
            let t = isa.mul(isa.div(sum, determinant), self.t_scale);
            let t_max = isa.splat(farthest);
            let lateral = isa.mul(lateral, isa.splat(LATERAL));
            let error = distance_error(isa, [a, b, c], [lateral, size], determinant);
            let bound = isa.mul(isa.abs(sum), isa.splat(MOST_DISTANCE_ERROR));
            let close = sure & isa.le(error, bound) & isa.le(bound, isa.splat(f32::MAX));
            let mut ambiguous = possible & !close;
            if ambiguous & sure != 0 {
                let scale = isa.mul(isa.splat(UNIT_ROUNDOFF), self.t_scale);
                let error = isa.mul(isa.div(error, isa.abs(determinant)), scale);
                let (nearest, farthest) = (isa.sub(t, error), isa.add(t, error));
                // Where either is no number, it is not outside.
                let outside = isa.le(farthest, self.t_min) & !isa.le(self.t_min, farthest)
                    | isa.le(t_max, nearest) & !isa.le(nearest, t_max);
                ambiguous &= !(sure & outside);
            }
            let mask = close & isa.le(self.t_min, t) & isa.le(t, t_max);
            if mask | ambiguous == 0 {
                return BlockHits::NONE;
            }
            let mut hits = BlockHits::of(isa, mask, determinant, t, v, w);
            if ambiguous != 0 {
                hits.test_exactly(ambiguous, self.ray, block, farthest);
            }
            return hits;
        }
        let zero = isa.splat(0.0);
        let inside = isa.le(zero, least) | isa.le(most, zero);
        if inside == 0 {
            return BlockHits::NONE;
        }
        let determinant = isa.add(isa.add(u, v), w);
        let sum = isa.fused(w, c[2], isa.fused(v, b[2], isa.mul(u, a[2])));
        let t = isa.mul(isa.div(sum, determinant), self.t_scale);
        let mask = inside & isa.le(self.t_min, t) & isa.le(t, isa.splat(farthest));
        if mask == 0 {
            return BlockHits::NONE;
        }
        BlockHits::of(isa, mask, determinant, t, v, w)
    }
}

/// The axes of sheared space by the largest one of the direction, and by whether the direction runs down it; what comes last stays there.
const ORDERS: [[[u32; 4]; 2]; 4] = {
    let mut orders = [[[0; 4]; 2]; 4];
    let mut at = 0;
    while at < 8 {
        let (z, down) = (at / 2, at % 2);
        let [x, y] = OTHERS[z][down];
        orders[z][down] = [x as u32, y as u32, if z < 3 { z as u32 } else { 2 }, 3];
        at += 1;
    }
    orders
};

/// On which side of an edge the rays pass. Both products are rounded, never fused.
#[inline(always)]
fn edge<I: Isa>(isa: I, from: [I::F4; 3], to: [I::F4; 3]) -> I::F4 {
    isa.sub(isa.mul(from[0], to[1]), isa.mul(from[1], to[0]))
}

/// See [`crate::geometry::watertight`].
#[inline(always)]
fn distance_error<I: Isa>(
    isa: I,
    [a, b, c]: [[I::F4; 3]; 3],
    [lateral, size]: [I::F4; 2],
    determinant: I::F4,
) -> I::F4 {
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

/// Which lanes of a block are hit, and where.
pub(crate) struct BlockHits {
    pub(crate) mask: u32,
    back: u32,
    t: [f32; 4],
    u: [f32; 4],
    v: [f32; 4],
}

impl BlockHits {
    const NONE: Self = Self { mask: 0, back: 0, t: [0.0; 4], u: [0.0; 4], v: [0.0; 4] };

    #[inline(always)]
    fn of<I: Isa>(isa: I, mask: u32, determinant: I::F4, t: I::F4, v: I::F4, w: I::F4) -> Self {
        Self {
            mask,
            back: isa.signs(determinant),
            t: isa.store(t),
            u: isa.store(isa.div(v, determinant)),
            v: isa.store(isa.div(w, determinant)),
        }
    }

    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> TriangleHit {
        let lane = lane & 3;
        // Adding zero turns a negative zero into a positive one.
        TriangleHit { t: self.t[lane] + 0.0, u: self.u[lane], v: self.v[lane], back: self.back >> lane & 1 == 1 }
    }

    /// Decides without rounding errors what single precision cannot.
    #[cold]
    fn test_exactly(&mut self, lanes: u32, ray: &Ray, block: &TriangleBlock, t_max: f32) {
        for lane in (0..block.count as usize).filter(|lane| lanes >> lane & 1 == 1) {
            if let Some(hit) = exact::hit(ray, &block.triangle(lane), ray.t_min, t_max) {
                self.mask |= 1 << lane;
                (self.t[lane], self.u[lane], self.v[lane]) = (hit.t, hit.u, hit.v);
                self.back = self.back & !(1 << lane) | u32::from(hit.back) << lane;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::simd::{Kernel, Level};

    struct Same<'a>(&'a [Ray]);

    impl Kernel for Same<'_> {
        type Output = ();

        #[inline(always)]
        fn run<I: Isa>(self, isa: I) {
            for ray in self.0 {
                let quick = WatertightLanes::<I, true>::in_range(isa, &RayQuads::new(isa, ray), ray);
                let slow = WatertightLanes::<I, true>::new(isa, ray);
                let bits = |lanes: &WatertightLanes<'_, I, true>| {
                    let [a, b, c] = lanes.origin;
                    let [d, e, f] = lanes.shear;
                    [a, b, c, d, e, f, lanes.t_scale, lanes.t_min].map(|x| isa.store(x).map(f32::to_bits))
                };
                assert_eq!((quick.axes, bits(&quick)), (slow.axes, bits(&slow)), "{ray:?}");
            }
        }
    }

    #[test]
    fn a_ray_in_single_precision_range_is_sheared_in_registers_as_it_is_elsewhere() {
        let mut rays = Vec::new();
        for size in [2.0_f32.powi(-60), 1e-12, 0.3, 1.0, 7.0, 1e12, 2.0_f32.powi(60) / 3.0] {
            let steps = [-size, -size * 0.75, size * 0.5, size * 0.7501, size];
            for x in steps {
                for y in steps {
                    for z in steps {
                        let origin = Vec3::new(0.1, -200.0, 3e7) * x;
                        rays.push(Ray::new(origin.to_array(), [x, y, z]).with_range(0.25, 9.0));
                    }
                }
            }
        }
        for level in Level::available() {
            level.run(Same(&rays));
        }
    }
}
