//! Eight lanes in one register, as most x86-64 processors since 2013 have them.

use std::arch::x86_64::*;

use super::x86::words_of_avx2;
use super::{Isa, Kernel, Row};

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

impl Isa for Avx2 {
    type F8 = __m256;
    type F4 = __m128;
    type F16 = [__m256; 2];

    words_of_avx2!();

    #[inline(always)]
    fn zip_u64(self, upper: __m256, lower: &[u32; 8]) -> [u64; 8] {
        let mut out = [0; 8];
        // SAFETY: `self` proves AVX2; eight words are read from an array of eight, and twice four numbers written to one of eight.
        unsafe {
            let (upper, lower) = (_mm256_castps_si256(upper), _mm256_loadu_si256(lower.as_ptr().cast()));
            let (even, odd) = (_mm256_unpacklo_epi32(lower, upper), _mm256_unpackhi_epi32(lower, upper));
            _mm256_storeu_si256(out.as_mut_ptr().cast(), _mm256_permute2x128_si256::<0x20>(even, odd));
            _mm256_storeu_si256(out.as_mut_ptr().add(4).cast(), _mm256_permute2x128_si256::<0x31>(even, odd));
        }
        out
    }

    #[inline(always)]
    fn le8(self, a: __m256, b: __m256) -> u8 {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u8 }
    }

    #[inline(always)]
    fn le4(self, a: __m128, b: __m128) -> u8 {
        // SAFETY: `self` proves AVX2.
        unsafe { _mm_movemask_ps(_mm_cmple_ps(a, b)) as u8 }
    }

    #[inline(always)]
    fn load3(self, x: &[f32; 3]) -> __m128 {
        // SAFETY: `self` proves AVX2; a lane that is masked out is not read, so only the three of the array are.
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
    fn splat16(self, x: f32) -> [__m256; 2] {
        [self.splat8(x); 2]
    }

    #[inline(always)]
    fn load16(self, x: &Row) -> [__m256; 2] {
        // SAFETY: `self` proves AVX2; sixteen floats are read from a row of sixteen, which is aligned to 64 bytes.
        unsafe { [_mm256_load_ps(x.0.as_ptr()), _mm256_load_ps(x.0.as_ptr().add(8))] }
    }

    #[inline(always)]
    fn store16(self, x: [__m256; 2]) -> Row {
        let mut out = Row([0.0; 16]);
        // SAFETY: `self` proves AVX2; sixteen floats are written to a row of sixteen, which is aligned to 64 bytes.
        unsafe {
            _mm256_store_ps(out.0.as_mut_ptr(), x[0]);
            _mm256_store_ps(out.0.as_mut_ptr().add(8), x[1]);
        }
        out
    }

    #[inline(always)]
    fn add16(self, a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_add_ps(a[0], b[0]), _mm256_add_ps(a[1], b[1])] }
    }

    #[inline(always)]
    fn sub16(self, a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_sub_ps(a[0], b[0]), _mm256_sub_ps(a[1], b[1])] }
    }

    #[inline(always)]
    fn mul16(self, a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_mul_ps(a[0], b[0]), _mm256_mul_ps(a[1], b[1])] }
    }

    #[inline(always)]
    fn div16(self, a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
        // SAFETY: `self` proves AVX2.
        unsafe { [_mm256_div_ps(a[0], b[0]), _mm256_div_ps(a[1], b[1])] }
    }

    #[inline(always)]
    fn abs16(self, x: [__m256; 2]) -> [__m256; 2] {
        // SAFETY: `self` proves AVX2.
        unsafe {
            let sign = _mm256_set1_ps(-0.0);
            [_mm256_andnot_ps(sign, x[0]), _mm256_andnot_ps(sign, x[1])]
        }
    }

    #[inline(always)]
    fn mul_sub16(self, a: [__m256; 2], b: [__m256; 2], c: [__m256; 2]) -> [__m256; 2] {
        [self.mul_sub8(a[0], b[0], c[0]), self.mul_sub8(a[1], b[1], c[1])]
    }

    #[inline(always)]
    fn fused16(self, a: [__m256; 2], b: [__m256; 2], c: [__m256; 2]) -> [__m256; 2] {
        // SAFETY: `self` proves AVX2 and FMA.
        unsafe { [_mm256_fmadd_ps(a[0], b[0], c[0]), _mm256_fmadd_ps(a[1], b[1], c[1])] }
    }

    #[inline(always)]
    fn fused_less16(self, a: [__m256; 2], b: [__m256; 2], c: [__m256; 2]) -> [__m256; 2] {
        // SAFETY: `self` proves AVX2 and FMA.
        unsafe { [_mm256_fnmadd_ps(a[0], b[0], c[0]), _mm256_fnmadd_ps(a[1], b[1], c[1])] }
    }

    #[inline(always)]
    fn max16(self, a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
        [self.max8(a[0], b[0]), self.max8(a[1], b[1])]
    }

    #[inline(always)]
    fn min16(self, a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
        [self.min8(a[0], b[0]), self.min8(a[1], b[1])]
    }

    #[inline(always)]
    fn le16(self, a: [__m256; 2], b: [__m256; 2]) -> u16 {
        u16::from(self.le8(a[0], b[0])) | u16::from(self.le8(a[1], b[1])) << 8
    }

    #[inline(always)]
    fn eq16(self, a: [__m256; 2], b: [__m256; 2]) -> u16 {
        // SAFETY: `self` proves AVX2.
        let (low, high) = unsafe {
            (
                _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_EQ_OQ>(a[0], b[0])),
                _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_EQ_OQ>(a[1], b[1])),
            )
        };
        low as u16 & 0xff | (high as u16) << 8
    }
}
