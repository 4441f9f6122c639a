//! Four triangles against one ray: the watertight test, operation for operation as in [`Sheared::hit`], so that hits agree to the bit.

use crate::geometry::{Sheared, TriangleHit};
use crate::simd::Isa;
use crate::wide::TriangleBlock;

/// A sheared ray in registers.
#[derive(Clone, Copy)]
pub(crate) struct ShearedLanes<'a, I: Isa> {
    ray: &'a Sheared,
    origin: [I::F4; 3],
    shear: [I::F4; 3],
    t_scale: I::F4,
    t_min: I::F4,
}

impl<'a, I: Isa> ShearedLanes<'a, I> {
    #[inline(always)]
    pub(crate) fn new(isa: I, ray: &'a Sheared, t_min: f32) -> Self {
        Self {
            ray,
            origin: [0, 1, 2].map(|axis| isa.splat4(ray.origin[ray.axes[axis]])),
            shear: ray.shear.map(|x| isa.splat4(x)),
            t_scale: isa.splat4(ray.t_scale),
            t_min: isa.splat4(t_min),
        }
    }

    #[inline(always)]
    fn project(&self, isa: I, corner: &[[f32; 4]; 3]) -> [I::F4; 3] {
        let [x, y, z] = [0, 1, 2].map(|axis| isa.sub4(isa.load4(&corner[self.ray.axes[axis] % 3]), self.origin[axis]));
        [isa.sub4(x, isa.mul4(self.shear[0], z)), isa.sub4(y, isa.mul4(self.shear[1], z)), isa.mul4(self.shear[2], z)]
    }

    /// The hits between the bounds, inclusive. A `t` that overflowed is not excluded when `t_max` is infinite.
    #[inline(always)]
    pub(crate) fn hits(&self, isa: I, block: &TriangleBlock, t_min: f32, t_max: f32) -> BlockHits {
        let [a, b, c] = [0, 1, 2].map(|corner| self.project(isa, &block.corners[corner]));
        let edge = |p: [I::F4; 3], q: [I::F4; 3]| isa.sub4(isa.mul4(p[0], q[1]), isa.mul4(p[1], q[0]));
        let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
        let zero = isa.splat4(0.0);
        let front = isa.le4(zero, u) & isa.le4(zero, v) & isa.le4(zero, w);
        let back = isa.le4(u, zero) & isa.le4(v, zero) & isa.le4(w, zero);
        let inside = front | back;
        if inside == 0 {
            return BlockHits::NONE;
        }
        let on_edge = (isa.eq4(u, zero) | isa.eq4(v, zero) | isa.eq4(w, zero)) & inside;
        let determinant = isa.add4(isa.add4(u, v), w);
        let sum = isa.add4(isa.add4(isa.mul4(u, a[2]), isa.mul4(v, b[2])), isa.mul4(w, c[2]));
        let t = isa.mul4(isa.div4(sum, determinant), self.t_scale);
        let mask = inside & isa.le4(self.t_min, t) & isa.le4(t, isa.splat4(t_max)) & !on_edge;
        if mask | on_edge == 0 {
            return BlockHits::NONE;
        }
        let mut hits = BlockHits {
            mask,
            back,
            t: isa.store4(t),
            u: isa.store4(isa.div4(v, determinant)),
            v: isa.store4(isa.div4(w, determinant)),
        };
        if on_edge != 0 {
            hits.look_again(on_edge, self.ray, block, t_min, t_max);
        }
        hits
    }
}

/// Which lanes of a block are hit, and where.
pub(crate) struct BlockHits {
    pub(crate) mask: u8,
    back: u8,
    t: [f32; 4],
    u: [f32; 4],
    v: [f32; 4],
}

impl BlockHits {
    const NONE: Self = Self { mask: 0, back: 0, t: [0.0; 4], u: [0.0; 4], v: [0.0; 4] };

    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> TriangleHit {
        let lane = lane & 3;
        // Adding zero turns a negative zero into a positive one.
        TriangleHit { t: self.t[lane] + 0.0, u: self.u[lane], v: self.v[lane], back: self.back >> lane & 1 == 1 }
    }

    /// Rays through an edge, or so far beside a triangle that an edge function vanishes, get the second try of the scalar twin.
    #[cold]
    fn look_again(&mut self, lanes: u8, ray: &Sheared, block: &TriangleBlock, t_min: f32, t_max: f32) {
        for lane in (0..block.count as usize).filter(|lane| lanes >> lane & 1 == 1) {
            if let Some(hit) = ray.hit(&block.triangle(lane), t_min, t_max) {
                self.mask |= 1 << lane;
                (self.t[lane], self.u[lane], self.v[lane]) = (hit.t, hit.u, hit.v);
                self.back = self.back & !(1 << lane) | u8::from(hit.back) << lane;
            }
        }
    }
}
