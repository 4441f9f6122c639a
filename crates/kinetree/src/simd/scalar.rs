//! The vocabulary in plain Rust: the slow twin of the others, and what other processors run.

use std::array;

use super::{Isa, Kernel, Lanes, Row};

#[derive(Clone, Copy)]
pub(crate) struct Scalar;

#[inline(always)]
fn zip<const N: usize>(a: [f32; N], b: [f32; N], f: impl Fn(f32, f32) -> f32) -> [f32; N] {
    let mut out = [0.0; N];
    for lane in 0..N {
        out[lane] = f(a[lane], b[lane]);
    }
    out
}

#[inline(always)]
fn mask<const N: usize>(a: [f32; N], b: [f32; N], f: impl Fn(f32, f32) -> bool) -> u32 {
    (0..N).fold(0, |bits, lane| bits | u32::from(f(a[lane], b[lane])) << lane)
}

impl Scalar {
    /// Apart from the other levels, so that choosing one stays short.
    #[inline(never)]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        kernel.run(self)
    }
}

/// Arrays are lanes; a row is one of sixteen.
macro_rules! arrays {
    ($lanes:ty, $array:ty, $of:expr, $to:expr) => {
        impl Lanes<Scalar> for $lanes {
            type Array = $array;

            #[inline(always)]
            fn splat(_: Scalar, x: f32) -> Self {
                [x; size_of::<Self>() / 4]
            }

            #[inline(always)]
            fn load(_: Scalar, x: &$array) -> Self {
                ($of)(*x)
            }

            #[inline(always)]
            fn store(self, _: Scalar) -> $array {
                ($to)(self)
            }

            #[inline(always)]
            fn add(self, _: Scalar, b: Self) -> Self {
                zip(self, b, |a, b| a + b)
            }

            #[inline(always)]
            fn sub(self, _: Scalar, b: Self) -> Self {
                zip(self, b, |a, b| a - b)
            }

            #[inline(always)]
            fn mul(self, _: Scalar, b: Self) -> Self {
                zip(self, b, |a, b| a * b)
            }

            #[inline(always)]
            fn div(self, _: Scalar, b: Self) -> Self {
                zip(self, b, |a, b| a / b)
            }

            #[inline(always)]
            fn mul_sub(self, _: Scalar, b: Self, c: Self) -> Self {
                zip(zip(self, b, |a, b| a * b), c, |product, c| product - c)
            }

            #[inline(always)]
            fn mul_add(self, _: Scalar, b: Self, c: Self) -> Self {
                zip(zip(self, b, |a, b| a * b), c, |product, c| product + c)
            }

            #[inline(always)]
            fn fused(self, _: Scalar, b: Self, c: Self) -> Self {
                array::from_fn(|lane| self[lane].mul_add(b[lane], c[lane]))
            }

            #[inline(always)]
            fn fused_less(self, _: Scalar, b: Self, c: Self) -> Self {
                array::from_fn(|lane| (-self[lane]).mul_add(b[lane], c[lane]))
            }

            #[inline(always)]
            fn max(self, _: Scalar, b: Self) -> Self {
                zip(self, b, |a, b| if a > b { a } else { b })
            }

            #[inline(always)]
            fn min(self, _: Scalar, b: Self) -> Self {
                zip(self, b, |a, b| if a < b { a } else { b })
            }

            #[inline(always)]
            fn abs(self, _: Scalar) -> Self {
                zip(self, self, |x, _| x.abs())
            }

            #[inline(always)]
            fn le(self, _: Scalar, b: Self) -> u32 {
                mask(self, b, |a, b| a <= b)
            }
        }
    };
}

arrays!([f32; 1], [f32; 1], |x| x, |x| x);
arrays!([f32; 3], [f32; 3], |x| x, |x| x);
arrays!([f32; 4], [f32; 4], |x| x, |x| x);
arrays!([f32; 8], [f32; 8], |x| x, |x| x);
arrays!([f32; 16], Row, |x: Row| x.0, Row);

impl Isa for Scalar {
    type F8 = [f32; 8];
    type F4 = [f32; 4];
    type F16 = [f32; 16];

    #[inline(always)]
    fn xor_sign(self, x: [f32; 8], signs: &[u32; 8]) -> [f32; 8] {
        zip(x, signs.map(f32::from_bits), |x, sign| f32::from_bits(x.to_bits() ^ sign.to_bits()))
    }

    #[inline(always)]
    fn max_bits(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        zip(a, b, |a, b| if (a.to_bits() as i32) > b.to_bits() as i32 { a } else { b })
    }

    #[inline(always)]
    fn min_bits(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        zip(a, b, |a, b| if (a.to_bits() as i32) < b.to_bits() as i32 { a } else { b })
    }

    #[inline(always)]
    fn zip_u64(self, upper: [f32; 8], lower: &[u32; 8]) -> [u64; 8] {
        let mut out = [0; 8];
        for lane in 0..8 {
            out[lane] = u64::from(upper[lane].to_bits()) << 32 | u64::from(lower[lane]);
        }
        out
    }

    #[inline(always)]
    fn lt_bits(self, a: [f32; 8], b: [f32; 8]) -> u32 {
        mask(a, b, |a, b| (a.to_bits() as i32) < b.to_bits() as i32)
    }

    #[inline(always)]
    fn extract_bits<const SHIFT: i32, const MASK: u32>(self, words: &[u32; 8]) -> [f32; 8] {
        let mut out = [0.0; 8];
        for lane in 0..8 {
            out[lane] = (words[lane] >> SHIFT & MASK) as f32;
        }
        out
    }

    #[inline(always)]
    fn transpose_xyz(self, points: &[[f32; 4]; 8]) -> [[f32; 8]; 3] {
        let mut out = [[0.0; 8]; 3];
        for lane in 0..8 {
            for axis in 0..3 {
                out[axis][lane] = points[lane][axis];
            }
        }
        out
    }

    #[inline(always)]
    fn largest_of_three(self, x: [f32; 4]) -> [f32; 4] {
        let size = |lane: usize| x[lane].to_bits() & 0x7fff_ffff;
        [f32::from_bits(size(0).max(size(1)).max(size(2))); 4]
    }

    #[inline(always)]
    fn first(self, x: [f32; 4]) -> f32 {
        x[0]
    }

    #[inline(always)]
    fn permute(self, x: [f32; 4], order: &[u32; 4]) -> [f32; 4] {
        [x[order[0] as usize & 3], x[order[1] as usize & 3], x[order[2] as usize & 3], x[order[3] as usize & 3]]
    }

    #[inline(always)]
    fn spread4<const LANE: i32>(self, x: [f32; 4]) -> [f32; 4] {
        [x[LANE as usize & 3]; 4]
    }

    #[inline(always)]
    fn signs(self, x: [f32; 4]) -> u32 {
        mask(x, x, |x, _| x.is_sign_negative())
    }

    #[inline(always)]
    fn with_last(self, x: [f32; 4], last: f32) -> [f32; 4] {
        [x[0], x[1], x[2], last]
    }

    #[inline(always)]
    fn spread8<const LANE: i32>(self, x: [f32; 4]) -> [f32; 8] {
        [x[LANE as usize & 3]; 8]
    }

    #[inline(always)]
    fn load3(self, x: &[f32; 3]) -> [f32; 4] {
        [x[0], x[1], x[2], 0.0]
    }

    #[inline(always)]
    fn blend_prefix(self, count: u32, a: [f32; 4], rest: [f32; 4]) -> [f32; 4] {
        let mut out = rest;
        for lane in 0..4 {
            out[lane] = if (lane as u32) < count { a[lane] } else { rest[lane] };
        }
        out
    }

    #[inline(always)]
    fn transpose(self, rows: [[f32; 4]; 4]) -> [[f32; 4]; 4] {
        let mut out = [[0.0; 4]; 4];
        for row in 0..4 {
            for column in 0..4 {
                out[column][row] = rows[row][column];
            }
        }
        out
    }

    #[inline(always)]
    fn eq(self, a: [f32; 16], b: [f32; 16]) -> u32 {
        mask(a, b, |a, b| a == b)
    }
}
