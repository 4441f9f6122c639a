//! Builds: time on one thread and on all, and memory.

use super::field::guarded;
use super::{Plan, QUICK_TRIANGLES};
use crate::Failure;
use crate::engine::{Crew, Engine, Prepared, Tree};
use crate::measure::clock::{Stopwatch, Took, Whose};
use crate::measure::memory::Held;
use crate::measure::rounds::in_turn;
use crate::report::{Metric, Row};
use crate::soup::Soup;

/// Times every engine's build; who fails is left out.
pub(crate) fn run(
    case: &str,
    plan: &Plan,
    engines: &[&dyn Engine],
    soup: &Soup,
    rows: &mut Vec<Row>,
) -> Result<(), Failure> {
    let mut threads = vec![1];
    threads.extend((plan.threads > 1 && !(plan.quick && soup.len() > QUICK_TRIANGLES)).then_some(plan.threads));
    for threads in threads {
        let crew = Crew::new(threads)?;
        // In a hurry, only those whose scaling is compared build on all threads.
        let scales = |name: &str| name.starts_with("kinetree") || name.starts_with("embree");
        let engines: Vec<&dyn Engine> = engines
            .iter()
            .copied()
            .filter(|engine| !engine.shares_builds())
            .filter(|engine| threads == 1 || !plan.quick || scales(engine.name()))
            .collect();
        let mut ready: Vec<Option<Box<dyn Prepared>>> =
            engines.iter().map(|engine| guarded(|| engine.prepare(soup)).ok()).collect();
        let times = in_turn(engines.len(), plan.builds, |at| build(ready[at].as_mut()?, &crew));
        for (engine, times) in engines.iter().zip(times) {
            rows.extend(timed(case, *engine, Metric::Build, threads, &times));
        }
    }
    Ok(())
}

fn build(ready: &mut Box<dyn Prepared>, crew: &Crew) -> Option<Took> {
    ready.renew().ok()?;
    // Engines work on threads of their own, so the whole process counts; nothing else runs in it.
    let watch = Stopwatch::start(Whose::Process);
    let tree = guarded(|| ready.build(crew)).ok()?;
    let took = watch.read();
    drop(tree);
    Some(took)
}

/// A row of milliseconds: processor time for one thread, wall time for several.
pub(crate) fn timed(case: &str, engine: &dyn Engine, metric: Metric, threads: usize, times: &[Took]) -> Option<Row> {
    let walls: Vec<f64> = times.iter().map(|took| took.wall).collect();
    let shown = if threads == 1 { times.iter().map(|took| took.processor).collect() } else { walls.clone() };
    row(case, engine, metric, threads, "ms").with_times(shown, &walls, |time| time * 1e3)
}

/// Rows about memory: what the finished tree holds, and the most at a time.
pub(crate) fn weighed(case: &str, engine: &dyn Engine, tree: &dyn Tree, held: Held, soup: &Soup) -> Vec<Row> {
    let facts = tree.facts();
    let number = |metric, bytes: usize| {
        let each = bytes as f64 / soup.len().max(1) as f64;
        Row { median: each, min: each, max: each, wall: each, ..row(case, engine, metric, 1, "bytes/triangle") }
    };
    let bytes = facts.bytes.unwrap_or(held.after);
    // An engine in another language keeps its own count, or has none: then the allocator of this program has seen nothing.
    let peak = facts.peak.or((held.peak >= bytes).then_some(held.peak));
    let mut rows = vec![number(Metric::Memory, bytes)];
    rows.extend(peak.map(|peak| number(Metric::PeakMemory, peak)));
    rows
}

fn row(case: &str, engine: &dyn Engine, metric: Metric, threads: usize, unit: &'static str) -> Row {
    Row {
        case: case.to_owned(),
        engine: engine.name().to_owned(),
        metric,
        rays: None,
        mode: None,
        robust: engine.is_robust(),
        threads,
        unit,
        median: 0.0,
        min: 0.0,
        max: 0.0,
        wall: 0.0,
        class: engine.class(),
        times: Vec::new(),
    }
}
