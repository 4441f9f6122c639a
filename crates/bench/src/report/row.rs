//! One measured row.

use serde::Serialize;

use crate::engine::{Class, Mode};
use crate::measure::statistics::{Ratio, Spread};
use crate::rays::Kind;

/// What was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Metric {
    /// Rays through a tree.
    Trace,
    /// From triangles to a tree that can be traced.
    Build,
    /// From new vertices to a tree that can be traced.
    Refit,
    /// From new transforms to a tree over instances.
    #[allow(dead_code)]
    TopLevel,
    /// Of the finished tree.
    Memory,
    /// The most at a time while it was built.
    PeakMemory,
}

/// One engine, one thing measured, on one case.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Row {
    /// The case.
    pub(crate) case: String,
    /// Name and settings; those of ours begin with `kinetree`.
    pub(crate) engine: String,
    /// What was measured.
    pub(crate) metric: Metric,
    /// Which rays; none but for traces.
    pub(crate) rays: Option<Kind>,
    /// How rays were handed over; none but for traces.
    pub(crate) mode: Option<Mode>,
    /// Whether the engine promises that no ray slips between triangles.
    pub(crate) robust: bool,
    /// How many threads worked.
    pub(crate) threads: usize,
    /// Of the numbers that follow.
    pub(crate) unit: &'static str,
    /// Over the rounds, by the time of processors for one thread, by the wall for several.
    pub(crate) median: f64,
    /// The least.
    pub(crate) min: f64,
    /// The greatest.
    pub(crate) max: f64,
    /// The median by the wall, whatever the others are by.
    pub(crate) wall: f64,
    /// What the tree was built for.
    #[serde(skip)]
    pub(crate) class: Class,
    /// Seconds, round by round.
    #[serde(skip)]
    pub(crate) times: Vec<f64>,
}

impl Row {
    /// Whether it is one of ours.
    pub(crate) fn is_ours(&self) -> bool {
        self.engine.starts_with("kinetree")
    }

    /// Fills the numbers: `value` makes one of seconds.
    pub(crate) fn with_times(mut self, times: Vec<f64>, walls: &[f64], value: impl Fn(f64) -> f64) -> Option<Self> {
        let spread = Spread::of(&times.iter().map(|time| value(*time)).collect::<Vec<_>>())?;
        self.wall = value(Spread::of(walls)?.median);
        (self.median, self.min, self.max) = (spread.median, spread.min, spread.max);
        self.times = times;
        Some(self)
    }

    /// Whether both are about the same question, and may stand side by side.
    pub(crate) fn is_comparable(&self, other: &Self) -> bool {
        let batch = |row: &Self| row.mode.is_some_and(|mode| mode != Mode::Single);
        (&self.case, self.metric, self.rays, self.threads) == (&other.case, other.metric, other.rays, other.threads)
            && batch(self) == batch(other)
    }

    /// Whether the other is its rival: the same kind of tree and, for rays, the same promise about edges.
    pub(crate) fn is_rival(&self, other: &Self) -> bool {
        self.class == other.class && (self.robust == other.robust || self.metric != Metric::Trace)
    }

    /// Whether the other is what a user of another engine would do with the same rays: one call each, where nobody else takes batches.
    fn is_substitute(&self, other: &Self) -> bool {
        let rays_without_batches = self.mode == Some(Mode::Batch) && self.rays == Some(Kind::DiffuseShuffled);
        let same = (&self.case, self.metric, self.rays, self.threads)
            == (&other.case, other.metric, other.rays, other.threads);
        rays_without_batches && same
    }

    /// How it does against the fastest of those that `who` picks among comparable engines of others: its name, and the ratio.
    pub(crate) fn against<'a>(&self, rows: &'a [Self], who: impl Fn(&Self) -> bool) -> Option<(&'a str, Ratio)> {
        let others = rows.iter().filter(|row| {
            !row.is_ours() && !row.times.is_empty() && (self.is_comparable(row) || self.is_substitute(row)) && who(row)
        });
        let time = |row: &Self| Spread::of(&row.times).map_or(f64::INFINITY, |spread| spread.median);
        let best = others.min_by(|a, b| time(a).total_cmp(&time(b)))?;
        Some((best.engine.as_str(), Ratio::of_times(&self.times, &best.times)?))
    }
}

#[cfg(test)]
pub(crate) fn example(engine: &str, class: Class, robust: bool, times: &[f64]) -> Row {
    let row = Row {
        case: "race".into(),
        engine: engine.into(),
        metric: Metric::Trace,
        rays: Some(Kind::Primary),
        mode: Some(Mode::Single),
        robust,
        threads: 1,
        unit: "Mrays/s",
        median: 0.0,
        min: 0.0,
        max: 0.0,
        wall: 0.0,
        class,
        times: Vec::new(),
    };
    row.with_times(times.to_vec(), times, |time| 1.0 / time).expect("there are times")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_the_fields_that_readers_of_results_rely_on() {
        let json = serde_json::to_value([example("kinetree", Class::Fast, true, &[0.5, 0.25, 1.0])]).unwrap();
        let row = &json[0];
        for (field, value) in [
            ("case", serde_json::json!("race")),
            ("engine", serde_json::json!("kinetree")),
            ("metric", serde_json::json!("trace")),
            ("rays", serde_json::json!("primary")),
            ("mode", serde_json::json!("single")),
            ("robust", serde_json::json!(true)),
            ("threads", serde_json::json!(1)),
            ("unit", serde_json::json!("Mrays/s")),
            ("median", serde_json::json!(2.0)),
            ("min", serde_json::json!(1.0)),
            ("max", serde_json::json!(4.0)),
        ] {
            assert_eq!(row[field], value, "{field}");
        }
    }

    #[test]
    fn ours_is_held_against_the_fastest_other() {
        let ours = example("kinetree", Class::Fast, true, &[1.0, 1.0]);
        let rows = [
            ours.clone(),
            example("embree medium", Class::Fast, false, &[1.5, 1.5]),
            example("embree medium robust", Class::Fast, true, &[2.0, 2.0]),
            example("kinetree fast", Class::Fast, false, &[0.1, 0.1]),
            example("slow", Class::Fast, true, &[9.0]),
        ];
        let (name, ratio) = ours.against(&rows, |_| true).unwrap();
        assert_eq!((name, ratio.mean), ("embree medium", 1.5));
        let (name, ratio) = ours.against(&rows, |row| ours.is_rival(row)).unwrap();
        assert_eq!((name, ratio.mean), ("embree medium robust", 2.0));
    }

    #[test]
    fn batches_of_shuffled_rays_are_held_against_single_calls_and_others_are_not() {
        for (rays, found) in [(Kind::DiffuseShuffled, true), (Kind::Primary, false)] {
            let ours = example("kinetree", Class::Fast, true, &[1.0]);
            let ours = Row { rays: Some(rays), mode: Some(Mode::Batch), ..ours };
            let other = Row { rays: Some(rays), ..example("embree", Class::Fast, true, &[2.0]) };
            assert_eq!(ours.against(&[other], |_| true).is_some(), found);
        }
    }
}
