//! The same eight lanes with mask registers and twice as many registers: AVX-512VL.

use std::arch::x86_64::*;
use std::mem::MaybeUninit;

use super::x86::words_of_avx2;
use super::{Isa, Kernel, Row};

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
    type F16 = __m512;

    words_of_avx2!();

    /// One or two children, as most steps have, are told apart by branches; more are sorted by `order`, without any.
    ///
    /// The branchless part after Fuetterling et al. 2017, "Accelerated Single Ray Tracing for Wide Vector Units".
    #[inline(always)]
    fn choose(
        self,
        entry: __m256,
        exit: __m256,
        in_use: u8,
        links: &[u32; 8],
        order: u32,
        room: &mut [MaybeUninit<u64>; 8],
    ) -> (usize, u32) {
        let hit = self.le8(entry, exit) & in_use;
        let rest = hit & hit.wrapping_sub(1);
        let first = hit.trailing_zeros() as usize & 7;
        if rest == 0 {
            return (usize::from(hit != 0), links[first]);
        }
        if rest & rest.wrapping_sub(1) == 0 {
            let distances = self.store8(entry);
            let second = rest.trailing_zeros() as usize & 7;
            let one = u64::from(distances[first].to_bits()) << 32 | u64::from(links[first]);
            let other = u64::from(distances[second].to_bits()) << 32 | u64::from(links[second]);
            room[7].write(one.max(other));
            return (2, one.min(other) as u32);
        }
        // SAFETY: `self` proves AVX-512VL. Eight links are read from an array of eight; of the eight entries, the first `count` are written to the last `count`
        // places of eight.
        unsafe {
            let shifts = _mm256_setr_epi32(21, 18, 15, 12, 9, 6, 3, 0);
            // Permutations read the lowest three bits only. From near to far here, so that the nearest comes out lowest.
            let lanes = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), shifts);
            let entry = _mm256_permutexvar_ps(lanes, entry);
            let links = _mm256_permutexvar_epi32(lanes, _mm256_loadu_si256(links.as_ptr().cast()));
            let hit = _mm256_movepi32_mask(_mm256_permutexvar_epi32(lanes, _mm256_movm_epi32(hit)));
            let count = hit.count_ones() as usize;
            let distances = _mm512_slli_epi64::<32>(_mm512_cvtepu32_epi64(_mm256_castps_si256(entry)));
            let entries = _mm512_or_si512(distances, _mm512_cvtepu32_epi64(links));
            let entries = _mm512_maskz_compress_epi64(hit, entries);
            let written = ((1_u32 << count) - 1) as u8;
            _mm512_mask_storeu_epi64(room.as_mut_ptr().add(8 - count).cast(), written, entries);
            (count, _mm_cvtsi128_si32(_mm512_castsi512_si128(entries)) as u32)
        }
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

    #[inline(always)]
    fn splat16(self, x: f32) -> __m512 {
        // SAFETY: `self` proves AVX-512F.
        unsafe { _mm512_set1_ps(x) }
    }

    #[inline(always)]
    fn load16(self, x: &Row) -> __m512 {
        // SAFETY: `self` proves AVX-512F; sixteen floats are read from a row of sixteen, which is aligned to 64 bytes.
        unsafe { _mm512_load_ps(x.0.as_ptr()) }
    }

    #[inline(always)]
    fn store16(self, x: __m512) -> Row {
        let mut out = Row([0.0; 16]);
        // SAFETY: `self` proves AVX-512F; sixteen floats are written to a row of sixteen, which is aligned to 64 bytes.
        unsafe { _mm512_store_ps(out.0.as_mut_ptr(), x) };
        out
    }

    #[inline(always)]
    fn add16(self, a: __m512, b: __m512) -> __m512 {
        // SAFETY: `self` proves AVX-512F.
        unsafe { _mm512_add_ps(a, b) }
    }

    #[inline(always)]
    fn sub16(self, a: __m512, b: __m512) -> __m512 {
        // SAFETY: `self` proves AVX-512F.
        unsafe { _mm512_sub_ps(a, b) }
    }

    #[inline(always)]
    fn mul16(self, a: __m512, b: __m512) -> __m512 {
        // SAFETY: `self` proves AVX-512F.
        unsafe { _mm512_mul_ps(a, b) }
    }

    #[inline(always)]
    fn div16(self, a: __m512, b: __m512) -> __m512 {
        // SAFETY: `self` proves AVX-512F.
        unsafe { _mm512_div_ps(a, b) }
    }

    #[inline(always)]
    fn mul_sub16(self, a: __m512, b: __m512, c: __m512) -> __m512 {
        // SAFETY: `self` proves AVX-512F.
        unsafe { _mm512_fmsub_ps(a, b, c) }
    }

    #[inline(always)]
    fn max16(self, a: __m512, b: __m512) -> __m512 {
        // SAFETY: `self` proves AVX-512F.
        unsafe { _mm512_max_ps(a, b) }
    }

    #[inline(always)]
    fn min16(self, a: __m512, b: __m512) -> __m512 {
        // SAFETY: `self` proves AVX-512F.
        unsafe { _mm512_min_ps(a, b) }
    }

    #[inline(always)]
    fn le16(self, a: __m512, b: __m512) -> u16 {
        // SAFETY: `self` proves AVX-512F.
        unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b) }
    }

    #[inline(always)]
    fn eq16(self, a: __m512, b: __m512) -> u16 {
        // SAFETY: `self` proves AVX-512F.
        unsafe { _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(a, b) }
    }

    #[inline(always)]
    fn keep16(self, place: &mut Row, mask: u16, x: __m512) {
        // SAFETY: `self` proves AVX-512F; only floats of the row are written, which is aligned to 64 bytes.
        unsafe { _mm512_mask_store_ps(place.0.as_mut_ptr(), mask, x) };
    }
}
