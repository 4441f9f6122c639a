//! Drawing an index with given weights in constant time.
//!
//! Vose 1991, "A Linear Algorithm for Generating Random Numbers with a Given Distribution".

/// A set of indices, each with a probability. Always:
/// 1. probabilities sum to one, or there are none;
/// 2. an index whose weight was zero is never drawn.
#[derive(Debug, Default, Clone)]
pub(super) struct AliasTable {
    /// The part of a slot that belongs to its own index, and the index that the rest belongs to.
    slots: Vec<(f32, u32)>,
    probabilities: Vec<f32>,
}

impl AliasTable {
    /// From finite weights that are not negative. Without a positive weight, the table is empty.
    pub(super) fn new(weights: &[f64]) -> Self {
        let total: f64 = weights.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            return Self::default();
        }
        let count = weights.len();
        let mut share: Vec<f64> = weights.iter().map(|weight| weight / total * count as f64).collect();
        let probabilities = weights.iter().map(|weight| (weight / total) as f32).collect();
        let mut slots: Vec<(f32, u32)> = (0..count).map(|index| (1.0, index as u32)).collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..count).partition(|&index| share[index] < 1.0);
        while let (Some(&donor), Some(receiver)) = (large.last(), small.pop()) {
            slots[receiver] = (share[receiver] as f32, donor as u32);
            share[donor] -= 1.0 - share[receiver];
            if share[donor] < 1.0 {
                large.pop();
                small.push(donor);
            }
        }
        // Rounding may leave small shares without a large one to fill their slots. Such a share is
        // 1 but for rounding, unless its weight was zero: the slots of these go to the heaviest
        // index.
        let heaviest = (0..count).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or(0);
        for index in small {
            if share[index] < 0.5 {
                slots[index] = (share[index] as f32, heaviest as u32);
            }
        }
        Self { slots, probabilities }
    }

    /// Whether there is no index to draw.
    pub(super) fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// The probability of an index; zero for one that is not in the table.
    pub(super) fn probability(&self, index: usize) -> f32 {
        self.probabilities.get(index).copied().unwrap_or(0.0)
    }

    /// Draws an index: `bits` choose the slot, `u` in 0..1 the index within it. `None` when the
    /// table is empty.
    pub(super) fn draw(&self, bits: u32, u: f32) -> Option<usize> {
        let slot = ((u64::from(bits) * self.slots.len() as u64) >> 32) as usize;
        let &(own, other) = self.slots.get(slot)?;
        Some(if u < own { slot } else { other as usize })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::hash;

    #[test]
    fn indices_are_drawn_as_often_as_their_weights_say() {
        let weights = [1.0, 0.0, 5.0, 2.0, 0.0, 0.5, 1e-3];
        let total: f64 = weights.iter().sum();
        let table = AliasTable::new(&weights);
        let draws = 200_000;
        let mut counts = [0_u32; 7];
        for i in 0..draws {
            let u = (hash(i + draws) >> 8) as f32 / 16_777_216.0;
            counts[table.draw(hash(i), u).expect("not empty")] += 1;
        }
        for (index, &count) in counts.iter().enumerate() {
            let expected = weights[index] / total;
            assert!((f64::from(table.probability(index)) - expected).abs() < 1e-6);
            let deviation = (f64::from(draws) * expected * (1.0 - expected)).sqrt();
            assert!((f64::from(count) - f64::from(draws) * expected).abs() <= 5.0 * deviation, "{index}: {count}");
        }
    }

    #[test]
    fn no_weight_means_nothing_to_draw() {
        for weights in [&[][..], &[0.0, 0.0], &[f64::NAN], &[f64::INFINITY]] {
            let table = AliasTable::new(weights);
            assert!(table.is_empty() && table.draw(7, 0.5).is_none() && table.probability(0) < 1e-9);
        }
    }

    #[test]
    fn a_million_equal_weights_stay_equal() {
        let table = AliasTable::new(&vec![0.1; 1_000_000]);
        assert!((table.probability(999_999) - 1e-6).abs() < 1e-12);
        assert_eq!(table.draw(u32::MAX, 0.5), Some(999_999));
    }
}
