//! Every level computes what the scalar one does, to the bit.

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

struct Operations;

impl Kernel for Operations {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Vec<u32> {
        let nan = f32::NAN;
        let (a, b) = ([1.5, -2.0, nan, 0.1, 7.0, -0.0, 1e30, 3.0], [2.0, -3.0, 4.0, nan, 7.0, 0.0, 1e-30, -3.0]);
        let (x, y): (I::F8, I::F8) = (isa.load(&a), isa.load(&b));
        let mut out: Vec<u32> = vec![isa.le(x, y)];
        let (zero, past) =
            (isa.splat(0.0), isa.load(&[0.0, 1e-40, -0.0, -1.0, f32::INFINITY, nan, -f32::INFINITY, 1.0]));
        let after_all = isa.splat(f32::from_bits(f32::INFINITY.to_bits() + 1));
        for v in [isa.min_bits(past, after_all), isa.min_bits(after_all, past), isa.max_bits(past, zero)] {
            out.extend(isa.store(v).iter().map(|x| x.to_bits()));
        }
        let flipped = isa.xor_sign(past, &[1 << 31, 0, 1 << 31, 0, 1 << 31, 0, 1 << 31, 1 << 31]);
        out.extend(isa.store(flipped).map(f32::to_bits));
        let from = out.len();
        out.extend([isa.lt_bits(zero, past), isa.lt_bits(isa.splat(f32::INFINITY), past)]);
        assert_eq!(out[from..], [0b1011_0010, 0b0010_0000]);
        out.extend(isa.store(isa.max(x, y)).iter().map(|x| x.to_bits()));
        out.extend(isa.store(isa.min(x, y)).iter().map(|x| x.to_bits()));
        out.extend(isa.store(isa.mul_sub(isa.splat(2.0), y, isa.splat(1.0))).iter().map(|x| u32::from(x.is_nan())));
        let (x, y): (I::F4, I::F4) = (isa.load(&[1.0, 2.0, 0.3, nan]), isa.load(&[3.0, 2.0, 0.7, 1.0]));
        for v in [isa.add(x, y), isa.sub(x, y), isa.mul(x, y), isa.div(x, y), isa.splat(0.1)] {
            out.extend(isa.store(v)[..3].iter().map(|x| x.to_bits()));
        }
        for v in [isa.max(x, y), isa.abs(isa.sub(isa.splat(0.0), y)), isa.mul_sub(x, y, y)] {
            out.extend(isa.store(v)[..2].iter().map(|x| x.to_bits()));
        }
        for v in
            [isa.largest_of_three(y), isa.largest_of_three(isa.load(&[-3.0, 1.0, -0.0, 8.0])), isa.with_last(x, 7.0)]
        {
            out.extend(isa.store(v).iter().map(|x| x.to_bits()));
        }
        for v in [isa.permute(y, &[2, 0, 1, 3]), isa.spread4::<0>(y), isa.spread4::<2>(y), isa.spread4::<3>(y)] {
            out.extend(isa.store(v).map(f32::to_bits));
        }
        let of_permuted = out.len() - 16;
        assert_eq!(
            out[of_permuted..],
            [0.7, 3.0, 2.0, 1.0, 3.0, 3.0, 3.0, 3.0, 0.7, 0.7, 0.7, 0.7, 1.0, 1.0, 1.0, 1.0_f32].map(f32::to_bits)
        );
        assert_eq!(isa.first(y), 3.0);
        let sum: I::F8 =
            isa.mul_add(isa.splat(2.0), isa.load(&[0.5, 1.0, -3.0, 0.0, 4.0, 5.0, 6.0, 7.0]), isa.splat(1.0));
        assert_eq!(isa.store(sum), [2.0, 3.0, -5.0, 1.0, 9.0, 11.0, 13.0, 15.0]);
        let joined =
            isa.zip_u64(isa.load(&[0.0, -0.0, 1.0, 2.0, -3.0, 0.5, 1e30, -1e-40]), &[7, 6, 5, 4, 3, 2, 1, u32::MAX]);
        out.extend(joined.iter().flat_map(|both| [(both >> 32) as u32, *both as u32]));
        out.push(isa.signs(isa.load(&[-0.0, 1.0, -2.0, 0.0])));
        for v in [isa.spread8::<0>(x), isa.spread8::<1>(x), isa.spread8::<2>(x), isa.spread8::<3>(y)] {
            out.extend(isa.store(v).iter().map(|x| x.to_bits()));
        }
        out.push(isa.le(x, y));
        out.extend(isa.store(isa.load_elementwise(&[-0.0, 1.5, nan, 3.0])).map(f32::to_bits));
        out.extend(operations_on_boxes(isa));
        let wide = |four: [f32; 4]| Row([four; 4].concat().try_into().expect("sixteen"));
        let (x, y): (I::F16, I::F16) =
            (isa.load(&wide([1.0, -2.0, 0.3, nan])), isa.load(&wide([3.0, -2.0, -0.7, 1.0])));
        for v in [isa.add(x, y), isa.sub(x, y), isa.mul(x, y), isa.div(x, y), isa.splat(0.1)] {
            out.extend(isa.store(v).0.iter().map(|x| if x.is_nan() { 1 } else { x.to_bits() }));
        }
        for v in [isa.max(x, y), isa.min(x, y), isa.mul_sub(isa.splat(2.0), y, isa.splat(1.0))] {
            out.extend(isa.store(v).0.iter().map(|x| x.to_bits()));
        }
        out.extend([isa.le(x, y), isa.eq(x, y)]);
        // Rounded twice, both would come out as zero.
        let (near_one, square) = (1.0 + f32::EPSILON, 1.0 + 2.0 * f32::EPSILON);
        for v in [
            isa.fused(isa.splat(near_one), isa.splat(near_one), isa.splat(-square)),
            isa.abs(isa.fused_less(isa.splat(near_one), isa.splat(near_one), isa.splat(square))),
        ] {
            assert_eq!(isa.store::<I::F16>(v).0, [f32::EPSILON * f32::EPSILON; 16]);
        }
        for v in [
            isa.fused(isa.splat(near_one), isa.splat(near_one), isa.splat(-square)),
            isa.abs(isa.fused_less(isa.splat(near_one), isa.splat(near_one), isa.splat(square))),
        ] {
            assert_eq!(isa.store::<I::F4>(v), [f32::EPSILON * f32::EPSILON; 4]);
        }
        let mut place = Row([7.0; 16]);
        isa.store_masked(&mut place, 0b1010_0000_0011_0001, y);
        out.extend(place.0.iter().map(|x| x.to_bits()));
        out
    }
}

/// All arithmetic on one width, NaN as 1; `mul_sub` and `mul_add` of numbers whose products are
/// exact.
#[inline(always)]
fn arithmetic<I: Isa, V: Lanes<I>>(isa: I, [a, b, exact]: [&V::Array; 3]) -> Vec<u32>
where
    V::Array: bytemuck::NoUninit,
{
    let (a, b, exact): (V, V, V) = (isa.load(a), isa.load(b), isa.load(exact));
    let two = isa.splat(2.0);
    let results = [
        isa.add(a, b),
        isa.sub(a, b),
        isa.mul(a, b),
        isa.div(a, b),
        isa.mul_sub(exact, two, two),
        isa.mul_add(exact, two, two),
        isa.fused(a, b, a),
        isa.fused_less(a, b, a),
        isa.max(a, b),
        isa.max(b, a),
        isa.min(a, b),
        isa.min(b, a),
        isa.abs(a),
    ];
    let mut out = vec![isa.le(a, b), isa.le(b, a), isa.le(a, a)];
    for result in results {
        let stored = isa.store(result);
        let bits: &[u32] = bytemuck::cast_slice(bytemuck::bytes_of(&stored));
        out.extend(bits.iter().map(|&bits| if f32::from_bits(bits).is_nan() { 1 } else { bits }));
    }
    out
}

struct Arithmetic;

impl Kernel for Arithmetic {
    type Output = [Vec<u32>; 3];

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> [Vec<u32>; 3] {
        let nan = f32::NAN;
        let a = [1.5, -2.0, nan, 0.1, 7.0, -0.0, 1e30, 3.0, 0.0, -1e-40, 0.3, nan, -7.5, 1e-30, 2.0, f32::INFINITY];
        let b = [2.0, -3.0, 4.0, nan, 7.0, 0.0, 1e30, -3.0, -0.0, 1e-40, 0.7, nan, 0.1, -1e30, f32::INFINITY, 0.0];
        let exact = [0.5, 1.0, -3.0, 0.0, 4.0, 5.0, 6.0, 7.0, 8.0, -9.0, 1.25, 11.0, 12.0, 13.0, 14.0, 15.0];
        let rows = [&Row(a), &Row(b), &Row(exact)];
        let fours: [&[f32; 4]; 3] = rows.map(|row| row.0.first_chunk().expect("sixteen"));
        let eights: [&[f32; 8]; 3] = rows.map(|row| row.0.first_chunk().expect("sixteen"));
        [arithmetic::<I, I::F4>(isa, fours), arithmetic::<I, I::F8>(isa, eights), arithmetic::<I, I::F16>(isa, rows)]
    }
}

#[test]
fn every_level_computes_the_same_bits_in_every_width() {
    let expected = Level(Kind::Scalar(Scalar)).run(Arithmetic);
    for level in Level::available() {
        assert_eq!(level.run(Arithmetic), expected, "{level:?}");
    }
}

/// The operations that boxes are made with.
#[inline(always)]
fn operations_on_boxes<I: Isa>(isa: I) -> Vec<u32> {
    let nan = f32::NAN;
    let mut out = Vec::new();
    let a: I::F8 = isa.load(&[1.5, -2.0, 3.0, 0.1, 7.0, -0.0, 1e30, f32::INFINITY]);
    let b: I::F8 = isa.load(&[2.0, -3.0, 4.0, 0.3, 7.0, 0.0, 1e30, 1.0]);
    let links = [0, 1 << 28, 7 << 28, 5 << 28 | 12, u32::MAX, 3, 1 << 31, 0x3fff_ffff];
    for v in [isa.add(a, b), isa.sub(a, b), isa.mul(a, b), isa.extract_bits::<28, 7>(&links)] {
        out.extend(isa.store(v).iter().map(|x| x.to_bits()));
    }
    let (x, y): (I::F4, I::F4) = (isa.load(&[1.0, -0.0, nan, 0.3]), isa.load(&[-3.0, 0.0, 0.7, nan]));
    for v in [isa.max(x, y), isa.max(y, x), isa.min(x, y), isa.min(y, x), isa.load3(&[0.1, -0.2, 1e30])] {
        out.extend(isa.store(v).iter().map(|x| x.to_bits()));
    }
    for count in 0..=4 {
        out.extend(isa.store(isa.blend_prefix(count, x, y)).iter().map(|x| x.to_bits()));
    }
    let row = |i: i32| isa.load(&[i as f32, i as f32 + 0.25, i as f32 + 0.5, i as f32 + 0.75]);
    for column in isa.transpose([row(0), row(1), row(2), row(3)]) {
        out.extend(isa.store(column).iter().map(|x| x.to_bits()));
    }
    for row in isa.transpose_xyz(&[row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7)]) {
        out.extend(isa.store(row).iter().map(|x| x.to_bits()));
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
            assert_eq!(isa.store(x), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
            assert_eq!(isa.store(y), [10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0, 17.0]);
            assert_eq!(isa.store(z), [20.0, 21.0, 22.0, 23.0, 24.0, 25.0, 26.0, 27.0]);
            let [x, y, z, w] = isa.transpose([points[0], points[1], points[2], points[3]]);
            assert_eq!(isa.store(x), [0.0, 1.0, 2.0, 3.0]);
            assert_eq!(isa.store(y), [10.0, 11.0, 12.0, 13.0]);
            assert_eq!(isa.store(z), [20.0, 21.0, 22.0, 23.0]);
            assert_eq!(isa.store(w), [0.0; 4]);
            let links = [1 << 28, 2 << 28, 7 << 28, 15 << 28, 9, 0, u32::MAX, 8 << 28];
            assert_eq!(isa.store(isa.extract_bits::<28, 7>(&links)), [1.0, 2.0, 7.0, 7.0, 0.0, 0.0, 7.0, 0.0]);
            assert_eq!(isa.store(isa.blend_prefix(3, x, y)), [0.0, 1.0, 2.0, 13.0]);
        }
    }
    for level in Level::available() {
        level.run(Shapes);
    }
}

#[test]
fn every_level_computes_the_same_bits() {
    let expected = Level(Kind::Scalar(Scalar)).run(Operations);
    for level in Level::available() {
        assert_eq!(level.run(Operations), expected, "{level:?}");
    }
}
/// Every pattern of lanes, through every operation that makes or takes a mask.
struct Masks;

impl Kernel for Masks {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        for mask in 0..=0xffff_u32 {
            let lanes: [f32; 16] = std::array::from_fn(|lane| if mask >> lane & 1 == 1 { 1.0 } else { f32::NAN });
            let first = |count: usize| mask & ((1 << count) - 1);
            let row: I::F16 = isa.load(&Row(lanes));
            assert_eq!([isa.le(row, row), isa.eq(row, isa.splat(1.0))], [mask; 2]);
            let eight: I::F8 = isa.load(lanes.first_chunk().expect("sixteen"));
            assert_eq!(isa.le(eight, eight), first(8));
            let four: I::F4 = isa.load(lanes.first_chunk().expect("sixteen"));
            assert_eq!(isa.le(four, four), first(4));
            let mut place = Row([3.0; 16]);
            isa.store_masked(&mut place, mask, isa.splat(5.0));
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
            let (x, y) = (isa.load(&numbers), isa.load(&others));
            let (larger, smaller) = (isa.store(isa.max_bits(x, y)), isa.store(isa.min_bits(x, y)));
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
