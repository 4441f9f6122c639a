//! The time that a quick run may take, shared out by the build times that have been measured so
//! far.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// When the last part of a quick run begins at the latest: five minutes, less a reserve for that
/// part.
const QUICK: Duration = Duration::from_secs(255);

/// The time that is left, and the build times of engines.
pub(crate) struct Budget {
    ends: Option<Instant>,
    /// The least and the most seconds per triangle so far, by engine.
    pace: BTreeMap<String, (f64, f64)>,
}

impl Budget {
    /// The budget of a quick run, or an unlimited one.
    pub(crate) fn new(quick: bool) -> Self {
        Self { ends: quick.then(|| Instant::now() + QUICK), pace: BTreeMap::new() }
    }

    /// Seconds for a part with this weight, out of `all` the weights that are still to come;
    /// infinite if the budget is unlimited.
    pub(crate) fn share(&self, weight: f64, all: f64) -> f64 {
        let left = |ends: Instant| ends.saturating_duration_since(Instant::now()).as_secs_f64();
        self.ends.map_or(f64::INFINITY, |ends| left(ends) * weight / all.max(weight))
    }

    /// Records how long an engine took to build.
    pub(crate) fn record_build(&mut self, engine: &str, triangles: usize, seconds: f64) {
        let each = seconds / triangles.max(1) as f64;
        let (least, most) = self.pace.entry(engine.to_owned()).or_insert((each, each));
        (*least, *most) = (least.min(each), most.max(each));
    }

    /// The predicted time of a build, seconds: the geometric mean of the best and the worst pace so
    /// far; 0 if the engine has not built yet.
    pub(crate) fn expected_seconds(&self, engine: &str, triangles: usize) -> f64 {
        self.pace.get(engine).map_or(0.0, |(least, most)| (least * most).sqrt() * triangles as f64)
    }
}

/// The key of an engine's build time without preparation and checks.
pub(crate) fn build_only_key(engine: &str) -> String {
    format!("{engine}, the build alone")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_shared_by_weight_and_builds_are_predicted() {
        let mut budget = Budget::new(true);
        let (third, all) = (budget.share(1.0, 3.0), budget.share(3.0, 3.0));
        assert!((84.0..=85.0).contains(&third) && (254.0..=255.0).contains(&all), "{third} {all}");
        assert_eq!(Budget::new(false).share(1.0, 9.0), f64::INFINITY);
        budget.record_build("slow", 1000, 2.0);
        budget.record_build("slow", 1000, 0.5);
        budget.record_build("slow", 1000, 1.0);
        assert_eq!((budget.expected_seconds("slow", 3000), budget.expected_seconds("other", 3000)), (3.0, 0.0));
    }
}
