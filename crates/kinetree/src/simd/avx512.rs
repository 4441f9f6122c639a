//! The same eight lanes with mask registers and twice as many registers: AVX-512VL.

use std::arch::x86_64::*;

use super::x86::{operations_of_avx2, register};
use super::{Isa, Kernel, Lanes, Row};

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

register! {
    Avx512, __m128, [f32; 4],
    _mm_set1_ps, _mm_loadu_ps, _mm_storeu_ps, _mm_add_ps, _mm_sub_ps, _mm_mul_ps, _mm_div_ps,
    _mm_fmsub_ps, _mm_fmadd_ps, _mm_fnmadd_ps, _mm_max_ps, _mm_min_ps,
    |x| _mm_andnot_ps(_mm_set1_ps(-0.0), x), |a, b| _mm_cmp_ps_mask::<_CMP_LE_OQ>(a, b).into()
}

register! {
    Avx512, __m256, [f32; 8],
    _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps, _mm256_div_ps,
    _mm256_fmsub_ps, _mm256_fmadd_ps, _mm256_fnmadd_ps, _mm256_max_ps, _mm256_min_ps,
    |x| _mm256_andnot_ps(_mm256_set1_ps(-0.0), x), |a, b| _mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b).into()
}

register! {
    Avx512, __m512, Row,
    _mm512_set1_ps, _mm512_load_ps, _mm512_store_ps, _mm512_add_ps, _mm512_sub_ps, _mm512_mul_ps, _mm512_div_ps,
    _mm512_fmsub_ps, _mm512_fmadd_ps, _mm512_fnmadd_ps, _mm512_max_ps, _mm512_min_ps,
    |x| _mm512_abs_ps(x), |a, b| _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b).into()
}

impl Isa for Avx512 {
    type F8 = __m256;
    type F4 = __m128;
    type F16 = __m512;

    operations_of_avx2!();

    #[inline(always)]
    fn zip_u64(self, upper: __m256, lower: &[u32; 8]) -> [u64; 8] {
        let mut out = [0; 8];
        // SAFETY: `self` proves AVX-512F; eight words are read from an array of eight, and eight
        // numbers written to one of eight.
        unsafe {
            let order = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
            let lower = _mm512_castsi256_si512(_mm256_loadu_si256(lower.as_ptr().cast()));
            let upper = _mm512_castsi256_si512(_mm256_castps_si256(upper));
            _mm512_storeu_si512(out.as_mut_ptr().cast(), _mm512_permutex2var_epi32(lower, order, upper));
        }
        out
    }

    #[inline(always)]
    fn load3(self, x: &[f32; 3]) -> __m128 {
        // SAFETY: `self` proves AVX-512VL; a lane that is masked out is not read, so only the three
        // of the array are.
        unsafe { _mm_maskz_loadu_ps(0b111, x.as_ptr()) }
    }

    #[inline(always)]
    fn blend_prefix(self, count: u32, a: __m128, rest: __m128) -> __m128 {
        // SAFETY: `self` proves AVX-512VL.
        unsafe { _mm_mask_blend_ps(((1_u32 << (count & 7)) - 1) as u8, rest, a) }
    }

    #[inline(always)]
    fn eq(self, a: __m512, b: __m512) -> u32 {
        // SAFETY: `self` proves AVX-512F.
        unsafe { _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(a, b) }.into()
    }

    #[inline(always)]
    fn store_masked(self, to: &mut Row, mask: u32, x: __m512) {
        // SAFETY: `self` proves AVX-512F; only floats of the row are written, which is aligned to
        // 64 bytes.
        unsafe { _mm512_mask_store_ps(to.0.as_mut_ptr(), mask as u16, x) };
    }
}
