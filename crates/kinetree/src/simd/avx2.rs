//! Eight lanes in one register, as most x86-64 processors since 2013 have them.

use std::arch::x86_64::*;

use super::x86::{operations_of_avx2, register};
use super::{Isa, Kernel, Lanes, Row};

/// Exists only where the processor has AVX2.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(());

impl Avx2 {
    pub(crate) fn detect() -> Option<Self> {
        let present = std::arch::is_x86_feature_detected!("avx2")
            && std::arch::is_x86_feature_detected!("fma")
            && std::arch::is_x86_feature_detected!("bmi1")
            && std::arch::is_x86_feature_detected!("bmi2")
            && std::arch::is_x86_feature_detected!("lzcnt")
            && std::arch::is_x86_feature_detected!("popcnt");
        present.then_some(Self(()))
    }

    #[inline]
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[target_feature(enable = "avx,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        fn with<K: Kernel>(isa: Avx2, kernel: K) -> K::Output {
            kernel.run(isa)
        }
        // SAFETY: `self` proves that the processor has these features.
        unsafe { with(self, kernel) }
    }
}

register! {
    Avx2, __m128, [f32; 4],
    _mm_set1_ps, _mm_loadu_ps, _mm_storeu_ps, _mm_add_ps, _mm_sub_ps, _mm_mul_ps, _mm_div_ps,
    _mm_fmsub_ps, _mm_fmadd_ps, _mm_fnmadd_ps, _mm_max_ps, _mm_min_ps,
    |x| _mm_andnot_ps(_mm_set1_ps(-0.0), x), |a, b| _mm_movemask_ps(_mm_cmple_ps(a, b)) as u32
}

register! {
    Avx2, __m256, [f32; 8],
    _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps, _mm256_div_ps,
    _mm256_fmsub_ps, _mm256_fmadd_ps, _mm256_fnmadd_ps, _mm256_max_ps, _mm256_min_ps,
    |x| _mm256_andnot_ps(_mm256_set1_ps(-0.0), x),
    |a, b| _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32
}

/// Sixteen lanes are two registers.
impl Lanes<Avx2> for [__m256; 2] {
    type Array = Row;

    #[inline(always)]
    fn splat(isa: Avx2, x: f32) -> Self {
        [isa.splat(x); 2]
    }

    #[inline(always)]
    fn load(_: Avx2, x: &Row) -> Self {
        // SAFETY: the level proves AVX2; sixteen floats are read from a row of sixteen, which is
        // aligned to 64 bytes.
        unsafe { [_mm256_load_ps(x.0.as_ptr()), _mm256_load_ps(x.0.as_ptr().add(8))] }
    }

    #[inline(always)]
    fn store(self, _: Avx2) -> Row {
        let mut out = Row([0.0; 16]);
        // SAFETY: the level proves AVX2; sixteen floats are written to a row of sixteen, which is
        // aligned to 64 bytes.
        unsafe {
            _mm256_store_ps(out.0.as_mut_ptr(), self[0]);
            _mm256_store_ps(out.0.as_mut_ptr().add(8), self[1]);
        }
        out
    }

    #[inline(always)]
    fn add(self, isa: Avx2, b: Self) -> Self {
        [self[0].add(isa, b[0]), self[1].add(isa, b[1])]
    }

    #[inline(always)]
    fn sub(self, isa: Avx2, b: Self) -> Self {
        [self[0].sub(isa, b[0]), self[1].sub(isa, b[1])]
    }

    #[inline(always)]
    fn mul(self, isa: Avx2, b: Self) -> Self {
        [self[0].mul(isa, b[0]), self[1].mul(isa, b[1])]
    }

    #[inline(always)]
    fn div(self, isa: Avx2, b: Self) -> Self {
        [self[0].div(isa, b[0]), self[1].div(isa, b[1])]
    }

    #[inline(always)]
    fn max(self, isa: Avx2, b: Self) -> Self {
        [self[0].max(isa, b[0]), self[1].max(isa, b[1])]
    }

    #[inline(always)]
    fn min(self, isa: Avx2, b: Self) -> Self {
        [self[0].min(isa, b[0]), self[1].min(isa, b[1])]
    }

    #[inline(always)]
    fn mul_sub(self, isa: Avx2, b: Self, c: Self) -> Self {
        [self[0].mul_sub(isa, b[0], c[0]), self[1].mul_sub(isa, b[1], c[1])]
    }

    #[inline(always)]
    fn mul_add(self, isa: Avx2, b: Self, c: Self) -> Self {
        [self[0].mul_add(isa, b[0], c[0]), self[1].mul_add(isa, b[1], c[1])]
    }

    #[inline(always)]
    fn fused(self, isa: Avx2, b: Self, c: Self) -> Self {
        [self[0].fused(isa, b[0], c[0]), self[1].fused(isa, b[1], c[1])]
    }

    #[inline(always)]
    fn fused_less(self, isa: Avx2, b: Self, c: Self) -> Self {
        [self[0].fused_less(isa, b[0], c[0]), self[1].fused_less(isa, b[1], c[1])]
    }

    #[inline(always)]
    fn abs(self, isa: Avx2) -> Self {
        [self[0].abs(isa), self[1].abs(isa)]
    }

    #[inline(always)]
    fn le(self, isa: Avx2, b: Self) -> u32 {
        self[0].le(isa, b[0]) | self[1].le(isa, b[1]) << 8
    }
}

impl Isa for Avx2 {
    type F8 = __m256;
    type F4 = __m128;
    type F16 = [__m256; 2];

    operations_of_avx2!();

    #[inline(always)]
    fn zip_u64(self, upper: __m256, lower: &[u32; 8]) -> [u64; 8] {
        let mut out = [0; 8];
        // SAFETY: `self` proves AVX2; eight words are read from an array of eight, and twice four
        // numbers written to one of eight.
        unsafe {
            let (upper, lower) = (_mm256_castps_si256(upper), _mm256_loadu_si256(lower.as_ptr().cast()));
            let (even, odd) = (_mm256_unpacklo_epi32(lower, upper), _mm256_unpackhi_epi32(lower, upper));
            _mm256_storeu_si256(out.as_mut_ptr().cast(), _mm256_permute2x128_si256::<0x20>(even, odd));
            _mm256_storeu_si256(out.as_mut_ptr().add(4).cast(), _mm256_permute2x128_si256::<0x31>(even, odd));
        }
        out
    }

    #[inline(always)]
    fn load3(self, x: &[f32; 3]) -> __m128 {
        // SAFETY: `self` proves AVX2; a lane that is masked out is not read, so only the three of
        // the array are.
        unsafe { _mm_maskload_ps(x.as_ptr(), _mm_setr_epi32(-1, -1, -1, 0)) }
    }

    #[inline(always)]
    fn blend_prefix(self, count: u32, a: __m128, rest: __m128) -> __m128 {
        // SAFETY: `self` proves AVX2.
        unsafe {
            let others = _mm_cmpgt_epi32(_mm_setr_epi32(1, 2, 3, 4), _mm_set1_epi32(count as i32));
            _mm_blendv_ps(a, rest, _mm_castsi128_ps(others))
        }
    }

    #[inline(always)]
    fn eq(self, a: [__m256; 2], b: [__m256; 2]) -> u32 {
        // SAFETY: `self` proves AVX2.
        let (low, high) = unsafe {
            (
                _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_EQ_OQ>(a[0], b[0])),
                _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_EQ_OQ>(a[1], b[1])),
            )
        };
        low as u32 | (high as u32) << 8
    }
}
