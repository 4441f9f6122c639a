//! The same eight lanes with mask registers and twice as many registers: AVX-512VL.

use std::arch::x86_64::*;

use super::{Isa, Kernel};

/// Exists only where the processor has AVX-512VL.
#[derive(Clone, Copy)]
pub(crate) struct Avx512(());

impl Avx512 {
    pub(crate) fn detect() -> Option<Self> {
        let present = std::arch::is_x86_feature_detected!("avx2")
            && std::arch::is_x86_feature_detected!("fma")
            && std::arch::is_x86_feature_detected!("bmi1")
            && std::arch::is_x86_feature_detected!("bmi2")
            && std::arch::is_x86_feature_detected!("lzcnt")
            && std::arch::is_x86_feature_detected!("popcnt")
            && std::arch::is_x86_feature_detected!("avx512f")
            && std::arch::is_x86_feature_detected!("avx512vl")
            && std::arch::is_x86_feature_detected!("avx512dq")
            && std::arch::is_x86_feature_detected!("avx512bw");
        present.then_some(Self(()))
    }

    #[inline]
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[target_feature(enable = "avx,avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw")]
        fn with<K: Kernel>(isa: Avx512, kernel: K) -> K::Output {
            kernel.run(isa)
        }
        // SAFETY: `self` proves that the processor has these features.
        unsafe { with(self, kernel) }
    }
}

impl Isa for Avx512 {
    type F8 = __m256;
    type F4 = __m128;

    #[inline(always)]
    fn splat8(self, x: f32) -> __m256 {
        // SAFETY: `self` proves AVX-512VL.
        unsafe { _mm256_set1_ps(x) }
    }

    #[inline(always)]
    fn load8(self, x: &[f32; 8]) -> __m256 {
        // SAFETY: `self` proves AVX-512VL; eight floats are read from an array of eight.
        unsafe { _mm256_loadu_ps(x.as_ptr()) }
    }

    #[inline(always)]
    fn store8(self, x: __m256) -> [f32; 8] {
        let mut out = [0.0; 8];
        // SAFETY: `self` proves AVX-512VL; eight floats are written to an array of eight.
        unsafe { _mm256_storeu_ps(out.as_mut_ptr(), x) };
        out
    }

    #[inline(always)]
    fn mul_sub8(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        // SAFETY: `self` proves AVX-512VL and FMA.
        unsafe { _mm256_fmsub_ps(a, b, c) }
    }

    #[inline(always)]
    fn max8(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: `self` proves AVX-512VL.
        unsafe { _mm256_max_ps(a, b) }
    }

    #[inline(always)]
    fn min8(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: `self` proves AVX-512VL.
        unsafe { _mm256_min_ps(a, b) }
    }

    #[inline(always)]
    fn splat4(self, x: f32) -> __m128 {
        // SAFETY: `self` proves AVX-512VL.
        unsafe { _mm_set1_ps(x) }
    }

    #[inline(always)]
    fn load4(self, x: &[f32; 4]) -> __m128 {
        // SAFETY: `self` proves AVX-512VL; four floats are read from an array of four.
        unsafe { _mm_loadu_ps(x.as_ptr()) }
    }

    #[inline(always)]
    fn store4(self, x: __m128) -> [f32; 4] {
        let mut out = [0.0; 4];
        // SAFETY: `self` proves AVX-512VL; four floats are written to an array of four.
        unsafe { _mm_storeu_ps(out.as_mut_ptr(), x) };
        out
    }

    #[inline(always)]
    fn add4(self, a: __m128, b: __m128) -> __m128 {
        // SAFETY: `self` proves AVX-512VL.
        unsafe { _mm_add_ps(a, b) }
    }

    #[inline(always)]
    fn sub4(self, a: __m128, b: __m128) -> __m128 {
        // SAFETY: `self` proves AVX-512VL.
        unsafe { _mm_sub_ps(a, b) }
    }

    #[inline(always)]
    fn mul4(self, a: __m128, b: __m128) -> __m128 {
        // SAFETY: `self` proves AVX-512VL.
        unsafe { _mm_mul_ps(a, b) }
    }

    #[inline(always)]
    fn div4(self, a: __m128, b: __m128) -> __m128 {
        // SAFETY: `self` proves AVX-512VL.
        unsafe { _mm_div_ps(a, b) }
    }

    #[inline(always)]
    fn le8(self, a: __m256, b: __m256) -> u8 {
        // SAFETY: `self` proves AVX-512VL.
        unsafe { _mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b) }
    }

    #[inline(always)]
    fn le4(self, a: __m128, b: __m128) -> u8 {
        // SAFETY: `self` proves AVX-512VL.
        unsafe { _mm_cmp_ps_mask::<_CMP_LE_OQ>(a, b) }
    }

    #[inline(always)]
    fn eq4(self, a: __m128, b: __m128) -> u8 {
        // SAFETY: `self` proves AVX-512VL.
        unsafe { _mm_cmp_ps_mask::<_CMP_EQ_OQ>(a, b) }
    }
}
