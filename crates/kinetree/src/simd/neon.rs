//! Four lanes to a register: what every 64-bit ARM processor has.
//!
//! Eight lanes are two registers and sixteen are four, so the wide words are the four-lane ones, said for each register.

use std::arch::aarch64::*;

use super::{Isa, Kernel, Row};

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

    /// Bits as signed whole numbers.
    #[inline(always)]
    fn max_bits4(self, a: float32x4_t, b: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vreinterpretq_f32_s32(vmaxq_s32(vreinterpretq_s32_f32(a), vreinterpretq_s32_f32(b))) }
    }

    #[inline(always)]
    fn min_bits4(self, a: float32x4_t, b: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vreinterpretq_f32_s32(vminq_s32(vreinterpretq_s32_f32(a), vreinterpretq_s32_f32(b))) }
    }

    #[inline(always)]
    fn lanes_before4(self, a: float32x4_t, b: float32x4_t) -> uint32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vcltq_s32(vreinterpretq_s32_f32(a), vreinterpretq_s32_f32(b)) }
    }

    #[inline(always)]
    fn lanes_le4(self, a: float32x4_t, b: float32x4_t) -> uint32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vcleq_f32(a, b) }
    }

    #[inline(always)]
    fn lanes_eq4(self, a: float32x4_t, b: float32x4_t) -> uint32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vceqq_f32(a, b) }
    }

    /// A bit for each lane. All bits of a lane are the same.
    #[inline(always)]
    fn mask4(self, lanes: uint32x4_t) -> u8 {
        // SAFETY: `self` proves NEON; four integers are read from an array of four.
        unsafe { vaddvq_u32(vandq_u32(lanes, vld1q_u32([1, 2, 4, 8].as_ptr()))) as u8 }
    }

    #[inline(always)]
    fn mask8(self, low: uint32x4_t, high: uint32x4_t) -> u8 {
        // SAFETY: `self` proves NEON; eight integers are read from an array of eight.
        unsafe {
            let lanes = vuzp1q_u16(vreinterpretq_u16_u32(low), vreinterpretq_u16_u32(high));
            vaddvq_u16(vandq_u16(lanes, vld1q_u16([1, 2, 4, 8, 16, 32, 64, 128].as_ptr()))) as u8
        }
    }

    #[inline(always)]
    fn mask16(self, lanes: [uint32x4_t; 4]) -> u16 {
        // SAFETY: `self` proves NEON; eight integers are read from each array of eight.
        unsafe {
            let low = vuzp1q_u16(vreinterpretq_u16_u32(lanes[0]), vreinterpretq_u16_u32(lanes[1]));
            let high = vuzp1q_u16(vreinterpretq_u16_u32(lanes[2]), vreinterpretq_u16_u32(lanes[3]));
            let low = vandq_u16(low, vld1q_u16([1, 2, 4, 8, 16, 32, 64, 128].as_ptr()));
            let high = vandq_u16(high, vld1q_u16([256, 512, 1024, 2048, 4096, 8192, 16384, 32768].as_ptr()));
            vaddvq_u16(vorrq_u16(low, high))
        }
    }
}

/// Words of four lanes that are one instruction.
macro_rules! fours {
    ($($word:ident = $instruction:ident($($x:ident),+);)+) => {$(
        #[inline(always)]
        fn $word(self, $($x: float32x4_t),+) -> float32x4_t {
            // SAFETY: `self` proves NEON.
            unsafe { $instruction($($x),+) }
        }
    )+};
}

/// Words of eight lanes, said for each register of four.
macro_rules! eights {
    ($($word:ident = $four:ident($($x:ident),+);)+) => {$(
        #[inline(always)]
        fn $word(self, $($x: Self::F8),+) -> Self::F8 {
            [self.$four($($x[0]),+), self.$four($($x[1]),+)]
        }
    )+};
}

/// Words of sixteen lanes, said for each register of four.
macro_rules! sixteens {
    ($($word:ident = $four:ident($($x:ident),+);)+) => {$(
        #[inline(always)]
        fn $word(self, $($x: Self::F16),+) -> Self::F16 {
            [self.$four($($x[0]),+), self.$four($($x[1]),+), self.$four($($x[2]),+), self.$four($($x[3]),+)]
        }
    )+};
}

impl Isa for Neon {
    type F8 = [float32x4_t; 2];
    type F4 = float32x4_t;
    type F16 = [float32x4_t; 4];

    fours! {
        add4 = vaddq_f32(a, b);
        sub4 = vsubq_f32(a, b);
        mul4 = vmulq_f32(a, b);
        div4 = vdivq_f32(a, b);
        abs4 = vabsq_f32(x);
    }

    eights! {
        add8 = add4(a, b);
        sub8 = sub4(a, b);
        mul8 = mul4(a, b);
        mul_sub8 = mul_sub4(a, b, c);
        mul_add8 = fused4(a, b, c);
        max8 = max4(a, b);
        min8 = min4(a, b);
        max_bits8 = max_bits4(a, b);
        min_bits8 = min_bits4(a, b);
    }

    sixteens! {
        add16 = add4(a, b);
        sub16 = sub4(a, b);
        mul16 = mul4(a, b);
        div16 = div4(a, b);
        abs16 = abs4(x);
        mul_sub16 = mul_sub4(a, b, c);
        fused16 = fused4(a, b, c);
        fused_less16 = fused_less4(a, b, c);
        max16 = max4(a, b);
        min16 = min4(a, b);
    }

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
    fn splat4(self, x: f32) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vdupq_n_f32(x) }
    }

    #[inline(always)]
    fn load4(self, x: &[f32; 4]) -> float32x4_t {
        // SAFETY: `self` proves NEON; four floats are read from an array of four.
        unsafe { vld1q_f32(x.as_ptr()) }
    }

    #[inline(always)]
    fn store4(self, x: float32x4_t) -> [f32; 4] {
        let mut out = [0.0; 4];
        // SAFETY: `self` proves NEON; four floats are written to an array of four.
        unsafe { vst1q_f32(out.as_mut_ptr(), x) };
        out
    }

    /// Rounded once. Negating `c` is taken out of loops in which it stays the same.
    #[inline(always)]
    fn mul_sub4(self, a: float32x4_t, b: float32x4_t, c: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vfmaq_f32(vnegq_f32(c), a, b) }
    }

    #[inline(always)]
    fn fused4(self, a: float32x4_t, b: float32x4_t, c: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vfmaq_f32(c, a, b) }
    }

    #[inline(always)]
    fn fused_less4(self, a: float32x4_t, b: float32x4_t, c: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vfmsq_f32(c, a, b) }
    }

    /// The instruction for it would give what is not a number, where the second operand is asked for.
    #[inline(always)]
    fn max4(self, a: float32x4_t, b: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vbslq_f32(vcgtq_f32(a, b), a, b) }
    }

    #[inline(always)]
    fn min4(self, a: float32x4_t, b: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vbslq_f32(vcltq_f32(a, b), a, b) }
    }

    #[inline(always)]
    fn largest_of_three(self, x: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON. Sizes order like their bits.
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
    fn permute4(self, x: float32x4_t, order: &[u32; 4]) -> float32x4_t {
        let x = self.store4(x);
        self.load4(&[
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
    fn signs4(self, x: float32x4_t) -> u8 {
        // SAFETY: `self` proves NEON.
        self.mask4(unsafe { vcltzq_s32(vreinterpretq_s32_f32(x)) })
    }

    #[inline(always)]
    fn with_last4(self, x: float32x4_t, last: f32) -> float32x4_t {
        // SAFETY: `self` proves NEON.
        unsafe { vsetq_lane_f32::<3>(last, x) }
    }

    #[inline(always)]
    fn load3(self, x: &[f32; 3]) -> float32x4_t {
        self.load4(&[x[0], x[1], x[2], 0.0])
    }

    #[inline(always)]
    fn blend_prefix(self, count: u32, a: float32x4_t, rest: float32x4_t) -> float32x4_t {
        // SAFETY: `self` proves NEON; four integers are read from an array of four.
        unsafe { vbslq_f32(vcltq_u32(vld1q_u32([0, 1, 2, 3].as_ptr()), vdupq_n_u32(count)), a, rest) }
    }

    #[inline(always)]
    fn transpose4(self, rows: [float32x4_t; 4]) -> [float32x4_t; 4] {
        let rows = [self.store4(rows[0]), self.store4(rows[1]), self.store4(rows[2]), self.store4(rows[3])];
        let mut columns = [self.splat4(0.0); 4];
        for at in 0..4 {
            columns[at] = self.load4(&[rows[0][at], rows[1][at], rows[2][at], rows[3][at]]);
        }
        columns
    }

    #[inline(always)]
    fn extract_bits<const SHIFT: i32, const MASK: u32>(self, words: &[u32; 8]) -> Self::F8 {
        let mut out = [0.0; 8];
        for lane in 0..8 {
            out[lane] = (words[lane] >> SHIFT & MASK) as f32;
        }
        self.load8(&out)
    }

    #[inline(always)]
    fn transpose_xyz(self, points: &[float32x4_t; 8]) -> [Self::F8; 3] {
        let low = self.transpose4([points[0], points[1], points[2], points[3]]);
        let high = self.transpose4([points[4], points[5], points[6], points[7]]);
        [[low[0], high[0]], [low[1], high[1]], [low[2], high[2]]]
    }

    #[inline(always)]
    fn zip_u64(self, upper: Self::F8, lower: &[u32; 8]) -> [u64; 8] {
        let mut out = [0; 8];
        // SAFETY: `self` proves NEON; four words are read from each half of an array of eight, and twice two numbers are written to each half of one of eight.
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
        self.mask8(self.lanes_before4(a[0], b[0]), self.lanes_before4(a[1], b[1])).into()
    }

    #[inline(always)]
    fn spread8<const LANE: i32>(self, x: float32x4_t) -> Self::F8 {
        // SAFETY: `self` proves NEON.
        unsafe { [vdupq_laneq_f32::<LANE>(x); 2] }
    }

    #[inline(always)]
    fn le4(self, a: float32x4_t, b: float32x4_t) -> u8 {
        self.mask4(self.lanes_le4(a, b))
    }

    #[inline(always)]
    fn splat8(self, x: f32) -> Self::F8 {
        [self.splat4(x); 2]
    }

    #[inline(always)]
    fn load8(self, x: &[f32; 8]) -> Self::F8 {
        // SAFETY: `self` proves NEON; eight floats are read from an array of eight.
        unsafe { [vld1q_f32(x.as_ptr()), vld1q_f32(x.as_ptr().add(4))] }
    }

    #[inline(always)]
    fn store8(self, x: Self::F8) -> [f32; 8] {
        let mut out = [0.0; 8];
        // SAFETY: `self` proves NEON; eight floats are written to an array of eight.
        unsafe {
            vst1q_f32(out.as_mut_ptr(), x[0]);
            vst1q_f32(out.as_mut_ptr().add(4), x[1]);
        }
        out
    }

    #[inline(always)]
    fn le8(self, a: Self::F8, b: Self::F8) -> u8 {
        self.mask8(self.lanes_le4(a[0], b[0]), self.lanes_le4(a[1], b[1]))
    }

    #[inline(always)]
    fn splat16(self, x: f32) -> Self::F16 {
        [self.splat4(x); 4]
    }

    #[inline(always)]
    fn load16(self, x: &Row) -> Self::F16 {
        let x = x.0.as_ptr();
        // SAFETY: `self` proves NEON; sixteen floats are read from a row of sixteen.
        unsafe { [vld1q_f32(x), vld1q_f32(x.add(4)), vld1q_f32(x.add(8)), vld1q_f32(x.add(12))] }
    }

    #[inline(always)]
    fn store16(self, x: Self::F16) -> Row {
        let mut out = Row([0.0; 16]);
        let place = out.0.as_mut_ptr();
        // SAFETY: `self` proves NEON; sixteen floats are written to a row of sixteen.
        unsafe {
            vst1q_f32(place, x[0]);
            vst1q_f32(place.add(4), x[1]);
            vst1q_f32(place.add(8), x[2]);
            vst1q_f32(place.add(12), x[3]);
        }
        out
    }

    #[inline(always)]
    fn le16(self, a: Self::F16, b: Self::F16) -> u16 {
        self.mask16([
            self.lanes_le4(a[0], b[0]),
            self.lanes_le4(a[1], b[1]),
            self.lanes_le4(a[2], b[2]),
            self.lanes_le4(a[3], b[3]),
        ])
    }

    #[inline(always)]
    fn eq16(self, a: Self::F16, b: Self::F16) -> u16 {
        self.mask16([
            self.lanes_eq4(a[0], b[0]),
            self.lanes_eq4(a[1], b[1]),
            self.lanes_eq4(a[2], b[2]),
            self.lanes_eq4(a[3], b[3]),
        ])
    }

    #[inline(always)]
    fn store_masked16(self, place: &mut Row, mask: u16, x: Self::F16) {
        let old = self.load16(place);
        let mut new = x;
        for register in 0..4 {
            // SAFETY: `self` proves NEON; four integers are read from an array of four.
            new[register] = unsafe {
                let bits = vdupq_n_u32(u32::from(mask) >> (4 * register));
                let written = vtstq_u32(bits, vld1q_u32([1, 2, 4, 8].as_ptr()));
                vbslq_f32(written, x[register], old[register])
            };
        }
        *place = self.store16(new);
    }
}
