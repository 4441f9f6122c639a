//! The vector vocabulary, and proof that the processor has it.
//!
//! Kernels are written once, generic over `Isa`. A level such as `Avx2` implements the vocabulary, and only detection can make one, so holding it is
//! the evidence. A `Kernel` is run by `Level::run`, which compiles it once for each level.
//!
//! The environment variable `KINETREE_SIMD` (`scalar`, `avx2`, `avx512`, `neon`) chooses a level
//! that the processor has; the best one is taken otherwise. A name that is none of them is said
//! once, on standard error, with those that there are; who would rather fail asks
//! [`Level::from_environment`].

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "aarch64")]
mod neon;
mod scalar;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::fmt;
use std::sync::OnceLock;

use thiserror::Error;

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) use avx512::Avx512;
#[cfg(target_arch = "aarch64")]
pub(crate) use neon::Neon;
pub(crate) use scalar::Scalar;

/// The words that kernels are written in: sixteen, eight or four lanes of `f32`, and masks with a
/// bit per lane.
///
/// Arithmetic rounds as IEEE 754 says and gives the same bits on every level, each operation
/// rounded once, but for `mul_sub` and `mul_add`, which may round once or twice and differ from
/// level to level. `max` and `min` give the second operand when one is not a number.
pub(crate) trait Isa: Copy {
    /// Eight lanes.
    type F8: Copy;
    /// Four lanes.
    type F4: Copy;
    /// Sixteen lanes: a row of a packet of rays.
    type F16: Copy;

    fn splat8(self, x: f32) -> Self::F8;
    fn load8(self, x: &[f32; 8]) -> Self::F8;
    fn store8(self, x: Self::F8) -> [f32; 8];
    /// `a * b - c`. Rounded once or twice: only where an error bound allows for both.
    fn mul_sub8(self, a: Self::F8, b: Self::F8, c: Self::F8) -> Self::F8;
    /// `a * b + c`. Rounded once or twice: only where an error bound allows for both.
    fn mul_add8(self, a: Self::F8, b: Self::F8, c: Self::F8) -> Self::F8;
    fn max8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    fn min8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    /// With other signs, in the lanes whose words have their first bit.
    fn xor_sign(self, x: Self::F8, signs: &[u32; 8]) -> Self::F8;
    fn le8(self, a: Self::F8, b: Self::F8) -> u8;
    fn add8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    fn sub8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    fn mul8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    /// Of each word, the bits from `SHIFT` on that `MASK` has, as a number below 2^24.
    fn extract_bits<const SHIFT: i32, const MASK: u32>(self, words: &[u32; 8]) -> Self::F8;
    /// Asks for the cache lines of an item that will be needed; there need not be one with that number.
    #[inline(always)]
    fn prefetch<T>(self, _items: &[T], _at: usize) {}
    /// The first three lanes of eight points, as three rows.
    fn transpose_xyz(self, points: &[Self::F4; 8]) -> [Self::F8; 3];

    fn splat4(self, x: f32) -> Self::F4;
    fn load4(self, x: &[f32; 4]) -> Self::F4;
    /// As `load4`, a number at a time: what has just been written in pieces is not waited for, as it is by a load that spans them.
    #[inline(always)]
    fn load4_elementwise(self, x: &[f32; 4]) -> Self::F4 {
        self.load4(x)
    }
    fn store4(self, x: Self::F4) -> [f32; 4];
    fn add4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    fn sub4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    fn mul4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    fn div4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    /// `a * b - c`. Rounded once or twice: only where an error bound allows for both.
    fn mul_sub4(self, a: Self::F4, b: Self::F4, c: Self::F4) -> Self::F4;
    /// `a * b + c`, rounded once.
    fn fused4(self, a: Self::F4, b: Self::F4, c: Self::F4) -> Self::F4;
    /// `c - a * b`, rounded once.
    fn fused_less4(self, a: Self::F4, b: Self::F4, c: Self::F4) -> Self::F4;
    fn max4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    fn abs4(self, x: Self::F4) -> Self::F4;
    /// The largest of the first three lanes by size, in all lanes; what is no number is larger than all.
    fn largest_of_three(self, x: Self::F4) -> Self::F4;
    /// The first lane.
    fn first(self, x: Self::F4) -> f32;
    /// Lanes in another order, each number below four.
    fn permute4(self, x: Self::F4, order: &[u32; 4]) -> Self::F4;
    /// One lane in all.
    fn spread4<const LANE: i32>(self, x: Self::F4) -> Self::F4;
    /// The sign of each lane, one bit each.
    fn signs4(self, x: Self::F4) -> u8;
    /// With another last lane.
    fn with_last4(self, x: Self::F4, last: f32) -> Self::F4;
    /// One lane of four, in eight lanes.
    fn spread8<const LANE: i32>(self, x: Self::F4) -> Self::F8;
    fn le4(self, a: Self::F4, b: Self::F4) -> u8;
    fn min4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    /// Three lanes; the fourth is zero. Nothing behind the three is read.
    fn load3(self, x: &[f32; 3]) -> Self::F4;
    /// The first `count` lanes of `a`, the others of `rest`.
    fn blend_prefix(self, count: u32, a: Self::F4, rest: Self::F4) -> Self::F4;
    /// Rows become columns.
    fn transpose4(self, rows: [Self::F4; 4]) -> [Self::F4; 4];

    /// Lane by lane, bits in the upper half and a word in the lower half.
    fn zip_u64(self, upper: Self::F8, lower: &[u32; 8]) -> [u64; 8];

    /// One of eight words. The processor predicts which, as it does for any branch, and goes on with it; what the number waits for is not waited for.
    #[inline(always)]
    fn predicted(self, words: &[u32; 8], number: usize) -> u32 {
        words[number & 7]
    }

    /// The larger one, compared by bits as signed whole numbers: right for floats unless both are negative.
    fn max_bits8(self, a: Self::F8, b: Self::F8) -> Self::F8;

    /// The smaller one, compared by bits as signed whole numbers: right for floats unless both are negative.
    fn min_bits8(self, a: Self::F8, b: Self::F8) -> Self::F8;

    /// The lanes where the first comes before the second, one bit each. Compared by bits: the first is not negative, and neither is a number that is none.
    fn lt_bits(self, a: Self::F8, b: Self::F8) -> u32;

    fn splat16(self, x: f32) -> Self::F16;
    fn load16(self, x: &Row) -> Self::F16;
    fn store16(self, x: Self::F16) -> Row;
    fn add16(self, a: Self::F16, b: Self::F16) -> Self::F16;
    fn sub16(self, a: Self::F16, b: Self::F16) -> Self::F16;
    fn mul16(self, a: Self::F16, b: Self::F16) -> Self::F16;
    fn div16(self, a: Self::F16, b: Self::F16) -> Self::F16;
    fn abs16(self, x: Self::F16) -> Self::F16;
    /// `a * b - c`. Rounded once or twice: only where an error bound allows for both.
    fn mul_sub16(self, a: Self::F16, b: Self::F16, c: Self::F16) -> Self::F16;
    /// `a * b + c`, rounded once.
    fn fused16(self, a: Self::F16, b: Self::F16, c: Self::F16) -> Self::F16;
    /// `c - a * b`, rounded once.
    fn fused_less16(self, a: Self::F16, b: Self::F16, c: Self::F16) -> Self::F16;
    fn max16(self, a: Self::F16, b: Self::F16) -> Self::F16;
    fn min16(self, a: Self::F16, b: Self::F16) -> Self::F16;
    fn le16(self, a: Self::F16, b: Self::F16) -> u16;
    fn eq16(self, a: Self::F16, b: Self::F16) -> u16;

    /// Writes the lanes in `mask`; the others stay what they are.
    #[inline(always)]
    fn store_masked16(self, place: &mut Row, mask: u16, x: Self::F16) {
        let x = self.store16(x);
        for lane in 0..16 {
            place.0[lane] = if mask >> lane & 1 == 1 { x.0[lane] } else { place.0[lane] };
        }
    }
}

/// Sixteen numbers in one cache line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Row(pub(crate) [f32; 16]);

/// Work that is compiled once for each level.
pub(crate) trait Kernel {
    /// What comes out.
    type Output;

    /// Has to be `#[inline(always)]`, or it is compiled without the level's instructions.
    fn run<I: Isa>(self, isa: I) -> Self::Output;
}

/// The environment variable that names a level.
const VARIABLE: &str = "KINETREE_SIMD";

/// `KINETREE_SIMD` names no level of this processor.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{VARIABLE}={name} is no level of this processor, which has {}", names())]
pub struct UnknownLevel {
    /// What it names.
    pub name: String,
}

/// The names of all levels that this processor has, as people list them.
fn names() -> String {
    let names: Vec<&str> = Level::available().into_iter().map(Level::name).collect();
    names.join(", ")
}

/// What the processor can do, as found out at run time.
#[derive(Clone, Copy)]
pub struct Level(Kind);

#[derive(Clone, Copy)]
enum Kind {
    Scalar(Scalar),
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
    #[cfg(target_arch = "aarch64")]
    Neon(Neon),
}

impl Level {
    /// The level that queries use: the best one that the processor has, or the one that
    /// `KINETREE_SIMD` names. A name that is no level of this processor is said on standard error,
    /// the first time that this is called, and the best level is taken.
    pub fn current() -> Self {
        static CURRENT: OnceLock<Level> = OnceLock::new();
        *CURRENT.get_or_init(|| {
            Self::from_environment().unwrap_or_else(|error| {
                let best = Self::best();
                eprintln!("kinetree: {error}; taking {best:?}");
                best
            })
        })
    }

    /// The level that `KINETREE_SIMD` names; the best one that the processor has when the variable
    /// is not set, or empty.
    ///
    /// # Errors
    /// The variable names no level of this processor.
    pub fn from_environment() -> Result<Self, UnknownLevel> {
        match std::env::var_os(VARIABLE) {
            Some(name) if !name.is_empty() => Self::named(&name.to_string_lossy()),
            _ => Ok(Self::best()),
        }
    }

    fn named(name: &str) -> Result<Self, UnknownLevel> {
        let level = Self::available().into_iter().find(|level| level.name() == name);
        level.ok_or_else(|| UnknownLevel { name: name.to_owned() })
    }

    fn best() -> Self {
        Self::available().pop().unwrap_or(Self(Kind::Scalar(Scalar)))
    }

    /// Every level that this processor has, the best one last.
    pub fn available() -> Vec<Self> {
        let kinds = [
            Some(Kind::Scalar(Scalar)),
            #[cfg(target_arch = "x86_64")]
            Avx2::detect().map(Kind::Avx2),
            #[cfg(target_arch = "x86_64")]
            Avx512::detect().map(Kind::Avx512),
            #[cfg(target_arch = "aarch64")]
            Neon::detect().map(Kind::Neon),
        ];
        kinds.into_iter().flatten().map(Self).collect()
    }

    /// As `KINETREE_SIMD` names it.
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Scalar(_) => "scalar",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512(_) => "avx512",
            #[cfg(target_arch = "aarch64")]
            Kind::Neon(_) => "neon",
        }
    }

    #[inline]
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Kind::Scalar(isa) => isa.run(kernel),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(isa) => isa.run(kernel),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512(isa) => isa.run(kernel),
            #[cfg(target_arch = "aarch64")]
            Kind::Neon(isa) => isa.run(kernel),
        }
    }
}

impl Level {
    /// Whether kernels run on vectors.
    #[inline]
    pub(crate) fn is_vector(self) -> bool {
        !matches!(self.0, Kind::Scalar(_))
    }

    /// Runs a kernel that is compiled for vector levels only.
    ///
    /// # Errors
    /// The level has no vectors.
    #[inline]
    pub(crate) fn run_vector<K: Kernel>(self, kernel: K) -> Result<K::Output, NoVectors> {
        match self.0 {
            Kind::Scalar(_) => Err(NoVectors),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(isa) => Ok(isa.run(kernel)),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512(isa) => Ok(isa.run(kernel)),
            #[cfg(target_arch = "aarch64")]
            Kind::Neon(isa) => Ok(isa.run(kernel)),
        }
    }
}

/// A kernel was not run, since it is compiled for vector levels only.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NoVectors;

impl fmt::Debug for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_found_by_its_name_and_an_unknown_one_is_answered_with_those_there_are() {
        for level in Level::available() {
            assert_eq!(Level::named(level.name()).map(Level::name), Ok(level.name()));
        }
        for wrong in ["nonsense", "AVX2", "avx", " scalar", "\u{fffd}"] {
            let error = Level::named(wrong).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(error.contains(wrong) && error.contains("scalar"), "{wrong}: {error}");
        }
    }

    struct Words;

    impl Kernel for Words {
        type Output = Vec<u32>;

        #[inline(always)]
        fn run<I: Isa>(self, isa: I) -> Vec<u32> {
            let nan = f32::NAN;
            let (a, b) = ([1.5, -2.0, nan, 0.1, 7.0, -0.0, 1e30, 3.0], [2.0, -3.0, 4.0, nan, 7.0, 0.0, 1e-30, -3.0]);
            let (x, y) = (isa.load8(&a), isa.load8(&b));
            let mut out: Vec<u32> = vec![isa.le8(x, y).into()];
            let (zero, past) =
                (isa.splat8(0.0), isa.load8(&[0.0, 1e-40, -0.0, -1.0, f32::INFINITY, nan, -f32::INFINITY, 1.0]));
            let after_all = isa.splat8(f32::from_bits(f32::INFINITY.to_bits() + 1));
            for v in [isa.min_bits8(past, after_all), isa.min_bits8(after_all, past), isa.max_bits8(past, zero)] {
                out.extend(isa.store8(v).iter().map(|x| x.to_bits()));
            }
            let flipped = isa.xor_sign(past, &[1 << 31, 0, 1 << 31, 0, 1 << 31, 0, 1 << 31, 1 << 31]);
            out.extend(isa.store8(flipped).map(f32::to_bits));
            let from = out.len();
            out.extend([isa.lt_bits(zero, past), isa.lt_bits(isa.splat8(f32::INFINITY), past)]);
            assert_eq!(out[from..], [0b1011_0010, 0b0010_0000]);
            out.extend(isa.store8(isa.max8(x, y)).iter().map(|x| x.to_bits()));
            out.extend(isa.store8(isa.min8(x, y)).iter().map(|x| x.to_bits()));
            out.extend(
                isa.store8(isa.mul_sub8(isa.splat8(2.0), y, isa.splat8(1.0))).iter().map(|x| u32::from(x.is_nan())),
            );
            let (x, y) = (isa.load4(&[1.0, 2.0, 0.3, nan]), isa.load4(&[3.0, 2.0, 0.7, 1.0]));
            for v in [isa.add4(x, y), isa.sub4(x, y), isa.mul4(x, y), isa.div4(x, y), isa.splat4(0.1)] {
                out.extend(isa.store4(v)[..3].iter().map(|x| x.to_bits()));
            }
            for v in [isa.max4(x, y), isa.abs4(isa.sub4(isa.splat4(0.0), y)), isa.mul_sub4(x, y, y)] {
                out.extend(isa.store4(v)[..2].iter().map(|x| x.to_bits()));
            }
            for v in [
                isa.largest_of_three(y),
                isa.largest_of_three(isa.load4(&[-3.0, 1.0, -0.0, 8.0])),
                isa.with_last4(x, 7.0),
            ] {
                out.extend(isa.store4(v).iter().map(|x| x.to_bits()));
            }
            for v in [isa.permute4(y, &[2, 0, 1, 3]), isa.spread4::<0>(y), isa.spread4::<2>(y), isa.spread4::<3>(y)] {
                out.extend(isa.store4(v).map(f32::to_bits));
            }
            let of_permuted = out.len() - 16;
            assert_eq!(
                out[of_permuted..],
                [0.7, 3.0, 2.0, 1.0, 3.0, 3.0, 3.0, 3.0, 0.7, 0.7, 0.7, 0.7, 1.0, 1.0, 1.0, 1.0_f32].map(f32::to_bits)
            );
            assert_eq!(isa.first(y), 3.0);
            let sum =
                isa.mul_add8(isa.splat8(2.0), isa.load8(&[0.5, 1.0, -3.0, 0.0, 4.0, 5.0, 6.0, 7.0]), isa.splat8(1.0));
            assert_eq!(isa.store8(sum), [2.0, 3.0, -5.0, 1.0, 9.0, 11.0, 13.0, 15.0]);
            let joined = isa
                .zip_u64(isa.load8(&[0.0, -0.0, 1.0, 2.0, -3.0, 0.5, 1e30, -1e-40]), &[7, 6, 5, 4, 3, 2, 1, u32::MAX]);
            out.extend(joined.iter().flat_map(|both| [(both >> 32) as u32, *both as u32]));
            out.push(isa.signs4(isa.load4(&[-0.0, 1.0, -2.0, 0.0])).into());
            for v in [isa.spread8::<0>(x), isa.spread8::<1>(x), isa.spread8::<2>(x), isa.spread8::<3>(y)] {
                out.extend(isa.store8(v).iter().map(|x| x.to_bits()));
            }
            out.push(isa.le4(x, y).into());
            out.extend(isa.store4(isa.load4_elementwise(&[-0.0, 1.5, nan, 3.0])).map(f32::to_bits));
            out.extend(words_of_boxes(isa));
            let wide = |four: [f32; 4]| Row([four; 4].concat().try_into().expect("sixteen"));
            let (x, y) = (isa.load16(&wide([1.0, -2.0, 0.3, nan])), isa.load16(&wide([3.0, -2.0, -0.7, 1.0])));
            for v in [isa.add16(x, y), isa.sub16(x, y), isa.mul16(x, y), isa.div16(x, y), isa.splat16(0.1)] {
                out.extend(isa.store16(v).0.iter().map(|x| if x.is_nan() { 1 } else { x.to_bits() }));
            }
            for v in [isa.max16(x, y), isa.min16(x, y), isa.mul_sub16(isa.splat16(2.0), y, isa.splat16(1.0))] {
                out.extend(isa.store16(v).0.iter().map(|x| x.to_bits()));
            }
            out.extend([u32::from(isa.le16(x, y)), u32::from(isa.eq16(x, y))]);
            // Rounded twice, both would come out as zero.
            let (near_one, square) = (1.0 + f32::EPSILON, 1.0 + 2.0 * f32::EPSILON);
            for v in [
                isa.fused16(isa.splat16(near_one), isa.splat16(near_one), isa.splat16(-square)),
                isa.abs16(isa.fused_less16(isa.splat16(near_one), isa.splat16(near_one), isa.splat16(square))),
            ] {
                assert_eq!(isa.store16(v).0, [f32::EPSILON * f32::EPSILON; 16]);
            }
            for v in [
                isa.fused4(isa.splat4(near_one), isa.splat4(near_one), isa.splat4(-square)),
                isa.abs4(isa.fused_less4(isa.splat4(near_one), isa.splat4(near_one), isa.splat4(square))),
            ] {
                assert_eq!(isa.store4(v), [f32::EPSILON * f32::EPSILON; 4]);
            }
            let mut place = Row([7.0; 16]);
            isa.store_masked16(&mut place, 0b1010_0000_0011_0001, y);
            out.extend(place.0.iter().map(|x| x.to_bits()));
            out
        }
    }

    /// The words that boxes are made with.
    #[inline(always)]
    fn words_of_boxes<I: Isa>(isa: I) -> Vec<u32> {
        let nan = f32::NAN;
        let mut out = Vec::new();
        let a = isa.load8(&[1.5, -2.0, 3.0, 0.1, 7.0, -0.0, 1e30, f32::INFINITY]);
        let b = isa.load8(&[2.0, -3.0, 4.0, 0.3, 7.0, 0.0, 1e30, 1.0]);
        let links = [0, 1 << 28, 7 << 28, 5 << 28 | 12, u32::MAX, 3, 1 << 31, 0x3fff_ffff];
        for v in [isa.add8(a, b), isa.sub8(a, b), isa.mul8(a, b), isa.extract_bits::<28, 7>(&links)] {
            out.extend(isa.store8(v).iter().map(|x| x.to_bits()));
        }
        let (x, y) = (isa.load4(&[1.0, -0.0, nan, 0.3]), isa.load4(&[-3.0, 0.0, 0.7, nan]));
        for v in [isa.max4(x, y), isa.max4(y, x), isa.min4(x, y), isa.min4(y, x), isa.load3(&[0.1, -0.2, 1e30])] {
            out.extend(isa.store4(v).iter().map(|x| x.to_bits()));
        }
        for count in 0..=4 {
            out.extend(isa.store4(isa.blend_prefix(count, x, y)).iter().map(|x| x.to_bits()));
        }
        let row = |i: i32| isa.load4(&[i as f32, i as f32 + 0.25, i as f32 + 0.5, i as f32 + 0.75]);
        for column in isa.transpose4([row(0), row(1), row(2), row(3)]) {
            out.extend(isa.store4(column).iter().map(|x| x.to_bits()));
        }
        for row in isa.transpose_xyz(&[row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7)]) {
            out.extend(isa.store8(row).iter().map(|x| x.to_bits()));
        }
        out
    }

    #[test]
    fn points_become_rows_and_fields_become_numbers() {
        struct Shapes;
        impl Kernel for Shapes {
            type Output = ();

            #[inline(always)]
            fn run<I: Isa>(self, isa: I) {
                let point = |i: i32| isa.load3(&[i as f32, 10.0 + i as f32, 20.0 + i as f32]);
                let points = [point(0), point(1), point(2), point(3), point(4), point(5), point(6), point(7)];
                let [x, y, z] = isa.transpose_xyz(&points);
                assert_eq!(isa.store8(x), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
                assert_eq!(isa.store8(y), [10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0, 17.0]);
                assert_eq!(isa.store8(z), [20.0, 21.0, 22.0, 23.0, 24.0, 25.0, 26.0, 27.0]);
                let [x, y, z, w] = isa.transpose4([points[0], points[1], points[2], points[3]]);
                assert_eq!(isa.store4(x), [0.0, 1.0, 2.0, 3.0]);
                assert_eq!(isa.store4(y), [10.0, 11.0, 12.0, 13.0]);
                assert_eq!(isa.store4(z), [20.0, 21.0, 22.0, 23.0]);
                assert_eq!(isa.store4(w), [0.0; 4]);
                let links = [1 << 28, 2 << 28, 7 << 28, 15 << 28, 9, 0, u32::MAX, 8 << 28];
                assert_eq!(isa.store8(isa.extract_bits::<28, 7>(&links)), [1.0, 2.0, 7.0, 7.0, 0.0, 0.0, 7.0, 0.0]);
                assert_eq!(isa.store4(isa.blend_prefix(3, x, y)), [0.0, 1.0, 2.0, 13.0]);
            }
        }
        for level in Level::available() {
            level.run(Shapes);
        }
    }

    #[test]
    fn every_level_speaks_the_same_words() {
        let expected = Level(Kind::Scalar(Scalar)).run(Words);
        for level in Level::available() {
            assert_eq!(level.run(Words), expected, "{level:?}");
        }
    }
    /// Every pattern of lanes, through every word that makes or takes a mask.
    struct Masks;

    impl Kernel for Masks {
        type Output = ();

        #[inline(always)]
        fn run<I: Isa>(self, isa: I) {
            for mask in 0..=u16::MAX {
                let lanes: [f32; 16] = std::array::from_fn(|lane| if mask >> lane & 1 == 1 { 1.0 } else { f32::NAN });
                let first = |count: usize| mask & ((1 << count) - 1) as u16;
                let row = isa.load16(&Row(lanes));
                assert_eq!([isa.le16(row, row), isa.eq16(row, isa.splat16(1.0))], [mask; 2]);
                let eight = isa.load8(lanes.first_chunk().expect("sixteen"));
                assert_eq!(u16::from(isa.le8(eight, eight)), first(8));
                let four = isa.load4(lanes.first_chunk().expect("sixteen"));
                assert_eq!(u16::from(isa.le4(four, four)), first(4));
                let mut place = Row([3.0; 16]);
                isa.store_masked16(&mut place, mask, isa.splat16(5.0));
                assert_eq!(place.0.map(|x| x == 5.0), lanes.map(|x| x == 1.0));
            }
        }
    }

    #[test]
    fn every_lane_has_its_own_bit_in_masks() {
        Level::available().into_iter().for_each(|level| level.run(Masks));
    }

    /// Larger and smaller of all pairs, compared by bits and as numbers.
    struct ByBits;

    impl Kernel for ByBits {
        type Output = ();

        #[inline(always)]
        fn run<I: Isa>(self, isa: I) {
            let numbers = [0.0, -0.0, 1.0, -1.0, 1e-40, 3e38, f32::INFINITY, f32::NEG_INFINITY];
            for shift in 0..8 {
                let mut others = numbers;
                others.rotate_left(shift);
                let (x, y) = (isa.load8(&numbers), isa.load8(&others));
                let (larger, smaller) = (isa.store8(isa.max_bits8(x, y)), isa.store8(isa.min_bits8(x, y)));
                for lane in 0..8 {
                    let (a, b) = (numbers[lane], others[lane]);
                    if a.is_sign_negative() && b.is_sign_negative() {
                        assert!([a, b].contains(&larger[lane]) && [a, b].contains(&smaller[lane]), "{a} and {b}");
                    } else {
                        assert_eq!([larger[lane], smaller[lane]], [a.max(b), a.min(b)], "{a} and {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn comparing_by_bits_is_right_unless_both_are_negative() {
        Level::available().into_iter().for_each(|level| level.run(ByBits));
    }
}
