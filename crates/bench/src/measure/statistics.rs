//! From many measurements to few numbers.

use crate::chance::Chance;

/// The middle and the ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spread {
    /// As many are smaller as are larger.
    pub(crate) median: f64,
    /// The least.
    pub(crate) min: f64,
    /// The greatest.
    pub(crate) max: f64,
}

impl Spread {
    /// Of some numbers; `None` of none.
    pub(crate) fn of(numbers: &[f64]) -> Option<Self> {
        let mut sorted = numbers.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let (min, max) = (*sorted.first()?, *sorted.last()?);
        let (low, high) = (sorted[(sorted.len() - 1) / 2], sorted[sorted.len() / 2]);
        Some(Self { median: (low + high) / 2.0, min, max })
    }
}

/// A ratio of two engines, paired round by round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ratio {
    /// Geometric mean over the rounds.
    pub(crate) mean: f64,
    /// It is larger than this with a chance of 95 %.
    pub(crate) lower: f64,
}

/// How often the rounds are drawn anew.
const DRAWS: usize = 2000;

impl Ratio {
    /// How many times faster the one with the times `ours` is than the one with the times `theirs`; the rounds that both have count. The bound
    /// is a bootstrap: rounds are drawn with replacement, and one mean in twenty lies below it (Efron 1979).
    pub(crate) fn of_times(ours: &[f64], theirs: &[f64]) -> Option<Self> {
        let pairs = ours.iter().zip(theirs).filter(|(a, b)| **a > 0.0 && **b > 0.0);
        let logs: Vec<f64> = pairs.map(|(ours, theirs)| (theirs / ours).ln()).collect();
        if logs.is_empty() {
            return None;
        }
        let mean = |total: f64| (total / logs.len() as f64).exp();
        let mut chance = Chance::new(1, logs.len() as u64);
        let mut means: Vec<f64> =
            (0..DRAWS).map(|_| mean((0..logs.len()).map(|_| logs[chance.below(logs.len())]).sum())).collect();
        means.sort_unstable_by(f64::total_cmp);
        Some(Self { mean: mean(logs.iter().sum()), lower: means[DRAWS / 20] })
    }
}

/// The geometric mean of positive numbers; `None` of none.
pub(crate) fn geometric_mean(numbers: &[f64]) -> Option<f64> {
    let total: f64 = numbers.iter().map(|x| x.ln()).sum();
    (!numbers.is_empty()).then(|| (total / numbers.len() as f64).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(Spread::of(&[]), None);
        assert_eq!(Spread::of(&[3.0]), Some(Spread { median: 3.0, min: 3.0, max: 3.0 }));
        assert_eq!(Spread::of(&[5.0, 1.0, 3.0]), Some(Spread { median: 3.0, min: 1.0, max: 5.0 }));
        assert_eq!(Spread::of(&[4.0, 1.0, 3.0, 2.0]).map(|spread| spread.median), Some(2.5));
    }

    #[test]
    fn a_drifting_clock_does_not_touch_a_paired_ratio() {
        let theirs: Vec<f64> = (1..10).map(f64::from).collect();
        let ours: Vec<f64> = theirs.iter().map(|time| time / 1.5).collect();
        let ratio = Ratio::of_times(&ours, &theirs).unwrap();
        assert!((ratio.mean - 1.5).abs() < 1e-9 && (ratio.lower - 1.5).abs() < 1e-9);
    }

    #[test]
    fn noise_lowers_the_bound_and_not_the_mean() {
        let ours = [1.0; 8];
        let theirs = [1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0];
        let ratio = Ratio::of_times(&ours, &theirs).unwrap();
        assert!((ratio.mean - 2.0_f64.sqrt()).abs() < 1e-9);
        assert!((1.05..1.40).contains(&ratio.lower), "{}", ratio.lower);
        assert_eq!(Ratio::of_times(&[], &theirs), None);
    }

    #[test]
    fn doubling_and_halving_cancel() {
        assert!((geometric_mean(&[2.0, 0.5]).unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(geometric_mean(&[]), None);
    }
}
