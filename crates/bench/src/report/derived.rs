//! Figures computed from several rows: tracing speed of a tree, scaling, time to image, growth.

use std::collections::BTreeMap;

use super::goal::CaseRatio;
use super::record::Record;
use super::row::{GROWTH, Metric, Row};
use crate::engine::Mode;
use crate::measure::statistics::{LogRatios, Spread};
use crate::rays::RayKind;

/// The rays of a picture, a third of each kind.
const MIX: [RayKind; 3] = [RayKind::Primary, RayKind::Diffuse, RayKind::Shadow];

/// The median of each process; 0 for a process without times.
fn medians(times: &[Vec<f64>]) -> Vec<f64> {
    times.iter().map(|rounds| Spread::of(rounds.iter().copied()).map_or(0.0, |spread| spread.median)).collect()
}

/// Combines the numbers of two engines, process by process.
fn both(one: &[f64], other: &[f64], number: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    one.iter().zip(other).map(|(one, other)| number(*one, *other)).collect()
}

impl Record {
    pub(super) fn build(&self, case: &str, engine: &str, threads: usize) -> Option<&Row> {
        self.rows.iter().find(|row| {
            row.metric == Metric::Build && row.case == case && row.engine == engine && row.threads == threads
        })
    }

    pub(super) fn single(&self, case: &str, engine: &str, kind: RayKind, threads: usize) -> Option<&Row> {
        self.rows.iter().find(|row| {
            row.rays == Some(kind)
                && row.mode == Some(Mode::Single)
                && row.threads == threads
                && row.case == case
                && row.engine == engine
        })
    }

    /// Nanoseconds per ray of the mix, by process.
    fn mixed(&self, case: &str, engine: &str) -> Option<Vec<f64>> {
        let each = |kind: RayKind| {
            let row = self.single(case, engine, kind, 1)?;
            Some(medians(&row.times).iter().map(|time| time / row.count.max(1) as f64 * 1e9).collect::<Vec<f64>>())
        };
        let [a, b, c] = MIX.map(each);
        Some(both(&both(&a?, &b?, |a, b| a + b), &c?, |ab, c| (ab + c) / MIX.len() as f64))
    }

    /// How many times faster the mix is traced by `ours` than by `rival`.
    pub(super) fn traced(&self, case: &str, ours: &str, rival: &str) -> Option<LogRatios> {
        Some(LogRatios::of_processes(both(&self.mixed(case, rival)?, &self.mixed(case, ours)?, |rival, ours| {
            rival / ours
        })))
    }

    /// How many times faster several threads are than one, by wall-clock time and process.
    fn scaling(one: &Row, several: &Row) -> Vec<f64> {
        both(&medians(&one.walls), &medians(&several.walls), |one, several| one / several)
    }

    /// The scaling of `ours` over that of `rival`, for builds or for a kind of rays, in every case
    /// that has both.
    pub(super) fn scalings(&self, rays: Option<RayKind>, (ours, rival): (&str, &str)) -> Vec<CaseRatio> {
        let row = |case: &str, engine: &str, threads| match rays {
            None => self.build(case, engine, threads),
            Some(kind) => self.single(case, engine, kind, threads),
        };
        let most = self.rows.iter().map(|row| row.threads).max().unwrap_or(1);
        let of = |case: &str, engine: &str| {
            (most > 1).then_some(())?;
            Some(Self::scaling(row(case, engine, 1)?, row(case, engine, most)?))
        };
        let find = |case: &String| {
            let (ours, others) = (of(case, ours)?, of(case, rival)?);
            let middle = |numbers: &[f64]| Spread::of(numbers.iter().copied()).map_or(0.0, |spread| spread.median);
            let note = format!("{:.2} from 1 to {most} threads, {rival} {:.2}", middle(&ours), middle(&others));
            let log_ratios = LogRatios::of_processes(both(&ours, &others, |ours, rival| ours / rival));
            Some(CaseRatio { case: case.clone(), note, log_ratios })
        };
        self.cases().iter().filter_map(find).collect()
    }

    /// The time to an image of `each` rays per triangle, build included: the best setting of
    /// kinetree against the best of all others.
    pub(super) fn images(&self, each: f64, robust: bool) -> Vec<CaseRatio> {
        let time = |case: &str, engine: &str| {
            let build = self.build(case, engine, 1).or_else(|| self.build(case, base(engine), 1))?;
            let triangles = self.tree(case, engine)?.triangles as f64;
            let rays = self.mixed(case, engine)?;
            Some(both(&medians(&build.times), &rays, |build, ray| build + each * triangles * ray * 1e-9))
        };
        let find = |case: &String| {
            let singles = self.rows.iter().filter(|row| {
                let single = row.rays == Some(MIX[0]) && row.mode == Some(Mode::Single) && row.threads == 1;
                single && row.case == *case && (!row.is_kinetree() || row.robust == robust)
            });
            let mut best: BTreeMap<bool, (f64, &str, Vec<f64>)> = BTreeMap::new();
            for row in singles {
                let Some(times) = time(case, &row.engine) else { continue };
                let total = times.iter().sum::<f64>();
                if best.get(&row.is_kinetree()).is_none_or(|(least, ..)| total < *least) {
                    best.insert(row.is_kinetree(), (total, &row.engine, times));
                }
            }
            let ((_, name, ours), (_, other, rival)) = (best.get(&true)?, best.get(&false)?);
            let log_ratios = LogRatios::of_processes(both(rival, ours, |rival, ours| rival / ours));
            Some(CaseRatio { case: case.clone(), note: format!("{name} over {other}"), log_ratios })
        };
        self.cases().iter().filter_map(find).collect()
    }

    /// By which factor the build time per triangle and level of a four-wide tree grows from the
    /// smallest to the largest scene of the series.
    pub(super) fn growth(&self, engine: &str) -> Option<CaseRatio> {
        let mut series: Vec<(usize, Vec<f64>)> = Vec::new();
        for row in
            self.rows.iter().filter(|row| row.metric == Metric::Build && row.threads == 1 && row.engine == engine)
        {
            if row.case.starts_with(GROWTH) {
                let triangles = self.tree(&row.case, engine)?.triangles;
                series.push((triangles, medians(&row.times)));
            }
        }
        let (first, last) = (series.first()?, series.last()?);
        let each = |triangles: usize, time: f64| time / triangles as f64 / (triangles as f64 / 4.0).log2();
        let grown = both(&first.1, &last.1, |small, large| each(last.0, large) / each(first.0, small));
        let per_triangle = |(triangles, times): &(usize, Vec<f64>)| {
            let median = Spread::of(times.iter().copied()).map_or(0.0, |spread| spread.median);
            format!("{:.0}", median / *triangles as f64 * 1e9)
        };
        let numbers: Vec<String> = series.iter().map(per_triangle).collect();
        let note = format!("{} ns per triangle, from {} to {} triangles", numbers.join(" / "), first.0, last.0);
        (series.len() > 1).then(|| CaseRatio {
            case: engine.to_owned(),
            note,
            log_ratios: LogRatios::of_processes(grown),
        })
    }

    /// The names of all measured cases, in order.
    pub(super) fn cases(&self) -> Vec<String> {
        let mut cases: Vec<String> = Vec::new();
        for row in self.rows.iter().filter(|row| !row.case.starts_with(GROWTH)) {
            if !cases.contains(&row.case) {
                cases.push(row.case.clone());
            }
        }
        cases
    }
}

/// The engine that builds the same tree: the precision of triangle tests does not change it.
pub(super) fn base(engine: &str) -> &str {
    let start = engine.strip_suffix(crate::engine::FAST_PRECISION_SUFFIX).or_else(|| engine.strip_suffix(" robust"));
    start.unwrap_or(engine)
}

#[cfg(test)]
mod tests {
    use super::super::row::example;
    use super::super::{TreeNote, Unit};
    use super::*;
    use crate::engine::Class;

    fn tree(case: &str, engine: &str, triangles: usize) -> TreeNote {
        let (case, engine) = (case.to_owned(), engine.to_owned());
        TreeNote { case, engine, triangles, bytes: 1, cost: None, overlap: None }
    }

    fn built(case: &str, engine: &str, seconds: f64) -> Row {
        let row = example(engine, Class::Fast, true, &[seconds]);
        Row { case: case.into(), metric: Metric::Build, rays: None, mode: None, unit: Unit::Time, ..row }
    }

    #[test]
    fn growth_is_one_when_time_follows_the_depth() {
        let mut record = Record::default();
        for triangles in [10_000_usize, 100_000, 4_000_000] {
            let case = format!("{GROWTH}{triangles}");
            let time = 3e-9 * triangles as f64 * (triangles as f64 / 4.0).log2();
            record.trees.push(tree(&case, "kinetree fast", triangles));
            record.rows.push(built(&case, "kinetree fast", time));
        }
        let growth = record.growth("kinetree fast").unwrap();
        assert!((growth.log_ratios.ratio().unwrap().mean - 1.0).abs() < 1e-9, "{}", growth.note);
        assert!(record.growth("other").is_none());
    }

    #[test]
    fn few_rays_favour_a_quick_build_and_many_rays_a_good_tree() {
        let mut record = Record::default();
        for (engine, build, ray) in [("kinetree fastest", 1.0, 4.0), ("kinetree best", 10.0, 1.0), ("embree", 3.0, 3.0)]
        {
            record.trees.push(tree("race", engine, 1_000_000));
            record.rows.push(built("race", engine, build));
            for kind in MIX {
                // A million rays.
                record.rows.push(Row { rays: Some(kind), ..example(engine, Class::Fast, true, &[ray]) });
            }
        }
        for (each, ours, ratio) in [(1.0, "kinetree fastest", 6.0 / 5.0), (10.0, "kinetree best", 33.0 / 20.0)] {
            let found = &record.images(each, true)[0];
            assert!(found.note.starts_with(ours) && found.note.ends_with("embree"), "{}", found.note);
            assert!((found.log_ratios.ratio().unwrap().mean - ratio).abs() < 1e-9);
        }
        assert!(record.images(1.0, false).is_empty());
    }

    #[test]
    fn scaling_is_compared_with_that_of_others() {
        let mut record = Record::default();
        for (engine, threads, seconds) in
            [("kinetree", 1, 4.0), ("kinetree", 2, 2.0), ("embree", 1, 3.0), ("embree", 2, 2.0)]
        {
            record.rows.push(Row { threads, ..built("race", engine, seconds) });
        }
        let found = &record.scalings(None, ("kinetree", "embree"))[0];
        assert!((found.log_ratios.ratio().unwrap().mean - 2.0 / 1.5).abs() < 1e-9, "{}", found.note);
    }
}
