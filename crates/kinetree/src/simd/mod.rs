//! The vector vocabulary, and proof that the processor has it.
//!
//! Kernels are written once, generic over [`Isa`]. A level such as `Avx2` implements the vocabulary, and only detection can make one, so holding it is
//! the evidence. A [`Kernel`] is run by [`Level::run`], which compiles it once for each level.
//!
//! The environment variable `KINETREE_SIMD` (`scalar`, `avx2`, `avx512`) chooses a level that the processor has; the best one is taken otherwise.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod scalar;

use std::fmt;
use std::sync::OnceLock;

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) use avx512::Avx512;
pub(crate) use scalar::Scalar;

/// The words that kernels are written in: eight or four lanes of `f32`, and masks with a bit per lane.
///
/// Arithmetic rounds as IEEE 754 says, each operation once, on every level. `max` and `min` give the second operand when one is not a number.
pub(crate) trait Isa: Copy {
    /// Eight lanes.
    type F8: Copy;
    /// Four lanes.
    type F4: Copy;

    fn splat8(self, x: f32) -> Self::F8;
    fn load8(self, x: &[f32; 8]) -> Self::F8;
    fn store8(self, x: Self::F8) -> [f32; 8];
    /// `a * b - c`. Rounded once or twice: only for what may lean.
    fn mul_sub8(self, a: Self::F8, b: Self::F8, c: Self::F8) -> Self::F8;
    fn max8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    fn min8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    fn le8(self, a: Self::F8, b: Self::F8) -> u8;

    fn splat4(self, x: f32) -> Self::F4;
    fn load4(self, x: &[f32; 4]) -> Self::F4;
    fn store4(self, x: Self::F4) -> [f32; 4];
    fn add4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    fn sub4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    fn mul4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    fn div4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    fn le4(self, a: Self::F4, b: Self::F4) -> u8;
    fn eq4(self, a: Self::F4, b: Self::F4) -> u8;

    /// Puts `(distance, link)` of the lanes in `mask` on a stack, the nearest one last, and says how many there are.
    ///
    /// An entry has the bits of the distance in its upper half, which order like the distance because it is not negative.
    #[inline(always)]
    fn push_sorted(self, distances: Self::F8, links: &[u32; 8], mask: u8, stack: &mut [u64; 8]) -> usize {
        let distances = self.store8(distances);
        let mut left = mask;
        let mut count = 0;
        while left != 0 {
            let lane = left.trailing_zeros() as usize & 7;
            left &= left - 1;
            let entry = u64::from(distances[lane].to_bits()) << 32 | u64::from(links[lane]);
            // Insertion keeps the farthest first; there are two or three as a rule.
            let mut at = count;
            while at > 0 && stack[(at - 1) & 7] < entry {
                stack[at & 7] = stack[(at - 1) & 7];
                at -= 1;
            }
            stack[at & 7] = entry;
            count += 1;
        }
        count
    }
}

/// Work that is compiled once for each level.
pub(crate) trait Kernel {
    /// What comes out.
    type Output;

    /// Has to be `#[inline(always)]`, or it is compiled without the level's instructions.
    fn run<I: Isa>(self, isa: I) -> Self::Output;
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
}

impl Level {
    /// The level that queries use: the best one that the processor has, or the one that `KINETREE_SIMD` names.
    pub fn current() -> Self {
        static CURRENT: OnceLock<Level> = OnceLock::new();
        *CURRENT.get_or_init(|| {
            let all = Self::available();
            let named = std::env::var("KINETREE_SIMD").ok();
            let chosen = named.and_then(|name| all.iter().find(|level| level.name() == name).copied());
            chosen.unwrap_or_else(|| all.last().copied().unwrap_or(Self(Kind::Scalar(Scalar))))
        })
    }

    /// Every level that this processor has, the best one last.
    pub fn available() -> Vec<Self> {
        let mut levels = vec![Self(Kind::Scalar(Scalar))];
        #[cfg(target_arch = "x86_64")]
        {
            levels.extend(Avx2::detect().map(|isa| Self(Kind::Avx2(isa))));
            levels.extend(Avx512::detect().map(|isa| Self(Kind::Avx512(isa))));
        }
        levels
    }

    /// As `KINETREE_SIMD` names it.
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Scalar(_) => "scalar",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512(_) => "avx512",
        }
    }

    #[inline]
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Kind::Scalar(isa) => kernel.run(isa),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(isa) => isa.run(kernel),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512(isa) => isa.run(kernel),
        }
    }
}

impl fmt::Debug for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Words;

    impl Kernel for Words {
        type Output = Vec<u32>;

        #[inline(always)]
        fn run<I: Isa>(self, isa: I) -> Vec<u32> {
            let nan = f32::NAN;
            let (a, b) = ([1.5, -2.0, nan, 0.1, 7.0, -0.0, 1e30, 3.0], [2.0, -3.0, 4.0, nan, 7.0, 0.0, 1e-30, -3.0]);
            let (x, y) = (isa.load8(&a), isa.load8(&b));
            let mut out: Vec<u32> = vec![isa.le8(x, y).into()];
            out.extend(isa.store8(isa.max8(x, y)).iter().map(|x| x.to_bits()));
            out.extend(isa.store8(isa.min8(x, y)).iter().map(|x| x.to_bits()));
            out.extend(
                isa.store8(isa.mul_sub8(isa.splat8(2.0), y, isa.splat8(1.0))).iter().map(|x| u32::from(x.is_nan())),
            );
            let (x, y) = (isa.load4(&[1.0, 2.0, 0.3, nan]), isa.load4(&[3.0, 2.0, 0.7, 1.0]));
            for v in [isa.add4(x, y), isa.sub4(x, y), isa.mul4(x, y), isa.div4(x, y), isa.splat4(0.1)] {
                out.extend(isa.store4(v)[..3].iter().map(|x| x.to_bits()));
            }
            out.extend([u32::from(isa.le4(x, y)), u32::from(isa.eq4(x, y))]);
            let mut stack = [0; 8];
            let distances = isa.load8(&[5.0, 1.0, 9.0, 2.0, 0.0, 2.0, 8.0, 3.0]);
            for mask in [0b1, 0b11, 0b1011_0101, 0b1111_1111] {
                let count = isa.push_sorted(distances, &[10, 11, 12, 13, 14, 15, 16, 17], mask, &mut stack);
                assert!(stack[..count].windows(2).all(|pair| pair[0] >= pair[1]));
                out.extend(stack[..count].iter().map(|entry| (entry >> 32) as u32));
                let mut links: Vec<u32> = stack[..count].iter().map(|entry| *entry as u32).collect();
                links.sort_unstable();
                out.extend(links);
            }
            out
        }
    }

    #[test]
    fn every_level_speaks_the_same_words() {
        let expected = Level(Kind::Scalar(Scalar)).run(Words);
        for level in Level::available() {
            assert_eq!(level.run(Words), expected, "{level:?}");
        }
    }
}
