//! One measured row.

use serde::{Deserialize, Serialize};

use crate::engine::{Class, Mode};
use crate::measure::clock::Elapsed;
use crate::measure::statistics::{LogRatios, Spread};
use crate::rays::Kind;

/// Names of the cases of growth begin so; the number of triangles follows.
pub(crate) const GROWTH: &str = "growth ";

/// What was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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

/// What numbers mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Unit {
    /// Million rays per second.
    #[serde(rename = "Mrays/s")]
    Rays,
    /// Milliseconds.
    #[serde(rename = "ms")]
    Time,
    /// Bytes per triangle.
    #[serde(rename = "bytes/triangle")]
    Bytes,
}

impl Unit {
    /// As written in tables and results.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Rays => "Mrays/s",
            Self::Time => "ms",
            Self::Bytes => "bytes/triangle",
        }
    }

    /// What so many seconds for so many rays are.
    fn of_seconds(self, seconds: f64, rays: usize) -> f64 {
        match self {
            Self::Rays => rays as f64 / seconds.max(1e-9) / 1e6,
            Self::Time | Self::Bytes => seconds * 1e3,
        }
    }
}

/// How many answers of an engine were not those of the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct WrongAnswers {
    /// Everywhere.
    pub(crate) all: usize,
    /// Of those, not at the edge of a triangle.
    pub(crate) elsewhere: usize,
}

/// Work per ray, where an engine counts it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct PerRay {
    pub(crate) nodes: f64,
    pub(crate) blocks: f64,
    pub(crate) triangles: f64,
    /// Of 64 bytes.
    pub(crate) lines: f64,
}

/// One engine, one thing measured, on one case.
#[derive(Debug, Clone, Serialize, Deserialize)]
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
    /// The instructions that the engine runs with, see
    /// [`Engine::instructions`](crate::engine::Engine::instructions).
    pub(crate) instructions: String,
    /// Whether the engine promises that no ray slips between triangles.
    pub(crate) robust: bool,
    /// How many threads worked.
    pub(crate) threads: usize,
    /// Of the numbers that follow.
    pub(crate) unit: Unit,
    /// Over all rounds, by the time of processors for one thread, by the wall for several.
    pub(crate) median: f64,
    /// The least.
    pub(crate) min: f64,
    /// The greatest.
    pub(crate) max: f64,
    /// What the tree was built for.
    pub(crate) class: Class,
    /// How many rays a round traces.
    pub(crate) count: usize,
    /// Seconds, by process and round.
    pub(crate) times: Vec<Vec<f64>>,
    /// The same by the wall, whatever the others are by.
    pub(crate) walls: Vec<Vec<f64>>,
    /// Of rays.
    pub(crate) wrong_answers: Option<WrongAnswers>,
    /// Of rays.
    pub(crate) work: Option<PerRay>,
}

/// What readers of results are given of a row.
#[derive(Serialize)]
struct Published<'a> {
    case: &'a str,
    /// Which all engines of the run were forced to that can be.
    level: &'a str,
    engine: &'a str,
    instructions: &'a str,
    metric: Metric,
    rays: Option<Kind>,
    mode: Option<Mode>,
    robust: bool,
    threads: usize,
    unit: Unit,
    median: f64,
    min: f64,
    max: f64,
}

impl<'a> Published<'a> {
    fn of(row: &'a Row, level: &'a str) -> Self {
        let &Row { ref case, ref engine, ref instructions, metric, rays, mode, robust, threads, unit, .. } = row;
        let &Row { median, min, max, .. } = row;
        Self { case, level, engine, instructions, metric, rays, mode, robust, threads, unit, median, min, max }
    }
}

/// All rows of a run at a level, as a JSON array.
///
/// # Errors
/// Those of the serializer; rows have nothing that it refuses.
pub(crate) fn json(rows: &[Row], level: &str) -> Result<String, serde_json::Error> {
    let rows: Vec<Published<'_>> = rows.iter().map(|row| Published::of(row, level)).collect();
    serde_json::to_string_pretty(&rows)
}

impl Row {
    /// Whether it is one of ours.
    pub(crate) fn is_kinetree(&self) -> bool {
        self.engine.starts_with("kinetree")
    }

    /// Fills in what the rounds of this process took; nothing comes of no rounds.
    pub(crate) fn with_times(mut self, times: &[Elapsed]) -> Option<Self> {
        let walls: Vec<f64> = times.iter().map(|elapsed| elapsed.wall).collect();
        let processor = times.iter().map(|elapsed| elapsed.processor).collect();
        self.times = vec![if self.threads == 1 { processor } else { walls.clone() }];
        self.walls = vec![walls];
        self.sum_up().then_some(self)
    }

    /// Adds the rounds of process number `process` of the same row.
    pub(crate) fn join(&mut self, other: Self, process: usize) {
        self.times.resize(process, Vec::new());
        self.walls.resize(process, Vec::new());
        self.times.extend(other.times);
        self.walls.extend(other.walls);
        self.sum_up();
    }

    /// Whether there is anything to sum up.
    fn sum_up(&mut self) -> bool {
        let seconds = self.times.iter().flatten();
        let Some(spread) = Spread::of(seconds.map(|time| self.unit.of_seconds(*time, self.count))) else {
            return false;
        };
        (self.median, self.min, self.max) = (spread.median, spread.min, spread.max);
        true
    }

    /// The middle of all rounds, seconds.
    pub(crate) fn seconds(&self) -> f64 {
        Spread::of(self.times.iter().flatten().copied()).map_or(f64::INFINITY, |spread| spread.median)
    }

    /// Whether both are the same row, of different processes.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        let key = |row: &Self| (row.metric, row.rays, row.mode, row.robust, row.threads);
        (&self.case, &self.engine) == (&other.case, &other.engine) && key(self) == key(other)
    }

    /// Whether both are about the same question, and may stand side by side.
    pub(crate) fn is_comparable(&self, other: &Self) -> bool {
        let batch = |row: &Self| row.mode.is_some_and(|mode| mode != Mode::Single);
        (&self.case, self.metric, self.rays, self.threads) == (&other.case, other.metric, other.rays, other.threads)
            && batch(self) == batch(other)
    }

    /// Whether the other is its rival: the same kind of tree and, for rays, the same promise about
    /// edges.
    pub(crate) fn is_rival(&self, other: &Self) -> bool {
        self.class == other.class && (self.robust == other.robust || self.metric != Metric::Trace)
    }

    /// Whether the other is what a user of another engine would do with the same rays: one call
    /// each, where nobody else takes batches.
    fn is_substitute(&self, other: &Self) -> bool {
        let rays_without_batches = self.mode == Some(Mode::Batch) && self.rays == Some(Kind::DiffuseShuffled);
        let same = (&self.case, self.metric, self.rays, self.threads)
            == (&other.case, other.metric, other.rays, other.threads);
        rays_without_batches && same
    }

    /// How it does against the fastest of those that `who` picks among comparable engines of
    /// others: its row, and the paired ratio.
    pub(crate) fn against<'a>(&self, rows: &'a [Self], who: impl Fn(&Self) -> bool) -> Option<(&'a Self, LogRatios)> {
        let others = rows.iter().filter(|row| {
            !row.is_kinetree()
                && !row.times.is_empty()
                && (self.is_comparable(row) || self.is_substitute(row))
                && who(row)
        });
        let best = others.min_by(|a, b| a.seconds().total_cmp(&b.seconds()))?;
        Some((best, LogRatios::of_times(&self.times, &best.times)))
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
        instructions: "avx2".into(),
        robust,
        threads: 1,
        unit: Unit::Rays,
        median: 0.0,
        min: 0.0,
        max: 0.0,
        class,
        count: 1_000_000,
        times: Vec::new(),
        walls: Vec::new(),
        wrong_answers: None,
        work: None,
    };
    let times: Vec<Elapsed> = times.iter().map(|time| Elapsed { wall: *time, processor: *time }).collect();
    row.with_times(&times).expect("there are times")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_the_fields_that_readers_of_results_rely_on() {
        let text = json(&[example("kinetree", Class::Fast, true, &[0.5, 0.25, 1.0])], "scalar").unwrap();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let row = &value[0];
        let wanted = [
            ("case", serde_json::json!("race")),
            ("level", serde_json::json!("scalar")),
            ("engine", serde_json::json!("kinetree")),
            ("instructions", serde_json::json!("avx2")),
            ("metric", serde_json::json!("trace")),
            ("rays", serde_json::json!("primary")),
            ("mode", serde_json::json!("single")),
            ("robust", serde_json::json!(true)),
            ("threads", serde_json::json!(1)),
            ("unit", serde_json::json!("Mrays/s")),
            ("median", serde_json::json!(2.0)),
            ("min", serde_json::json!(1.0)),
            ("max", serde_json::json!(4.0)),
        ];
        for (field, value) in &wanted {
            assert_eq!(row[field], *value, "{field}");
        }
        assert_eq!(row.as_object().unwrap().len(), wanted.len());
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
        let against = |who: &dyn Fn(&Row) -> bool| {
            let (best, log_ratios) = ours.against(&rows, who).unwrap();
            (best.engine.as_str(), log_ratios.ratio().unwrap().mean)
        };
        let (name, ratio) = against(&|_| true);
        assert!(name == "embree medium" && (ratio - 1.5).abs() < 1e-9);
        let (name, ratio) = against(&|row| ours.is_rival(row));
        assert!(name == "embree medium robust" && (ratio - 2.0).abs() < 1e-9);
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

    #[test]
    fn rounds_of_a_process_that_missed_a_row_do_not_shift_the_others() {
        let mut row = example("kinetree", Class::Fast, true, &[1.0]);
        row.join(example("kinetree", Class::Fast, true, &[3.0, 5.0]), 2);
        assert_eq!(row.times, [vec![1.0], vec![], vec![3.0, 5.0]]);
        assert_eq!((row.median, row.max), (1.0 / 3.0, 1.0));
    }
}
