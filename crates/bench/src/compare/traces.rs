//! Times rays: engines take turns, on one core and then on all.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use kinetree::Coherence;
use kinetree::wide::{TriangleBlock, WideNode};

use super::check::Disagreements;
use super::lineup::{BuiltEngine, named};
use super::log::Log;
use super::plan::Plan;
use crate::case::Case;
use crate::engine::{Batch, Mode};
use crate::measure::clock::{ClockScope, Elapsed, Stopwatch};
use crate::measure::pin::Pinned;
use crate::measure::rounds::{Rounds, in_turn};
use crate::ray::{Answer, Ray};
use crate::rays::{QueryKind, RayKind, RaySet};
use crate::report::{Metric, PerRay, Row, Unit};

/// The number of rays that a thread takes at a time when several trace: whole tiles.
const CHUNK: usize = 1024;

/// Times every engine on every set.
pub(crate) fn run(
    case: &Case,
    plan: &Plan,
    sets: &[RaySet],
    lineup: &[BuiltEngine],
    disagreements: &Disagreements,
    seconds: f64,
    log: &mut Log,
    rows: &mut Vec<Row>,
) {
    // One third of the time is for all threads, which only a few sets are traced on.
    let seconds = seconds / (1.5 * sets.len().max(1) as f64);
    for set in sets {
        let work: BTreeMap<String, PerRay> =
            lineup.iter().filter_map(|built| Some((built.name.clone(), count(set, built, log)?))).collect();
        let contenders: Vec<Contender<'_>> = contenders(set, lineup);
        let mut threads = vec![1];
        threads.extend((plan.threads > 1 && scales(set.kind, plan.quick)).then_some(plan.threads));
        for threads in threads {
            let mut buffers = AnswerBuffers::of(set.rays.len());
            let rounds = Rounds { seconds, ..plan.rounds };
            let times = in_turn(contenders.len(), rounds, |at| Some(contenders[at].time(set, threads, &mut buffers)));
            for (contender, times) in contenders.iter().zip(times) {
                let row = contender.row(case, set, threads);
                let single = contender.batch.is_none();
                let wrong_answers = disagreements.get(&(row.engine.clone(), single, set.kind)).copied();
                let work = work.get(&row.engine).filter(|_| single).copied();
                rows.extend(Row { wrong_answers, work, ..row }.with_times(&times));
            }
        }
    }
}

/// Which sets are traced on all threads, too.
fn scales(kind: RayKind, quick: bool) -> bool {
    kind == RayKind::Primary || kind == RayKind::Diffuse && !quick
}

/// Counts the work of a set of rays traced one by one, if the engine can count it.
fn count(set: &RaySet, built: &BuiltEngine, log: &mut Log) -> Option<PerRay> {
    let work = built.tree.count(&set.rays, set.kind.query_kind())?;
    let each = |count: u64| count as f64 / set.rays.len() as f64;
    let (nodes, blocks) = (each(work.nodes), each(work.blocks));
    // Both types consist of whole cache lines and are aligned to them.
    let (node, block) = (size_of::<WideNode>() as f64 / LINE, size_of::<TriangleBlock>() as f64 / LINE);
    let per_ray = PerRay { nodes, blocks, triangles: each(work.triangles), lines: nodes * node + blocks * block };
    log.print(&format!(
        "  {:<28} {:<17} per ray: {nodes:.2} nodes, {blocks:.2} leaf blocks, {:.2} triangles, {:.1} cache lines",
        built.name,
        set.kind.name(),
        per_ray.triangles,
        per_ray.lines
    ));
    Some(per_ray)
}

/// Bytes of a cache line.
const LINE: f64 = 64.0;

/// An engine, and how rays are handed to it.
struct Contender<'a> {
    built: &'a BuiltEngine,
    batch: Option<(&'a dyn Batch, Coherence)>,
}

fn contenders<'a>(set: &RaySet, lineup: &'a [BuiltEngine]) -> Vec<Contender<'a>> {
    let mut all: Vec<Contender<'a>> = lineup.iter().map(|built| Contender { built, batch: None }).collect();
    if let Some(coherence) = set.kind.batch() {
        for built in lineup {
            let batches = built.tree.batches().into_iter().filter(|batch| batch.suits(coherence));
            all.extend(batches.map(|batch| Contender { built, batch: Some((batch, coherence)) }));
        }
    }
    all
}

/// Answers of a round, allocated before the clock starts.
struct AnswerBuffers {
    answers: Vec<Answer>,
    blocked: Vec<bool>,
}

impl AnswerBuffers {
    fn of(rays: usize) -> Self {
        Self { answers: vec![Answer::MISS; rays], blocked: vec![false; rays] }
    }
}

impl Contender<'_> {
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]) {
        match self.batch {
            None => self.built.tree.closest(rays, answers),
            Some((batch, coherence)) => batch.closest(rays, answers, coherence),
        }
    }

    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]) {
        match self.batch {
            None => self.built.tree.occluded(rays, blocked),
            Some((batch, coherence)) => batch.occluded(rays, blocked, coherence),
        }
    }

    fn time(&self, set: &RaySet, threads: usize, buffers: &mut AnswerBuffers) -> Elapsed {
        match (set.kind.query_kind(), threads) {
            (QueryKind::Closest, 1) => on_one_core(|| self.closest(&set.rays, &mut buffers.answers)),
            (QueryKind::Occluded, 1) => on_one_core(|| self.occluded(&set.rays, &mut buffers.blocked)),
            (QueryKind::Closest, _) => {
                let job = |rays: &[Ray], answers: &mut [Answer]| self.closest(rays, answers);
                on_threads(threads, self.chunk(set, threads), &set.rays, &mut buffers.answers, &job)
            }
            (QueryKind::Occluded, _) => {
                let job = |rays: &[Ray], blocked: &mut [bool]| self.occluded(rays, blocked);
                on_threads(threads, self.chunk(set, threads), &set.rays, &mut buffers.blocked, &job)
            }
        }
    }

    /// The number of rays that a thread takes at a time. For a batch that sorts its rays it is the
    /// whole share of the thread, since sorting is what is measured.
    fn chunk(&self, set: &RaySet, threads: usize) -> usize {
        match self.batch {
            Some((batch, _)) if batch.mode() == Mode::Batch => set.rays.len().div_ceil(threads).next_multiple_of(64),
            _ => CHUNK,
        }
    }

    /// A row without numbers.
    fn row(&self, case: &Case, set: &RaySet, threads: usize) -> Row {
        let (suffix, mode) = self.batch.map_or(("", Mode::Single), |(batch, _)| (batch.suffix(), batch.mode()));
        Row {
            case: case.name.clone(),
            engine: named(&self.built.name, suffix),
            metric: Metric::Trace,
            rays: Some(set.kind),
            mode: Some(mode),
            instructions: self.built.instructions.clone(),
            robust: self.built.robust,
            threads,
            unit: Unit::Rays,
            median: 0.0,
            min: 0.0,
            max: 0.0,
            class: self.built.class,
            count: set.rays.len(),
            times: Vec::new(),
            walls: Vec::new(),
            wrong_answers: None,
            work: None,
        }
    }
}

/// Runs and times a job on one core.
fn on_one_core(job: impl FnOnce()) -> Elapsed {
    let _here = Pinned::to(0);
    let watch = Stopwatch::start(ClockScope::Thread);
    job();
    watch.read()
}

/// Runs and times a job on several threads, each pinned to a core of its own; they take chunks from
/// a common queue.
fn on_threads<A: Send>(
    threads: usize,
    chunk: usize,
    rays: &[Ray],
    answers: &mut [A],
    job: &(impl Fn(&[Ray], &mut [A]) + Sync),
) -> Elapsed {
    let chunks: Vec<Mutex<(&[Ray], &mut [A])>> =
        rays.chunks(chunk).zip(answers.chunks_mut(chunk)).map(Mutex::new).collect();
    let next = AtomicUsize::new(0);
    let watch = Stopwatch::start(ClockScope::Process);
    std::thread::scope(|scope| {
        for number in 0..threads {
            let (chunks, next) = (&chunks, &next);
            scope.spawn(move || {
                let _here = Pinned::to(number);
                while let Some(chunk) = chunks.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let mut chunk = chunk.lock().expect("each chunk is taken once");
                    let (rays, answers) = &mut *chunk;
                    job(rays, answers);
                }
            });
        }
    });
    watch.read()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn every_ray_is_answered_once_whatever_the_threads() {
        let rays: Vec<Ray> = (0..10_000).map(|i| Ray::new(Vec3::splat(i as f32), Vec3::X)).collect();
        for threads in [1, 2, 5] {
            let mut answers = vec![0.0; rays.len()];
            on_threads(threads, 100, &rays, &mut answers, &|rays, answers: &mut [f32]| {
                rays.iter().zip(answers).for_each(|(ray, answer)| *answer += ray.origin[0] + 1.0);
            });
            assert!(answers.iter().zip(0..).all(|(answer, i)| *answer == i as f32 + 1.0));
        }
    }
}
