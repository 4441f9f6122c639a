//! What AVX2 and AVX-512 have in common.

/// One of eight words, by a jump to the load of it. In assembly, or the compiler would make one
/// load of all eight.
#[inline(always)]
pub(super) fn predicted(words: &[u32; 8], number: usize) -> u32 {
    macro_rules! arms {
        ($($at:literal)*) => {
            match number & 7 {
                $($at => {
                    let word: u32;
                    // SAFETY: one of eight words is read.
                    unsafe {
                        std::arch::asm!(
                            concat!("mov {word:e}, dword ptr [{words} + 4 * ", $at, "]"),
                            word = out(reg) word,
                            words = in(reg) words.as_ptr(),
                            options(pure, readonly, nostack, preserves_flags),
                        );
                    }
                    word
                })*
                _ => words[0],
            }
        };
    }
    arms!(0 1 2 3 4 5 6 7)
}

/// The arithmetic of a register, by the instructions named; `le` is written out.
macro_rules! register {
    (
        $isa:ty, $register:ty, $array:ty,
        $splat:ident, $load:ident, $store:ident, $add:ident, $sub:ident, $mul:ident, $div:ident,
        $fmsub:ident, $fmadd:ident, $fnmadd:ident, $max:ident, $min:ident,
        |$x:ident| $abs:expr, |$a:ident, $b:ident| $le:expr
    ) => {
        impl Lanes<$isa> for $register {
            type Array = $array;

            #[inline(always)]
            fn splat(_: $isa, x: f32) -> Self {
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $splat(x) }
            }

            #[inline(always)]
            fn load(_: $isa, x: &$array) -> Self {
                // SAFETY: as above; as many floats are read as the array has, which is aligned as
                // the instruction demands.
                unsafe { $load((&raw const *x).cast()) }
            }

            #[inline(always)]
            fn store(self, _: $isa) -> $array {
                let mut out: $array = bytemuck::Zeroable::zeroed();
                // SAFETY: as above; as many floats are written as the array has, which is aligned
                // as the instruction demands.
                unsafe { $store((&raw mut out).cast(), self) };
                out
            }

            #[inline(always)]
            fn add(self, _: $isa, b: Self) -> Self {
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $add(self, b) }
            }

            #[inline(always)]
            fn sub(self, _: $isa, b: Self) -> Self {
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $sub(self, b) }
            }

            #[inline(always)]
            fn mul(self, _: $isa, b: Self) -> Self {
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $mul(self, b) }
            }

            #[inline(always)]
            fn div(self, _: $isa, b: Self) -> Self {
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $div(self, b) }
            }

            #[inline(always)]
            fn mul_sub(self, _: $isa, b: Self, c: Self) -> Self {
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $fmsub(self, b, c) }
            }

            #[inline(always)]
            fn mul_add(self, _: $isa, b: Self, c: Self) -> Self {
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $fmadd(self, b, c) }
            }

            #[inline(always)]
            fn fused(self, _: $isa, b: Self, c: Self) -> Self {
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $fmadd(self, b, c) }
            }

            #[inline(always)]
            fn fused_less(self, _: $isa, b: Self, c: Self) -> Self {
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $fnmadd(self, b, c) }
            }

            #[inline(always)]
            fn max(self, _: $isa, b: Self) -> Self {
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $max(self, b) }
            }

            #[inline(always)]
            fn min(self, _: $isa, b: Self) -> Self {
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $min(self, b) }
            }

            #[inline(always)]
            fn abs(self, _: $isa) -> Self {
                let $x = self;
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $abs }
            }

            #[inline(always)]
            fn le(self, _: $isa, b: Self) -> u32 {
                let ($a, $b) = (self, b);
                // SAFETY: the level proves that the processor has the instruction.
                unsafe { $le }
            }
        }
    };
}

/// What AVX2 and AVX-512 have in common, within an `impl Isa` whose `self` proves AVX2.
macro_rules! operations_of_avx2 {
    () => {
        #[inline(always)]
        fn xor_sign(self, x: __m256, signs: &[u32; 8]) -> __m256 {
            let signs: &[f32; 8] = bytemuck::cast_ref(signs);
            // SAFETY: `self` proves AVX2; and there are eight lanes to read.
            unsafe { _mm256_xor_ps(x, _mm256_loadu_ps(signs.as_ptr())) }
        }

        #[inline(always)]
        fn max_bits(self, a: __m256, b: __m256) -> __m256 {
            // SAFETY: `self` proves AVX2. One cycle instead of four.
            unsafe { _mm256_castsi256_ps(_mm256_max_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b))) }
        }

        #[inline(always)]
        fn min_bits(self, a: __m256, b: __m256) -> __m256 {
            // SAFETY: `self` proves AVX2. One cycle instead of four.
            unsafe { _mm256_castsi256_ps(_mm256_min_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b))) }
        }

        #[inline(always)]
        fn lt_bits(self, a: __m256, b: __m256) -> u32 {
            // SAFETY: `self` proves AVX2. Two cycles sooner than a comparison of floats.
            unsafe {
                let before = _mm256_cmpgt_epi32(_mm256_castps_si256(b), _mm256_castps_si256(a));
                _mm256_movemask_ps(_mm256_castsi256_ps(before)) as u32
            }
        }

        #[inline(always)]
        fn load_elementwise(self, x: &[f32; 4]) -> __m128 {
            // Volatile, or the compiler makes one load of the four.
            // SAFETY: `self` proves AVX2; each is read from a reference to it.
            unsafe {
                let [x, y, z, w] = [&raw const x[0], &raw const x[1], &raw const x[2], &raw const x[3]];
                _mm_setr_ps(x.read_volatile(), y.read_volatile(), z.read_volatile(), w.read_volatile())
            }
        }

        #[inline(always)]
        fn largest_of_three(self, x: __m128) -> __m128 {
            // SAFETY: `self` proves AVX2. Sizes order like their bits.
            unsafe {
                let x = _mm_castps_si128(_mm_andnot_ps(_mm_set1_ps(-0.0), x));
                let (y, z) = (_mm_shuffle_epi32::<0b01_01_01_01>(x), _mm_shuffle_epi32::<0b10_10_10_10>(x));
                let x = _mm_shuffle_epi32::<0b00_00_00_00>(x);
                _mm_castsi128_ps(_mm_max_epi32(x, _mm_max_epi32(y, z)))
            }
        }

        #[inline(always)]
        fn first(self, x: __m128) -> f32 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm_cvtss_f32(x) }
        }

        #[inline(always)]
        fn permute(self, x: __m128, order: &[u32; 4]) -> __m128 {
            // SAFETY: `self` proves AVX2; four words are read from an array of four.
            unsafe { _mm_permutevar_ps(x, _mm_loadu_si128(order.as_ptr().cast())) }
        }

        #[inline(always)]
        fn spread4<const LANE: i32>(self, x: __m128) -> __m128 {
            // SAFETY: `self` proves AVX2.
            unsafe {
                match LANE & 3 {
                    0 => _mm_shuffle_ps::<0b00_00_00_00>(x, x),
                    1 => _mm_shuffle_ps::<0b01_01_01_01>(x, x),
                    2 => _mm_shuffle_ps::<0b10_10_10_10>(x, x),
                    _ => _mm_shuffle_ps::<0b11_11_11_11>(x, x),
                }
            }
        }

        #[inline(always)]
        fn signs(self, x: __m128) -> u32 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm_movemask_ps(x) as u32 }
        }

        #[inline(always)]
        fn with_last(self, x: __m128, last: f32) -> __m128 {
            // SAFETY: `self` proves AVX2.
            unsafe { _mm_insert_ps::<0b00_11_0000>(x, _mm_set_ss(last)) }
        }

        #[inline(always)]
        fn spread8<const LANE: i32>(self, x: __m128) -> __m256 {
            // SAFETY: `self` proves AVX2.
            unsafe {
                let x = match LANE & 3 {
                    0 => x,
                    1 => _mm_shuffle_ps::<0b01_01_01_01>(x, x),
                    2 => _mm_shuffle_ps::<0b10_10_10_10>(x, x),
                    _ => _mm_shuffle_ps::<0b11_11_11_11>(x, x),
                };
                _mm256_broadcastss_ps(x)
            }
        }

        #[inline(always)]
        fn extract_bits<const SHIFT: i32, const MASK: u32>(self, words: &[u32; 8]) -> __m256 {
            // SAFETY: `self` proves AVX2; eight words are read from an array of eight.
            unsafe {
                let words = _mm256_srli_epi32::<SHIFT>(_mm256_loadu_si256(words.as_ptr().cast()));
                _mm256_cvtepi32_ps(_mm256_and_si256(words, _mm256_set1_epi32(MASK as i32)))
            }
        }

        #[inline(always)]
        fn predicted(self, words: &[u32; 8], number: usize) -> u32 {
            super::x86::predicted(words, number)
        }

        #[inline(always)]
        fn prefetch<T>(self, items: &[T], at: usize) {
            let item = items.as_ptr().wrapping_add(at).cast::<i8>();
            for line in 0..size_of::<T>().div_ceil(64) {
                // SAFETY: prefetching is harmless at any address, and the address is made without
                // any claim that something is there.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(item.wrapping_add(64 * line)) }
            }
        }

        #[inline(always)]
        fn transpose_xyz(self, points: &[__m128; 8]) -> [__m256; 3] {
            // SAFETY: `self` proves AVX2.
            unsafe {
                let [a, b, c, d] = [
                    _mm256_set_m128(points[4], points[0]),
                    _mm256_set_m128(points[5], points[1]),
                    _mm256_set_m128(points[6], points[2]),
                    _mm256_set_m128(points[7], points[3]),
                ];
                let (xy_ab, xy_cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
                let (zw_ab, zw_cd) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
                [
                    _mm256_shuffle_ps::<0b01_00_01_00>(xy_ab, xy_cd),
                    _mm256_shuffle_ps::<0b11_10_11_10>(xy_ab, xy_cd),
                    _mm256_shuffle_ps::<0b01_00_01_00>(zw_ab, zw_cd),
                ]
            }
        }

        #[inline(always)]
        fn transpose(self, rows: [__m128; 4]) -> [__m128; 4] {
            let [a, b, c, d] = rows;
            // SAFETY: `self` proves AVX2.
            unsafe {
                let (xy_ab, xy_cd) = (_mm_unpacklo_ps(a, b), _mm_unpacklo_ps(c, d));
                let (zw_ab, zw_cd) = (_mm_unpackhi_ps(a, b), _mm_unpackhi_ps(c, d));
                [
                    _mm_movelh_ps(xy_ab, xy_cd),
                    _mm_movehl_ps(xy_cd, xy_ab),
                    _mm_movelh_ps(zw_ab, zw_cd),
                    _mm_movehl_ps(zw_cd, zw_ab),
                ]
            }
        }
    };
}

pub(super) use {operations_of_avx2, register};
