//! The words that AVX2 and AVX-512VL say alike.

/// Eight and four lanes, but for comparisons, within an `impl Isa` whose `self` proves AVX2 and FMA.
macro_rules! words_of_avx2 {
    () => {
        #[inline(always)]
        fn splat8(self, x: f32) -> __m256 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm256_set1_ps(x) }
        }

        #[inline(always)]
        fn load8(self, x: &[f32; 8]) -> __m256 {
            // SAFETY: `self` proves AVX2; eight floats are read from an array of eight.
            unsafe { _mm256_loadu_ps(x.as_ptr()) }
        }

        #[inline(always)]
        fn store8(self, x: __m256) -> [f32; 8] {
            let mut out = [0.0; 8];
            // SAFETY: `self` proves AVX2; eight floats are written to an array of eight.
            unsafe { _mm256_storeu_ps(out.as_mut_ptr(), x) };
            out
        }

        #[inline(always)]
        fn mul_sub8(self, a: __m256, b: __m256, c: __m256) -> __m256 {
            // SAFETY: `self` proves AVX2 and FMA.
            unsafe { _mm256_fmsub_ps(a, b, c) }
        }

        #[inline(always)]
        fn max8(self, a: __m256, b: __m256) -> __m256 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm256_max_ps(a, b) }
        }

        #[inline(always)]
        fn min8(self, a: __m256, b: __m256) -> __m256 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm256_min_ps(a, b) }
        }

        #[inline(always)]
        fn max_bits8(self, a: __m256, b: __m256) -> __m256 {
            // SAFETY: `self` proves AVX2. One cycle instead of four.
            unsafe { _mm256_castsi256_ps(_mm256_max_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b))) }
        }

        #[inline(always)]
        fn min_bits8(self, a: __m256, b: __m256) -> __m256 {
            // SAFETY: `self` proves AVX2. One cycle instead of four.
            unsafe { _mm256_castsi256_ps(_mm256_min_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b))) }
        }

        #[inline(always)]
        fn splat4(self, x: f32) -> __m128 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm_set1_ps(x) }
        }

        #[inline(always)]
        fn load4(self, x: &[f32; 4]) -> __m128 {
            // SAFETY: `self` proves AVX2; four floats are read from an array of four.
            unsafe { _mm_loadu_ps(x.as_ptr()) }
        }

        #[inline(always)]
        fn store4(self, x: __m128) -> [f32; 4] {
            let mut out = [0.0; 4];
            // SAFETY: `self` proves AVX2; four floats are written to an array of four.
            unsafe { _mm_storeu_ps(out.as_mut_ptr(), x) };
            out
        }

        #[inline(always)]
        fn add4(self, a: __m128, b: __m128) -> __m128 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm_add_ps(a, b) }
        }

        #[inline(always)]
        fn sub4(self, a: __m128, b: __m128) -> __m128 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm_sub_ps(a, b) }
        }

        #[inline(always)]
        fn mul4(self, a: __m128, b: __m128) -> __m128 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm_mul_ps(a, b) }
        }

        #[inline(always)]
        fn div4(self, a: __m128, b: __m128) -> __m128 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm_div_ps(a, b) }
        }
    };
}

pub(super) use words_of_avx2;
