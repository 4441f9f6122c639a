//! The vector vocabulary, and proof that the processor has it.
//!
//! Kernels are written once, generic over `Isa`. A level such as `Avx2` implements the vocabulary,
//! and only detection can make one, so holding it is the evidence. A `Kernel` is run by
//! `Level::run`, which compiles it once for each level.
//!
//! The environment variable `KINETREE_SIMD` (`scalar`, `avx2`, `avx512`, `neon`) chooses a level
//! that the processor has; the best one is taken otherwise. Another name is reported once on
//! standard error, with the names there are; callers that would rather fail use
//! [`Level::from_environment`].

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "aarch64")]
mod neon;
mod scalar;
#[cfg(test)]
mod tests;
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

/// A register, or a few of them, whose lanes are `f32`: the arithmetic that all widths have in
/// common.
///
/// It rounds as IEEE 754 says and gives the same bits on every level, each operation rounded once,
/// but for `mul_sub` and `mul_add`, which may round once or twice and differ from level to level.
/// The `isa` that every function takes proves that the processor has its instructions.
pub(crate) trait Lanes<I>: Copy {
    /// The lanes in memory.
    type Array: Copy;

    fn splat(isa: I, x: f32) -> Self;
    fn load(isa: I, x: &Self::Array) -> Self;
    fn store(self, isa: I) -> Self::Array;
    fn add(self, isa: I, b: Self) -> Self;
    fn sub(self, isa: I, b: Self) -> Self;
    fn mul(self, isa: I, b: Self) -> Self;
    fn div(self, isa: I, b: Self) -> Self;
    fn mul_sub(self, isa: I, b: Self, c: Self) -> Self;
    fn mul_add(self, isa: I, b: Self, c: Self) -> Self;
    fn fused(self, isa: I, b: Self, c: Self) -> Self;
    fn fused_less(self, isa: I, b: Self, c: Self) -> Self;
    fn max(self, isa: I, b: Self) -> Self;
    fn min(self, isa: I, b: Self) -> Self;
    fn abs(self, isa: I) -> Self;
    fn le(self, isa: I, b: Self) -> u32;
}

/// The vocabulary that kernels are written in: arithmetic for any number of lanes, and a few
/// operations on four, eight or sixteen. Masks have a bit per lane.
pub(crate) trait Isa: Copy {
    /// Four lanes.
    type F4: Lanes<Self, Array = [f32; 4]>;
    /// Eight lanes.
    type F8: Lanes<Self, Array = [f32; 8]>;
    /// Sixteen lanes: a row of a packet of rays.
    type F16: Lanes<Self, Array = Row>;

    #[inline(always)]
    fn splat<V: Lanes<Self>>(self, x: f32) -> V {
        V::splat(self, x)
    }
    #[inline(always)]
    fn load<V: Lanes<Self>>(self, x: &V::Array) -> V {
        V::load(self, x)
    }
    #[inline(always)]
    fn store<V: Lanes<Self>>(self, x: V) -> V::Array {
        x.store(self)
    }
    #[inline(always)]
    fn add<V: Lanes<Self>>(self, a: V, b: V) -> V {
        a.add(self, b)
    }
    #[inline(always)]
    fn sub<V: Lanes<Self>>(self, a: V, b: V) -> V {
        a.sub(self, b)
    }
    #[inline(always)]
    fn mul<V: Lanes<Self>>(self, a: V, b: V) -> V {
        a.mul(self, b)
    }
    #[inline(always)]
    fn div<V: Lanes<Self>>(self, a: V, b: V) -> V {
        a.div(self, b)
    }
    /// `a * b - c`, rounded once or twice: only where an error bound allows for both.
    #[inline(always)]
    fn mul_sub<V: Lanes<Self>>(self, a: V, b: V, c: V) -> V {
        a.mul_sub(self, b, c)
    }
    /// `a * b + c`, rounded once or twice: only where an error bound allows for both.
    #[inline(always)]
    fn mul_add<V: Lanes<Self>>(self, a: V, b: V, c: V) -> V {
        a.mul_add(self, b, c)
    }
    /// `a * b + c`, rounded once.
    #[inline(always)]
    fn fused<V: Lanes<Self>>(self, a: V, b: V, c: V) -> V {
        a.fused(self, b, c)
    }
    /// `c - a * b`, rounded once.
    #[inline(always)]
    fn fused_less<V: Lanes<Self>>(self, a: V, b: V, c: V) -> V {
        a.fused_less(self, b, c)
    }
    /// The larger one; `b` where one is NaN.
    #[inline(always)]
    fn max<V: Lanes<Self>>(self, a: V, b: V) -> V {
        a.max(self, b)
    }
    /// The smaller one; `b` where one is NaN.
    #[inline(always)]
    fn min<V: Lanes<Self>>(self, a: V, b: V) -> V {
        a.min(self, b)
    }
    #[inline(always)]
    fn abs<V: Lanes<Self>>(self, x: V) -> V {
        x.abs(self)
    }
    /// The lanes where `a <= b`.
    #[inline(always)]
    fn le<V: Lanes<Self>>(self, a: V, b: V) -> u32 {
        a.le(self, b)
    }

    /// The larger one by bits as signed integers, in one cycle instead of four: right for floats
    /// unless both are negative.
    fn max_bits(self, a: Self::F8, b: Self::F8) -> Self::F8;
    /// The smaller one by bits as signed integers: right for floats unless both are negative.
    fn min_bits(self, a: Self::F8, b: Self::F8) -> Self::F8;
    /// The lanes where `a < b` by bits as signed integers. For an `a` that is neither negative nor
    /// NaN, this is right for floats.
    fn lt_bits(self, a: Self::F8, b: Self::F8) -> u32;
    /// Flips the signs of lanes whose words have bit 31 set.
    fn xor_sign(self, x: Self::F8, signs: &[u32; 8]) -> Self::F8;
    /// `words >> SHIFT & MASK`, as floats. `MASK` is below 2^24.
    fn extract_bits<const SHIFT: i32, const MASK: u32>(self, words: &[u32; 8]) -> Self::F8;
    /// Lane by lane, the bits of `upper` above a word of `lower`.
    fn zip_u64(self, upper: Self::F8, lower: &[u32; 8]) -> [u64; 8];
    /// The first three lanes of eight points, as three rows.
    fn transpose_xyz(self, points: &[Self::F4; 8]) -> [Self::F8; 3];
    /// One lane of four, in eight lanes.
    fn spread8<const LANE: i32>(self, x: Self::F4) -> Self::F8;

    /// As `load`, lane by lane: a vector load of what has just been stored in parts would have to
    /// wait for the stores.
    #[inline(always)]
    fn load_elementwise(self, x: &[f32; 4]) -> Self::F4 {
        self.load(x)
    }
    /// Three lanes and a zero. Nothing behind the three is read.
    fn load3(self, x: &[f32; 3]) -> Self::F4;
    /// The largest magnitude of the first three lanes, in all lanes; NaN is larger than all.
    fn largest_of_three(self, x: Self::F4) -> Self::F4;
    /// The first lane.
    fn first(self, x: Self::F4) -> f32;
    /// `x[order[lane]]` in each lane.
    fn permute(self, x: Self::F4, order: &[u32; 4]) -> Self::F4;
    /// One lane in all lanes.
    fn spread4<const LANE: i32>(self, x: Self::F4) -> Self::F4;
    /// The lanes whose sign bit is set.
    fn signs(self, x: Self::F4) -> u32;
    /// With another last lane.
    fn with_last(self, x: Self::F4, last: f32) -> Self::F4;
    /// The first `count` lanes of `a`, the others of `rest`.
    fn blend_prefix(self, count: u32, a: Self::F4, rest: Self::F4) -> Self::F4;
    /// Rows become columns.
    fn transpose(self, rows: [Self::F4; 4]) -> [Self::F4; 4];

    /// The lanes where `a == b`.
    fn eq(self, a: Self::F16, b: Self::F16) -> u32;
    /// Writes the lanes in `mask`.
    #[inline(always)]
    fn store_masked(self, to: &mut Row, mask: u32, x: Self::F16) {
        let x = self.store(x);
        for lane in 0..16 {
            to.0[lane] = if mask >> lane & 1 == 1 { x.0[lane] } else { to.0[lane] };
        }
    }

    /// `words[number & 7]`, through a jump table, so that the processor predicts which and goes on,
    /// instead of waiting for what `number` depends on.
    #[inline(always)]
    fn predicted(self, words: &[u32; 8], number: usize) -> u32 {
        words[number & 7]
    }
    /// Prefetches the cache lines of an item; its index may be out of bounds.
    #[inline(always)]
    fn prefetch<T>(self, _items: &[T], _at: usize) {}
}

/// Sixteen numbers in one cache line.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Zeroable, bytemuck::Pod)]
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

    /// Runs a kernel that is compiled for vector levels only; `otherwise` stands in for it at the scalar
    /// level.
    #[inline]
    pub(crate) fn run_vector<K: Kernel>(self, kernel: K, otherwise: impl FnOnce() -> K::Output) -> K::Output {
        match self.0 {
            Kind::Scalar(_) => otherwise(),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(isa) => isa.run(kernel),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512(isa) => isa.run(kernel),
            #[cfg(target_arch = "aarch64")]
            Kind::Neon(isa) => isa.run(kernel),
        }
    }
}

impl fmt::Debug for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
