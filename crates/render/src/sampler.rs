//! The sampler of the path tracer: Owen-scrambled Sobol points, two dimensions at a time.
//!
//! Every pair of dimensions is the two-dimensional Sobol sequence, shuffled and scrambled by a hash
//! of seed, pixel and pair (padding). So the samples of a pixel are stratified in every pair,
//! pixels and pairs are decorrelated, and a number depends on seed, pixel, sample and pair only,
//! never on the thread.
//!
//! Burley 2020, "Practical Hash-based Owen Scrambling"; the hash is Vegdahl's variant of the one by
//! Laine and Karras.

/// The random numbers of one sample of one pixel.
#[derive(Debug, Clone)]
pub struct Sampler {
    /// Hash of seed and pixel.
    pixel: u32,
    /// Index of the sample within the pixel.
    index: u32,
    /// Index of the next pair of dimensions.
    pair: u32,
}

/// Pairs of dimensions reserved for a bounce.
const PAIRS_PER_BOUNCE: u32 = 10;
/// Pairs of dimensions reserved for the camera.
const PAIRS_OF_CAMERA: u32 = 2;

impl Sampler {
    /// For the sample with an index, of one pixel.
    pub fn new(seed: u64, pixel: [u32; 2], index: u32) -> Self {
        let seed = hash(seed as u32 ^ hash((seed >> 32) as u32 ^ 0x9e37_79b9));
        Self { pixel: combine(combine(seed, pixel[0]), pixel[1]), index, pair: 0 }
    }

    /// Jumps to the dimensions of a bounce, however many were used before, so that all paths of a
    /// pixel use the same dimensions for the same purpose. Bounce 0 is the hit of the camera ray.
    pub fn begin_bounce(&mut self, bounce: u32) {
        self.pair = PAIRS_OF_CAMERA.wrapping_add(bounce.wrapping_mul(PAIRS_PER_BOUNCE));
    }

    /// A number in 0..1.
    pub fn next_1d(&mut self) -> f32 {
        unit(self.next_bits()[0])
    }

    /// A point of the unit square, 0..1 in both axes.
    pub fn next_2d(&mut self) -> [f32; 2] {
        self.next_bits().map(unit)
    }

    /// A point of the unit square, with 32 bits per axis.
    pub fn next_bits(&mut self) -> [u32; 2] {
        let seed = combine(self.pixel, self.pair);
        self.pair = self.pair.wrapping_add(1);
        let index = scramble(self.index, seed);
        [
            scramble(index.reverse_bits(), hash(seed ^ 0x68bc_21eb)),
            scramble(second_sobol(index), hash(seed ^ 0x02e5_be93)),
        ]
    }

    /// A hash of pixel and sample, the same in all dimensions.
    pub fn salt(&self) -> u32 {
        combine(self.pixel, self.index)
    }
}

/// The upper 24 bits as a number in 0..1.
pub(crate) fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// The second dimension of the Sobol sequence, times 2^32.
///
/// Its matrix is Pascal's triangle modulo two, and a binomial coefficient `n` over `k` is odd
/// exactly if the bits of `k` are among those of `n` (Lucas 1878). So each bit of the point is the
/// parity of all bits of the index whose places contain its own, which takes one step for each of
/// the five bits of a place.
fn second_sobol(index: u32) -> u32 {
    let mut bits = index;
    bits ^= bits >> 16;
    bits ^= bits >> 8 & 0x00ff_00ff;
    bits ^= bits >> 4 & 0x0f0f_0f0f;
    bits ^= bits >> 2 & 0x3333_3333;
    bits ^= bits >> 1 & 0x5555_5555;
    bits.reverse_bits()
}

/// Owen scrambling: each bit is flipped depending on a hash of the bits above it.
fn scramble(value: u32, seed: u32) -> u32 {
    let mut x = value.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// An integer hash with full avalanche.
pub(crate) fn hash(value: u32) -> u32 {
    // Ettinger and Wellons 2018, "lowbias32".
    let mut x = value;
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// A hash of two numbers, in this order.
pub(crate) fn combine(first: u32, second: u32) -> u32 {
    hash(hash(first).wrapping_add(0x9e37_79b9) ^ second.wrapping_mul(0x85eb_ca6b))
}

/// A hash as a number in 0..1.
pub(crate) fn unit_hash(value: u32) -> f32 {
    unit(hash(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_power_of_two_of_samples_is_stratified() {
        for pair in 0..6 {
            // Of 64 samples each lies in a cell of its own: 64 x 1, 1 x 64, 8 x 8, and all shapes
            // between.
            for columns in [1_u32, 2, 4, 8, 16, 32, 64] {
                let rows = 64 / columns;
                let mut taken = [false; 64];
                for index in 0..64 {
                    let mut sampler = Sampler::new(7, [3, 5], index);
                    sampler.pair = pair;
                    let [x, y] = sampler.next_2d();
                    let cell = (x * columns as f32) as u32 * rows + (y * rows as f32) as u32;
                    assert!(!std::mem::replace(&mut taken[cell as usize], true), "pair {pair}, {columns} columns");
                }
            }
        }
    }

    #[test]
    fn the_second_dimension_is_that_of_its_direction_numbers() {
        let one_by_one = |mut index: u32| {
            let (mut point, mut direction) = (0, 1_u32 << 31);
            while index != 0 {
                point ^= if index & 1 != 0 { direction } else { 0 };
                index >>= 1;
                direction ^= direction >> 1;
            }
            point
        };
        for index in (0..1000).chain((0..32).map(|bit| 1 << bit)).chain((0..10_000).map(hash)) {
            assert_eq!(second_sobol(index), one_by_one(index), "{index:#x}");
        }
    }

    #[test]
    fn pixels_pairs_and_seeds_are_decorrelated() {
        let numbers = |seed, pixel, pair| {
            (0..256).map(move |index| {
                let mut sampler = Sampler::new(seed, pixel, index);
                sampler.pair = pair;
                sampler.next_1d() - 0.5
            })
        };
        let with = |seed, pixel, pair| {
            numbers(1, [0, 0], 0).zip(numbers(seed, pixel, pair)).map(|(a, b)| a * b).sum::<f32>() / 256.0 * 12.0
        };
        assert!(with(1, [0, 0], 0) > 0.9);
        // Means of 256 products whose deviation is one: five standard errors are 0.31.
        for (seed, pixel, pair) in
            [(2, [0, 0], 0), (1, [1, 0], 0), (1, [0, 1], 0), (1, [0, 0], 1), (1 << 40, [0, 0], 0)]
        {
            assert!(with(seed, pixel, pair).abs() < 0.31, "seed {seed}, pixel {pixel:?}, pair {pair}");
        }
    }

    #[test]
    fn a_bounce_has_its_own_dimensions_however_many_were_used_before() {
        let mut one = Sampler::new(1, [2, 3], 4);
        let mut other = one.clone();
        one.next_2d();
        one.begin_bounce(3);
        other.begin_bounce(3);
        assert_eq!(one.next_bits(), other.next_bits());
        one.begin_bounce(u32::MAX);
        one.next_2d();
    }
}
