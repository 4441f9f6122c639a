//! Reproducible random numbers, which depend on a seed and a stream only.
//!
//! Each part of the race draws from a stream of its own, so that one more tree moves no spectator.
//!
//! Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number Generators" (SplitMix64).

/// A pseudorandom number generator.
pub(crate) struct Rng(u64);

impl Rng {
    /// The stream `stream` of a seed.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        let mut rng = Self(seed ^ stream.wrapping_mul(0xd6e8_feb8_6659_fd93));
        rng.bits();
        rng
    }

    /// 64 random bits.
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// In 0..1.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 24) as f32
    }

    /// In `low..high`.
    pub(crate) fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// In `0..count`.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f32) as usize).min(count.saturating_sub(1))
    }

    /// True with a probability.
    pub(crate) fn chance(&mut self, probability: f32) -> bool {
        self.unit() < probability
    }

    /// A colour whose channels all vary by the same random factor, at most `by` up or down.
    pub(crate) fn shade(&mut self, color: [f32; 3], by: f32) -> [f32; 3] {
        let factor = 1.0 + self.range(-by, by);
        color.map(|channel| (channel * factor).clamp(0.0, 1.0))
    }
}

/// The finalizer of SplitMix64: 64 bits in, 64 well-mixed bits out.
fn mix(mut bits: u64) -> u64 {
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

/// Smooth noise in -1..1 over the plane, features about one unit large; lattice values are mixed
/// from the seed.
pub(crate) fn noise(seed: u64, x: f32, y: f32) -> f32 {
    let (cell_x, cell_y) = (x.floor(), y.floor());
    let ease = |f: f32| f * f * (3.0 - 2.0 * f);
    let (fx, fy) = (ease(x - cell_x), ease(y - cell_y));
    let at = |dx: i64, dy: i64| {
        let (i, j) = (cell_x as i64 + dx, cell_y as i64 + dy);
        let bits =
            mix(seed ^ (i as u64).wrapping_mul(0x8da6_b343_9e37_79b9) ^ (j as u64).wrapping_mul(0xd816_3841_7f4a_7c15));
        (bits >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    };
    let low = at(0, 0) + (at(1, 0) - at(0, 0)) * fx;
    let high = at(0, 1) + (at(1, 1) - at(0, 1)) * fx;
    low + (high - low) * fy
}

/// Noise of several octaves, in about -1..1.
pub(crate) fn fractal(seed: u64, x: f32, y: f32, octaves: u32) -> f32 {
    let (mut sum, mut weight, mut frequency) = (0.0, 0.5, 1.0);
    for octave in 0..octaves {
        sum += weight * noise(seed.wrapping_add(u64::from(octave)), x * frequency, y * frequency);
        weight *= 0.5;
        frequency *= 2.03;
    }
    sum
}
