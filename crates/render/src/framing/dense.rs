//! The dense interval of weighted values on an axis.
//!
//! The shortest interval that holds most of the weight finds the dense part whatever lies around it
//! (Rousseeuw and Leroy 1987, "Robust Regression and Outlier Detection", the shortest half). It
//! then grows while the density of what it grows into is comparable.

/// The smallest part of the weight that the dense interval holds.
const CORE: f64 = 0.6;
/// The step by which the dense interval grows to either side, relative to its length.
const STEP: f64 = 0.25;
/// The interval grows while the density of the step is this fraction of that of the core, or more.
const COMPARABLE: f64 = 0.25;

/// Values in ascending order, with the prefix sums of their weights.
struct Axis {
    values: Vec<f32>,
    before: Vec<f64>,
}

/// The dense interval of weighted values, of which there must be at least one.
pub(super) fn dense_interval(values: impl Iterator<Item = (f32, f64)>) -> (f32, f32) {
    let mut values: Vec<(f32, f64)> = values.collect();
    values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut before = vec![0.0];
    let mut total = 0.0;
    for value in &values {
        total += value.1;
        before.push(total);
    }
    let axis = Axis { values: values.into_iter().map(|value| value.0).collect(), before };
    let (mut low, mut high) = axis.shortest(CORE * total);
    let gain = COMPARABLE * CORE * STEP * total;
    // Each round adds at least `gain`, so the loop ends.
    loop {
        let step = ((f64::from(high) - f64::from(low)) * STEP) as f32;
        let (lower, higher) = (low - step, high + step);
        let (grows_down, grows_up) = (axis.weight(lower, low) >= gain, axis.weight(high, higher) >= gain);
        if gain <= 0.0 || step <= 0.0 || !(grows_down || grows_up) {
            return axis.trimmed(low, high);
        }
        low = if grows_down { lower } else { low };
        high = if grows_up { higher } else { high };
    }
}

impl Axis {
    /// The shortest interval with at least this weight.
    fn shortest(&self, weight: f64) -> (f32, f32) {
        let mut best = (self.values[0], self.values[self.values.len() - 1]);
        let mut end = 0;
        for start in 0..self.values.len() {
            end = end.max(start);
            while end < self.values.len() && self.before[end + 1] - self.before[start] < weight {
                end += 1;
            }
            if end == self.values.len() {
                break;
            }
            if self.values[end] - self.values[start] < best.1 - best.0 {
                best = (self.values[start], self.values[end]);
            }
        }
        best
    }

    /// The weight within an open interval.
    fn weight(&self, low: f32, high: f32) -> f64 {
        let start = self.values.partition_point(|&value| value <= low);
        let end = self.values.partition_point(|&value| value < high);
        if end > start { self.before[end] - self.before[start] } else { 0.0 }
    }

    /// Shrinks an interval to the values in it.
    fn trimmed(&self, low: f32, high: f32) -> (f32, f32) {
        let start = self.values.partition_point(|&value| value < low);
        let end = self.values.partition_point(|&value| value <= high);
        if end > start { (self.values[start], self.values[end - 1]) } else { (low, high) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dense_part_ignores_what_is_far_and_keeps_what_is_near() {
        let near = (0..1000).map(|i| (i as f32 * 0.01, 1.0));
        let (low, high) = dense_interval(near.clone());
        assert!((0.0..0.5).contains(&low) && (9.5..10.0).contains(&high), "{low} {high}");
        // A third of all weight, a thousand times as wide.
        let dome = (0..500).map(|i| (i as f32 * 40.0 - 10_000.0, 1.0));
        let (low, high) = dense_interval(near.chain(dome));
        assert!((-3.0..1.0).contains(&low) && (9.0..13.0).contains(&high), "{low} {high}");
        assert_eq!(dense_interval([(3.0, 1.0)].into_iter()), (3.0, 3.0));
        let (low, high) = dense_interval([(3.0, 0.0), (f32::MAX, 0.0), (-f32::MAX, 0.0)].into_iter());
        assert!(low <= high);
    }
}
