//! The time that a quick run may take, and how it is shared out: by what has been measured so far, not by guesses.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// A quick run is to be over by then: five minutes, less what the last part may take too long.
const QUICK: Duration = Duration::from_secs(255);

/// What is left, and how fast engines build.
pub(crate) struct Budget {
    ends: Option<Instant>,
    /// Seconds per triangle: the fewest and the most so far.
    pace: BTreeMap<String, (f64, f64)>,
}

impl Budget {
    /// For a quick run, or without end.
    pub(crate) fn new(quick: bool) -> Self {
        Self { ends: quick.then(|| Instant::now() + QUICK), pace: BTreeMap::new() }
    }

    /// Seconds for a part that weighs as much as `weight` of `all` that is still to come; infinite without end.
    pub(crate) fn share(&self, weight: f64, all: f64) -> f64 {
        let left = |ends: Instant| ends.saturating_duration_since(Instant::now()).as_secs_f64();
        self.ends.map_or(f64::INFINITY, |ends| left(ends) * weight / all.max(weight))
    }

    /// An engine has built so many triangles in so many seconds.
    pub(crate) fn record_build(&mut self, engine: &str, triangles: usize, seconds: f64) {
        let each = seconds / triangles.max(1) as f64;
        let (least, most) = self.pace.entry(engine.to_owned()).or_insert((each, each));
        (*least, *most) = (least.min(each), most.max(each));
    }

    /// How long a build is going to take, seconds, halfway between what it took at best and at worst; nothing, where nothing is known.
    pub(crate) fn expected_seconds(&self, engine: &str, triangles: usize) -> f64 {
        self.pace.get(engine).map_or(0.0, |(least, most)| (least * most).sqrt() * triangles as f64)
    }
}

/// What the budget knows an engine's build by, without what comes before and after it.
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
