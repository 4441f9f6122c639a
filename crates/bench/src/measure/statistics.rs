//! Medians, and means of ratios with their bounds.

/// Median and range of some numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spread {
    /// The middle of the sorted numbers, or the mean of the two in the middle.
    pub(crate) median: f64,
    /// The smallest number.
    pub(crate) min: f64,
    /// The largest number.
    pub(crate) max: f64,
}

impl Spread {
    /// `None` if there are no numbers.
    pub(crate) fn of(numbers: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = numbers.into_iter().collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let (min, max) = (*sorted.first()?, *sorted.last()?);
        let (low, high) = (sorted[(sorted.len() - 1) / 2], sorted[sorted.len() / 2]);
        Some(Self { median: (low + high) / 2.0, min, max })
    }
}

/// Logarithms of a ratio, by process and by round. Times of the same round of the same process form
/// a pair.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct LogRatios(Vec<Vec<f64>>);

impl LogRatios {
    /// How many times faster the engine with the times `ours` is than the one with the times
    /// `others`, pair by pair.
    pub(crate) fn of_times(ours: &[Vec<f64>], others: &[Vec<f64>]) -> Self {
        let process = |(ours, others): (&Vec<f64>, &Vec<f64>)| {
            let pairs = ours.iter().zip(others).filter(|(a, b)| **a > 0.0 && **b > 0.0);
            pairs.map(|(ours, others)| (others / ours).ln()).collect()
        };
        Self(ours.iter().zip(others).map(process).collect())
    }

    /// The logarithms of one number from each process; numbers that are not positive are left out.
    pub(crate) fn of_processes(numbers: impl IntoIterator<Item = f64>) -> Self {
        let log = |number: f64| if number > 0.0 && number.is_finite() { vec![number.ln()] } else { Vec::new() };
        Self(numbers.into_iter().map(log).collect())
    }

    /// The mean over several cases: process by process if there are several, else round by round.
    pub(crate) fn mean_of(cases: &[&Self]) -> Self {
        let processes = cases.iter().map(|case| case.0.len()).min().unwrap_or(0);
        let average = |at: &dyn Fn(&Self) -> f64| cases.iter().map(|case| at(case)).sum::<f64>() / cases.len() as f64;
        if processes == 1 {
            let rounds = cases.iter().map(|case| case.0[0].len()).min().unwrap_or(0);
            return Self(vec![(0..rounds).map(|round| average(&|case| case.0[0][round])).collect()]);
        }
        let whole = |process: &usize| cases.iter().all(|case| !case.0[*process].is_empty());
        let process = |process: usize| vec![average(&|case| mean(&case.0[process]))];
        Self((0..processes).filter(whole).map(process).collect())
    }

    /// The ratio with its bounds; `None` if there are no measurements.
    pub(crate) fn ratio(&self) -> Option<Ratio> {
        let processes: Vec<&Vec<f64>> = self.0.iter().filter(|rounds| !rounds.is_empty()).collect();
        let samples = match processes.as_slice() {
            [] => return None,
            [rounds] => rounds.to_vec(),
            _ => processes.iter().map(|rounds| mean(rounds)).collect(),
        };
        let middle = mean(&samples);
        let bounds = (samples.len() > 1).then(|| {
            let freedom = samples.len() - 1;
            let variance = samples.iter().map(|x| (x - middle).powi(2)).sum::<f64>() / freedom as f64;
            let slack = student(freedom) * (variance / samples.len() as f64).sqrt();
            ((middle - slack).exp(), (middle + slack).exp())
        });
        Some(Ratio { mean: middle.exp(), bounds })
    }
}

/// The ratio of the times of two engines, paired round by round.
///
/// The bounds are Student's for the mean of logarithms. With several processes they are computed
/// from the means of the processes, since what differs between processes (the layout of memory) is
/// the same for all rounds of one; with a single process, from its rounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ratio {
    /// Geometric mean.
    pub(crate) mean: f64,
    /// The ratio exceeds the first with a probability of 95 %, and lies below the second with the
    /// same; `None` after a single measurement.
    pub(crate) bounds: Option<(f64, f64)>,
}

fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

/// The 95th percentile of Student's distribution (Student 1908, "The probable error of a mean").
fn student(freedom: usize) -> f64 {
    const TABLE: [f64; 12] = [6.314, 2.920, 2.353, 2.132, 2.015, 1.943, 1.895, 1.860, 1.833, 1.812, 1.796, 1.782];
    match freedom {
        0 => f64::INFINITY,
        1..=12 => TABLE[freedom - 1],
        // Within 0.003 of the exact value from here on.
        _ => 1.645 + 1.66 / freedom as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(Spread::of([]), None);
        assert_eq!(Spread::of([3.0]), Some(Spread { median: 3.0, min: 3.0, max: 3.0 }));
        assert_eq!(Spread::of([5.0, 1.0, 3.0]), Some(Spread { median: 3.0, min: 1.0, max: 5.0 }));
        assert_eq!(Spread::of([4.0, 1.0, 3.0, 2.0]).map(|spread| spread.median), Some(2.5));
    }

    #[test]
    fn a_drifting_clock_does_not_touch_a_paired_ratio() {
        let others: Vec<f64> = (1..10).map(f64::from).collect();
        let ours: Vec<f64> = others.iter().map(|time| time / 1.5).collect();
        let ratio = LogRatios::of_times(&[ours], &[others]).ratio().unwrap();
        let (lower, upper) = ratio.bounds.unwrap();
        assert!([ratio.mean, lower, upper].iter().all(|x| (x - 1.5).abs() < 1e-9), "{ratio:?}");
    }

    #[test]
    fn noise_widens_the_bounds_and_leaves_the_mean() {
        let others = [1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0];
        let ratio = LogRatios::of_times(&[vec![1.0; 8]], &[others.to_vec()]).ratio().unwrap();
        let (lower, upper) = ratio.bounds.unwrap();
        assert!((ratio.mean - 2.0_f64.sqrt()).abs() < 1e-9);
        // 1.895 times 0.1310, the standard error of the logarithms.
        assert!((lower - 2.0_f64.sqrt() * (-0.2482_f64).exp()).abs() < 1e-3, "{lower}");
        assert!((lower * upper - 2.0).abs() < 1e-9);
        assert_eq!(LogRatios::of_times(&[], &[]).ratio(), None);
    }

    #[test]
    fn what_differs_between_processes_is_not_averaged_away_by_many_rounds() {
        let ours = vec![vec![1.0; 100]; 3];
        let others = vec![vec![1.0; 100], vec![1.1; 100], vec![1.2; 100]];
        let (lower, upper) = LogRatios::of_times(&ours, &others).ratio().unwrap().bounds.unwrap();
        assert!(lower < 1.0 && upper > 1.2, "{lower} {upper}");
        assert_eq!(LogRatios::of_processes([2.0]).ratio().unwrap().bounds, None);
    }

    #[test]
    fn doubling_and_halving_cancel() {
        let [double, half] = [2.0, 0.5].map(|ratio| LogRatios::of_processes([ratio, ratio, ratio]));
        assert!((LogRatios::mean_of(&[&double, &half]).ratio().unwrap().mean - 1.0).abs() < 1e-12);
        let [double, half] = [2.0, 0.5].map(|ratio| LogRatios::of_times(&[vec![1.0, 1.0]], &[vec![ratio, ratio]]));
        assert!((LogRatios::mean_of(&[&double, &half]).ratio().unwrap().mean - 1.0).abs() < 1e-12);
        assert_eq!(LogRatios::mean_of(&[]).ratio(), None);
    }

    #[test]
    fn many_degrees_of_freedom_are_almost_normal() {
        for (freedom, exact) in [(13, 1.771), (20, 1.725), (30, 1.697), (100, 1.660)] {
            assert!((student(freedom) - exact).abs() < 0.004, "{freedom}");
        }
    }
}
