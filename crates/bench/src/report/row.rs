//! A row of results: one measurement of one engine.

use serde::{Deserialize, Serialize};

use crate::engine::{Class, Mode};
use crate::measure::clock::Elapsed;
use crate::measure::statistics::{LogRatios, Spread};
use crate::rays::RayKind;

/// Begins the names of the cases of the growth series; the number of triangles follows.
pub(crate) const GROWTH: &str = "growth ";

/// What was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Metric {
    /// Tracing rays.
    Trace,
    /// Building a tree from triangles.
    Build,
    /// Refitting a tree to new vertices.
    Refit,
    /// Building a tree over instances from new transforms.
    #[allow(dead_code)]
    TopLevel,
    /// Memory of the finished tree.
    Memory,
    /// Peak memory of the build.
    PeakMemory,
}

/// The unit of a row's numbers.
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
    /// The name in tables and results.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Rays => "Mrays/s",
            Self::Time => "ms",
            Self::Bytes => "bytes/triangle",
        }
    }

    /// Converts a time for a number of rays into this unit.
    fn of_seconds(self, seconds: f64, rays: usize) -> f64 {
        match self {
            Self::Rays => rays as f64 / seconds.max(1e-9) / 1e6,
            Self::Time | Self::Bytes => seconds * 1e3,
        }
    }
}

/// The number of wrong answers of an engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct WrongAnswers {
    /// All wrong answers.
    pub(crate) all: usize,
    /// Those of them that are not at the edge of a triangle.
    pub(crate) elsewhere: usize,
}

/// Work per ray, if the engine counts it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct PerRay {
    pub(crate) nodes: f64,
    pub(crate) blocks: f64,
    pub(crate) triangles: f64,
    /// Cache lines of 64 bytes.
    pub(crate) lines: f64,
}

/// One measurement of one engine in one case.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Row {
    /// The name of the case.
    pub(crate) case: String,
    /// Name and settings; the names of kinetree's settings begin with `kinetree`.
    pub(crate) engine: String,
    /// What was measured.
    pub(crate) metric: Metric,
    /// The kind of rays, for traces.
    pub(crate) rays: Option<RayKind>,
    /// How rays were handed over, for traces.
    pub(crate) mode: Option<Mode>,
    /// The instructions that the engine uses, see
    /// [`Engine::instructions`](crate::engine::Engine::instructions).
    pub(crate) instructions: String,
    /// Whether the engine promises watertight hits.
    pub(crate) robust: bool,
    /// The number of threads.
    pub(crate) threads: usize,
    /// The unit of the following numbers.
    pub(crate) unit: Unit,
    /// The median over all rounds: of processor time for one thread, of wall-clock time for
    /// several.
    pub(crate) median: f64,
    /// The smallest number.
    pub(crate) min: f64,
    /// The largest number.
    pub(crate) max: f64,
    /// The kind of tree.
    pub(crate) class: Class,
    /// The number of rays of a round.
    pub(crate) count: usize,
    /// The seconds from which the numbers above are computed, by process and round.
    pub(crate) times: Vec<Vec<f64>>,
    /// Wall-clock seconds, by process and round.
    pub(crate) walls: Vec<Vec<f64>>,
    /// Wrong answers, for traces.
    pub(crate) wrong_answers: Option<WrongAnswers>,
    /// Work per ray, for traces.
    pub(crate) work: Option<PerRay>,
}

impl Row {
    /// Whether this is a row of kinetree.
    pub(crate) fn is_kinetree(&self) -> bool {
        self.engine.starts_with("kinetree")
    }

    /// The row with the times of this process; `None` if there are none.
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

    /// Computes median and range from the times; `false` if there are none.
    fn sum_up(&mut self) -> bool {
        let seconds = self.times.iter().flatten();
        let Some(spread) = Spread::of(seconds.map(|time| self.unit.of_seconds(*time, self.count))) else {
            return false;
        };
        (self.median, self.min, self.max) = (spread.median, spread.min, spread.max);
        true
    }

    /// The median over all rounds, seconds.
    pub(crate) fn seconds(&self) -> f64 {
        Spread::of(self.times.iter().flatten().copied()).map_or(f64::INFINITY, |spread| spread.median)
    }

    /// Whether both are the same measurement, of different processes.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        let key = |row: &Self| (row.metric, row.rays, row.mode, row.robust, row.threads);
        (&self.case, &self.engine) == (&other.case, &other.engine) && key(self) == key(other)
    }

    /// Whether both measure the same job, so that they stand in the same table.
    pub(crate) fn is_comparable(&self, other: &Self) -> bool {
        let batch = |row: &Self| row.mode.is_some_and(|mode| mode != Mode::Single);
        (&self.case, self.metric, self.rays, self.threads) == (&other.case, other.metric, other.rays, other.threads)
            && batch(self) == batch(other)
    }

    /// Whether the other is a rival: the same class of tree and, for rays, the same promise about
    /// edges.
    pub(crate) fn is_rival(&self, other: &Self) -> bool {
        self.class == other.class && (self.robust == other.robust || self.metric != Metric::Trace)
    }

    /// Whether the other shows how another engine traces rays for which kinetree takes a batch: by
    /// single calls, since it has no batches for such rays.
    fn is_substitute(&self, other: &Self) -> bool {
        let rays_without_batches = self.mode == Some(Mode::Batch) && self.rays == Some(RayKind::DiffuseShuffled);
        let same = (&self.case, self.metric, self.rays, self.threads)
            == (&other.case, other.metric, other.rays, other.threads);
        rays_without_batches && same
    }

    /// The fastest comparable row of another engine that `accepts` accepts, and the paired ratio.
    pub(crate) fn against<'a>(
        &self,
        rows: &'a [Self],
        accepts: impl Fn(&Self) -> bool,
    ) -> Option<(&'a Self, LogRatios)> {
        let others = rows.iter().filter(|row| {
            !row.is_kinetree()
                && !row.times.is_empty()
                && (self.is_comparable(row) || self.is_substitute(row))
                && accepts(row)
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
        rays: Some(RayKind::Primary),
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
    fn kinetree_is_compared_with_the_fastest_other_engine() {
        let ours = example("kinetree", Class::Fast, true, &[1.0, 1.0]);
        let rows = [
            ours.clone(),
            example("embree medium", Class::Fast, false, &[1.5, 1.5]),
            example("embree medium robust", Class::Fast, true, &[2.0, 2.0]),
            example("kinetree fast", Class::Fast, false, &[0.1, 0.1]),
            example("slow", Class::Fast, true, &[9.0]),
        ];
        let against = |accepts: &dyn Fn(&Row) -> bool| {
            let (best, log_ratios) = ours.against(&rows, accepts).unwrap();
            (best.engine.as_str(), log_ratios.ratio().unwrap().mean)
        };
        let (name, ratio) = against(&|_| true);
        assert!(name == "embree medium" && (ratio - 1.5).abs() < 1e-9);
        let (name, ratio) = against(&|row| ours.is_rival(row));
        assert!(name == "embree medium robust" && (ratio - 2.0).abs() < 1e-9);
    }

    #[test]
    fn only_batches_of_shuffled_rays_are_compared_with_single_calls() {
        for (rays, found) in [(RayKind::DiffuseShuffled, true), (RayKind::Primary, false)] {
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
