//! Four lanes to a register: what every 64-bit ARM processor has.
//!
//! Eight lanes are two registers and sixteen are four, so their arithmetic is that of four lanes,
//! register by register.

use std::arch::aarch64::*;

use super::{Isa, Kernel, Lanes, Row};

/// Exists only where the processor has NEON.
#[derive(Clone, Copy)]
pub(crate) struct Neon(());

impl Neon {
    pub(crate) fn detect() -> Option<Self> {
        std::arch::is_aarch64_feature_detected!("neon").then_some(Self(()))
    }

    #[inline]
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[target_feature(enable = "neon")]
        fn with<K: Kernel>(isa: Neon, kernel: K) -> K::Output {
            kernel.run(isa)
        }
        // SAFETY: `self` proves that the processor has NEON.
        unsafe { with(self, kernel) }
    }

    /// The larger one by bits as signed integers.
    #[inline(always)]
    fn max_bits4(self, a: float32x4_t, b: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vreinterpretq_f32_s32(vmaxq_s32(vreinterpretq_s32_f32(a), vreinterpretq_s32_f32(b))) }
    }

    /// The smaller one by bits as signed integers.
    #[inline(always)]
    fn min_bits4(self, a: float32x4_t, b: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vreinterpretq_f32_s32(vminq_s32(vreinterpretq_s32_f32(a), vreinterpretq_s32_f32(b))) }
    }

    /// All bits of the lanes where `a < b` by bits as signed integers.
    #[inline(always)]
    fn lanes_lt_bits4(self, a: float32x4_t, b: float32x4_t) -> uint32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vcltq_s32(vreinterpretq_s32_f32(a), vreinterpretq_s32_f32(b)) }
    }

    /// All bits of the lanes where `a <= b`.
    #[inline(always)]
    fn lanes_le4(self, a: float32x4_t, b: float32x4_t) -> uint32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vcleq_f32(a, b) }
    }

    /// All bits of the lanes where `a == b`.
    #[inline(always)]
    fn lanes_eq4(self, a: float32x4_t, b: float32x4_t) -> uint32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vceqq_f32(a, b) }
    }

    /// A bit per lane, of lanes whose bits are all set or all clear.
    #[inline(always)]
    fn mask4(self, lanes: uint32x4_t) -> u32 {
        // SAFETY: `self` proves NEON; four integers are read from an array of four.
        unsafe { vaddvq_u32(vandq_u32(lanes, vld1q_u32([1, 2, 4, 8].as_ptr()))) }
    }

    /// As `mask4`, of eight lanes: halves of lanes are side by side in one register.
    #[inline(always)]
    fn mask8(self, [low, high]: [uint32x4_t; 2]) -> u32 {
        // SAFETY: `self` proves NEON; eight integers are read from an array of eight.
        unsafe {
            let lanes = vuzp1q_u16(vreinterpretq_u16_u32(low), vreinterpretq_u16_u32(high));
            vaddvq_u16(vandq_u16(lanes, vld1q_u16([1, 2, 4, 8, 16, 32, 64, 128].as_ptr()))).into()
        }
    }

    /// As `mask4`, of sixteen lanes.
    #[inline(always)]
    fn mask16(self, lanes: [uint32x4_t; 4]) -> u32 {
        // SAFETY: `self` proves NEON; eight integers are read from each array of eight.
        unsafe {
            let low = vuzp1q_u16(vreinterpretq_u16_u32(lanes[0]), vreinterpretq_u16_u32(lanes[1]));
            let high = vuzp1q_u16(vreinterpretq_u16_u32(lanes[2]), vreinterpretq_u16_u32(lanes[3]));
            let low = vandq_u16(low, vld1q_u16([1, 2, 4, 8, 16, 32, 64, 128].as_ptr()));
            let high = vandq_u16(high, vld1q_u16([256, 512, 1024, 2048, 4096, 8192, 16384, 32768].as_ptr()));
            vaddvq_u16(vorrq_u16(low, high)).into()
        }
    }
}

/// One register.
impl Lanes<Neon> for float32x4_t {
    type Array = [f32; 4];

    #[inline(always)]
    fn splat(_: Neon, x: f32) -> Self {
        // SAFETY: the level proves NEON.
        unsafe { vdupq_n_f32(x) }
    }

    #[inline(always)]
    fn load(_: Neon, x: &[f32; 4]) -> Self {
        // SAFETY: the level proves NEON; four floats are read from an array of four.
        unsafe { vld1q_f32(x.as_ptr()) }
    }

    #[inline(always)]
    fn store(self, _: Neon) -> [f32; 4] {
        let mut out = [0.0; 4];
        // SAFETY: the level proves NEON; four floats are written to an array of four.
        unsafe { vst1q_f32(out.as_mut_ptr(), self) };
        out
    }

    #[inline(always)]
    fn add(self, _: Neon, b: Self) -> Self {
        // SAFETY: the level proves NEON.
        unsafe { vaddq_f32(self, b) }
    }

    #[inline(always)]
    fn sub(self, _: Neon, b: Self) -> Self {
        // SAFETY: the level proves NEON.
        unsafe { vsubq_f32(self, b) }
    }

    #[inline(always)]
    fn mul(self, _: Neon, b: Self) -> Self {
        // SAFETY: the level proves NEON.
        unsafe { vmulq_f32(self, b) }
    }

    #[inline(always)]
    fn div(self, _: Neon, b: Self) -> Self {
        // SAFETY: the level proves NEON.
        unsafe { vdivq_f32(self, b) }
    }

    /// Rounded once. The compiler hoists the negation of `c` out of loops in which `c` is constant.
    #[inline(always)]
    fn mul_sub(self, _: Neon, b: Self, c: Self) -> Self {
        // SAFETY: the level proves NEON.
        unsafe { vfmaq_f32(vnegq_f32(c), self, b) }
    }

    #[inline(always)]
    fn mul_add(self, isa: Neon, b: Self, c: Self) -> Self {
        self.fused(isa, b, c)
    }

    #[inline(always)]
    fn fused(self, _: Neon, b: Self, c: Self) -> Self {
        // SAFETY: the level proves NEON.
        unsafe { vfmaq_f32(c, self, b) }
    }

    #[inline(always)]
    fn fused_less(self, _: Neon, b: Self, c: Self) -> Self {
        // SAFETY: the level proves NEON.
        unsafe { vfmsq_f32(c, self, b) }
    }

    /// By comparison: the instruction for it, `fmax`, returns NaN where `b` is to be returned.
    #[inline(always)]
    fn max(self, _: Neon, b: Self) -> Self {
        // SAFETY: the level proves NEON.
        unsafe { vbslq_f32(vcgtq_f32(self, b), self, b) }
    }

    /// By comparison, as `max`.
    #[inline(always)]
    fn min(self, _: Neon, b: Self) -> Self {
        // SAFETY: the level proves NEON.
        unsafe { vbslq_f32(vcltq_f32(self, b), self, b) }
    }

    #[inline(always)]
    fn abs(self, _: Neon) -> Self {
        // SAFETY: the level proves NEON.
        unsafe { vabsq_f32(self) }
    }

    #[inline(always)]
    fn le(self, isa: Neon, b: Self) -> u32 {
        isa.mask4(isa.lanes_le4(self, b))
    }
}

/// The arithmetic of several registers, register by register; `$mask` makes the mask of all lanes.
macro_rules! by_register {
    ($count:literal, $array:ty, $mask:ident, |$load:ident| $loaded:expr, |$store:ident, $out:ident| $stored:expr) => {
        impl Lanes<Neon> for [float32x4_t; $count] {
            type Array = $array;

            #[inline(always)]
            fn splat(isa: Neon, x: f32) -> Self {
                [isa.splat(x); $count]
            }

            #[inline(always)]
            fn load(_: Neon, x: &$array) -> Self {
                let $load = (&raw const *x).cast::<f32>();
                // SAFETY: the level proves NEON; as many floats are read as the array has.
                unsafe { $loaded }
            }

            #[inline(always)]
            fn store(self, _: Neon) -> $array {
                let mut out: $array = bytemuck::Zeroable::zeroed();
                let ($store, $out) = (self, (&raw mut out).cast::<f32>());
                // SAFETY: the level proves NEON; as many floats are written as the array has.
                unsafe { $stored };
                out
            }

            by_register! { @ $count, add(b) sub(b) mul(b) div(b) max(b) min(b) abs() }
            by_register! { @ $count, mul_sub(b, c) mul_add(b, c) fused(b, c) fused_less(b, c) }

            #[inline(always)]
            fn le(self, isa: Neon, b: Self) -> u32 {
                let mut lanes = [isa.lanes_le4(self[0], b[0]); $count];
                for at in 1..$count {
                    lanes[at] = isa.lanes_le4(self[at], b[at]);
                }
                isa.$mask(lanes)
            }
        }
    };
    (@ $count:literal, $($operation:ident($($b:ident),*))+) => {$(
        #[inline(always)]
        fn $operation(self, isa: Neon, $($b: Self),*) -> Self {
            let mut out = self;
            for at in 0..$count {
                out[at] = self[at].$operation(isa, $($b[at]),*);
            }
            out
        }
    )+};
}

by_register! {
    2, [f32; 8], mask8, |x| [vld1q_f32(x), vld1q_f32(x.add(4))],
    |x, out| { vst1q_f32(out, x[0]); vst1q_f32(out.add(4), x[1]); }
}

by_register! {
    4, Row, mask16, |x| [vld1q_f32(x), vld1q_f32(x.add(4)), vld1q_f32(x.add(8)), vld1q_f32(x.add(12))],
    |x, out| {
        vst1q_f32(out, x[0]);
        vst1q_f32(out.add(4), x[1]);
        vst1q_f32(out.add(8), x[2]);
        vst1q_f32(out.add(12), x[3]);
    }
}

impl Isa for Neon {
    type F8 = [float32x4_t; 2];
    type F4 = float32x4_t;
    type F16 = [float32x4_t; 4];

    #[inline(always)]
    fn xor_sign(self, x: Self::F8, signs: &[u32; 8]) -> Self::F8 {
        let flip = |x: float32x4_t, signs: &[u32]| {
            // SAFETY: `self` proves NEON; four words are read from a half of eight.
            unsafe { vreinterpretq_f32_u32(veorq_u32(vreinterpretq_u32_f32(x), vld1q_u32(signs.as_ptr()))) }
        };
        let (low, high) = signs.split_at(4);
        [flip(x[0], low), flip(x[1], high)]
    }

    #[inline(always)]
    fn largest_of_three(self, x: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON. Magnitudes order as their bits do, NaN above infinity.
        unsafe {
            let size = vreinterpretq_u32_f32(vabsq_f32(x));
            vreinterpretq_f32_u32(vdupq_n_u32(vmaxvq_u32(vsetq_lane_u32::<3>(0, size))))
        }
    }

    #[inline(always)]
    fn first(self, x: float32x4_t) -> f32 {
        // SAFETY: `self` proves NEON.
        unsafe { vgetq_lane_f32::<0>(x) }
    }

    #[inline(always)]
    fn permute(self, x: float32x4_t, order: &[u32; 4]) -> float32x4_t {
        let x = self.store(x);
        self.load(&[
            x[order[0] as usize & 3],
            x[order[1] as usize & 3],
            x[order[2] as usize & 3],
            x[order[3] as usize & 3],
        ])
    }

    #[inline(always)]
    fn spread4<const LANE: i32>(self, x: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vdupq_laneq_f32::<LANE>(x) }
    }

    #[inline(always)]
    fn signs(self, x: float32x4_t) -> u32 {
        // SAFETY: `self` proves NEON.
        self.mask4(unsafe { vcltzq_s32(vreinterpretq_s32_f32(x)) })
    }

    #[inline(always)]
    fn with_last(self, x: float32x4_t, last: f32) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vsetq_lane_f32::<3>(last, x) }
    }

    #[inline(always)]
    fn load3(self, x: &[f32; 3]) -> float32x4_t {
        self.load(&[x[0], x[1], x[2], 0.0])
    }

    #[inline(always)]
    fn blend_prefix(self, count: u32, a: float32x4_t, rest: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON; four integers are read from an array of four.
        unsafe { vbslq_f32(vcltq_u32(vld1q_u32([0, 1, 2, 3].as_ptr()), vdupq_n_u32(count)), a, rest) }
    }

    #[inline(always)]
    fn transpose(self, rows: [float32x4_t; 4]) -> [float32x4_t; 4] {
        let rows = [self.store(rows[0]), self.store(rows[1]), self.store(rows[2]), self.store(rows[3])];
        let mut columns = [self.splat(0.0); 4];
        for at in 0..4 {
            columns[at] = self.load(&[rows[0][at], rows[1][at], rows[2][at], rows[3][at]]);
        }
        columns
    }

    #[inline(always)]
    fn extract_bits<const SHIFT: i32, const MASK: u32>(self, words: &[u32; 8]) -> Self::F8 {
        let mut out = [0.0; 8];
        for lane in 0..8 {
            out[lane] = (words[lane] >> SHIFT & MASK) as f32;
        }
        self.load(&out)
    }

    #[inline(always)]
    fn transpose_xyz(self, points: &[float32x4_t; 8]) -> [Self::F8; 3] {
        let low = self.transpose([points[0], points[1], points[2], points[3]]);
        let high = self.transpose([points[4], points[5], points[6], points[7]]);
        [[low[0], high[0]], [low[1], high[1]], [low[2], high[2]]]
    }

    #[inline(always)]
    fn zip_u64(self, upper: Self::F8, lower: &[u32; 8]) -> [u64; 8] {
        let mut out = [0; 8];
        // SAFETY: `self` proves NEON; four words are read from each half of an array of eight, and
        // two numbers are written to each quarter of another.
        unsafe {
            for half in 0..2 {
                let (lower, upper) = (vld1q_u32(lower.as_ptr().add(4 * half)), vreinterpretq_u32_f32(upper[half]));
                vst1q_u64(out.as_mut_ptr().add(4 * half), vreinterpretq_u64_u32(vzip1q_u32(lower, upper)));
                vst1q_u64(out.as_mut_ptr().add(4 * half + 2), vreinterpretq_u64_u32(vzip2q_u32(lower, upper)));
            }
        }
        out
    }

    #[inline(always)]
    fn lt_bits(self, a: Self::F8, b: Self::F8) -> u32 {
        self.mask8([self.lanes_lt_bits4(a[0], b[0]), self.lanes_lt_bits4(a[1], b[1])])
    }

    #[inline(always)]
    fn max_bits(self, a: Self::F8, b: Self::F8) -> Self::F8 {
        [self.max_bits4(a[0], b[0]), self.max_bits4(a[1], b[1])]
    }

    #[inline(always)]
    fn min_bits(self, a: Self::F8, b: Self::F8) -> Self::F8 {
        [self.min_bits4(a[0], b[0]), self.min_bits4(a[1], b[1])]
    }

    #[inline(always)]
    fn spread8<const LANE: i32>(self, x: float32x4_t) -> Self::F8 {
        // SAFETY: `self` proves NEON.
        unsafe { [vdupq_laneq_f32::<LANE>(x); 2] }
    }

    #[inline(always)]
    fn eq(self, a: Self::F16, b: Self::F16) -> u32 {
        self.mask16([
            self.lanes_eq4(a[0], b[0]),
            self.lanes_eq4(a[1], b[1]),
            self.lanes_eq4(a[2], b[2]),
            self.lanes_eq4(a[3], b[3]),
        ])
    }

    #[inline(always)]
    fn store_masked(self, to: &mut Row, mask: u32, x: Self::F16) {
        let old = self.load::<Self::F16>(to);
        let mut new = x;
        for register in 0..4 {
            // SAFETY: `self` proves NEON; four integers are read from an array of four.
            new[register] = unsafe {
                let bits = vdupq_n_u32(mask >> (4 * register));
                let written = vtstq_u32(bits, vld1q_u32([1, 2, 4, 8].as_ptr()));
                vbslq_f32(written, x[register], old[register])
            };
        }
        *to = self.store(new);
    }
}
