//! Four triangles against one ray: the test of [`watertight`](crate::geometry::watertight) with a
//! triangle in each lane.

use super::RayQuads;
use crate::geometry::{Edges, LaneHits, OTHERS, REACH, Ray, TriangleHit, WatertightRay, exact};
use crate::simd::Isa;
use crate::wide::TriangleBlock;

/// A [`WatertightRay`] in registers, for tests that are watertight or in single precision
/// throughout.
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

    /// Of the parts of a [`WatertightRay`].
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

    /// As [`WatertightLanes::new`], for a ray whose direction and reciprocals are within
    /// [`SINGLE_PRECISION_RANGE`](super::lanes::SINGLE_PRECISION_RANGE), so that nothing overflows
    /// or vanishes.
    #[inline(always)]
    pub(crate) fn in_range(isa: I, quads: &RayQuads<I>, ray: &'a Ray) -> Self {
        let largest = isa.largest_of_three(quads.direction);
        let z = (isa.le(largest, isa.abs(quads.direction)) & 7).trailing_zeros() as usize & 3;
        let order = &ORDERS[z][isa.signs(quads.direction) as usize >> z & 1];
        // The power of two in the largest component.
        let unit = isa.first(largest).to_bits() & 0x7f80_0000;
        let (origin, direction) = (isa.permute(quads.origin, order), isa.permute(quads.direction, order));
        // Powers of two in numerator and denominator cancel without rounding.
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

    /// A corner of each triangle, its coordinates in the order of the axes of sheared space.
    #[inline(always)]
    fn corner(&self, isa: I, block: &TriangleBlock, corner: usize) -> [I::F4; 3] {
        let rows = block.rows();
        [
            isa.load(&rows[corner * 3 + (self.axes[0] & 3)]),
            isa.load(&rows[corner * 3 + (self.axes[1] & 3)]),
            isa.load(&rows[corner * 3 + (self.axes[2] & 3)]),
        ]
    }

    /// The hits between the bounds, inclusive.
    #[inline(always)]
    pub(crate) fn hits(&self, isa: I, block: &TriangleBlock, farthest: f32) -> BlockHits {
        let corners = [self.corner(isa, block, 0), self.corner(isa, block, 1), self.corner(isa, block, 2)];
        let sizes = [isa.load(block.extents()), isa.splat(self.reach)];
        // Corners of unused lanes are NaN: inside no edge, but perhaps in doubt.
        let lanes = if WATERTIGHT { block.lanes_in_use() } else { ALL_LANES };
        let edges = Edges::<_, WATERTIGHT>::new(isa, corners, (self.origin, self.shear), sizes, lanes);
        if !edges.is_possible() {
            return BlockHits::NONE;
        }
        let bounds = (self.t_min, isa.splat(if farthest < f32::MAX { farthest } else { f32::MAX }));
        let hits = edges.intersect(isa, self.t_scale, bounds);
        if hits.hits | hits.ambiguous == 0 {
            return BlockHits::NONE;
        }
        let mut all = BlockHits::of(isa, &hits);
        if hits.ambiguous != 0 {
            all.test_exactly(hits.ambiguous, self.ray, block, farthest);
        }
        all
    }
}

/// All four lanes.
const ALL_LANES: u32 = 0b1111;

/// The axes of sheared space by the largest one of the direction, and by whether the direction runs
/// down it; the last lane stays in its place.
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
    fn of<I: Isa>(isa: I, hits: &LaneHits<I::F4>) -> Self {
        let [u, v] = hits.weights(isa);
        Self { mask: hits.hits, back: hits.back(isa), t: isa.store(hits.t(isa)), u: isa.store(u), v: isa.store(v) }
    }

    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> TriangleHit {
        let lane = lane & 3;
        TriangleHit { t: self.t[lane], u: self.u[lane], v: self.v[lane], back: self.back >> lane & 1 == 1 }
    }

    /// Decides in exact arithmetic what single precision cannot.
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
