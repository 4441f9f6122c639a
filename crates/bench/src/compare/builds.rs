//! Builds: time on one thread and on all, and memory.

use super::budget::Budget;
use super::lineup::guarded;
use super::{Log, Plan, QUICK_TRIANGLES};
use crate::engine::{Class, Engine, Prepared, ThreadPool, Tree};
use crate::failure::Failure;
use crate::measure::clock::{ClockScope, Elapsed, Stopwatch};
use crate::measure::memory::HeapUse;
use crate::measure::pin::Pinned;
use crate::measure::rounds::{Rounds, in_turn};
use crate::report::{Metric, Row, Unit};
use crate::soup::Soup;

/// Times every engine's build; who fails, or would take longer than `seconds` together with those before, is left out.
pub(crate) fn run(
    case: &str,
    plan: &Plan,
    engines: &[&dyn Engine],
    soup: &Soup,
    (budget, seconds): (&Budget, f64),
    log: &mut Log,
    rows: &mut Vec<Row>,
) -> Result<(), Failure> {
    let mut threads = vec![1];
    threads.extend((plan.threads > 1 && !(plan.quick && soup.len() > QUICK_TRIANGLES)).then_some(plan.threads));
    let seconds = seconds / threads.len() as f64;
    for threads in threads {
        let pool = ThreadPool::new(threads)?;
        // On all threads, only those whose scaling is compared.
        let scales = |name: &str| name.starts_with("kinetree") || name.starts_with("embree");
        let mut predicted = 0.0;
        let mut chosen: Vec<&dyn Engine> = Vec::new();
        let wanted = engines.iter().copied().filter(|engine| !engine.shares_builds());
        for engine in wanted.filter(|engine| threads == 1 || scales(engine.name())) {
            predicted += budget.expected_seconds(&build_only_key(engine.name()), soup.len());
            if predicted > seconds {
                log.say(&format!("  the build of {} is not timed: there is no time for it", engine.name()));
                predicted -= budget.expected_seconds(&build_only_key(engine.name()), soup.len());
            } else {
                chosen.push(engine);
            }
        }
        // Like takes turns with like: what is paired is close in time, and who is far behind is so among its own.
        for class in [Class::Fastest, Class::Fast, Class::Best] {
            let alike: Vec<&dyn Engine> = chosen.iter().copied().filter(|engine| engine.class() == class).collect();
            let mut prepared: Vec<Option<Box<dyn Prepared>>> =
                alike.iter().map(|engine| guarded(|| engine.prepare(soup)).ok()).collect();
            let rounds = Rounds { seconds: seconds / 3.0, ..plan.builds };
            let times = in_turn(alike.len(), rounds, |at| build(prepared[at].as_mut()?, &pool));
            for (engine, times) in alike.iter().zip(times) {
                rows.extend(time_row(case, *engine, Metric::Build, threads, &times));
            }
        }
    }
    Ok(())
}

/// What the budget knows an engine's build by, without what comes before and after it.
pub(crate) fn build_only_key(engine: &str) -> String {
    format!("{engine}, the build alone")
}

fn build(prepared: &mut Box<dyn Prepared>, pool: &ThreadPool) -> Option<Elapsed> {
    prepared.set_up(pool).ok()?;
    let _pinned = (pool.threads == 1).then(|| Pinned::all_to(0));
    // Engines work on threads of their own, so the whole process counts; nothing else runs in it.
    let watch = Stopwatch::start(ClockScope::Process);
    let tree = guarded(|| prepared.build(pool)).ok()?;
    let elapsed = watch.read();
    drop(tree);
    Some(elapsed)
}

/// A row of milliseconds: processor time for one thread, wall time for several.
pub(crate) fn time_row(
    case: &str,
    engine: &dyn Engine,
    metric: Metric,
    threads: usize,
    times: &[Elapsed],
) -> Option<Row> {
    row(case, engine, metric, threads, Unit::Time).with_times(times)
}

/// Rows about memory: what the finished tree holds, and the most at a time.
pub(crate) fn memory_rows(
    case: &str,
    engine: &dyn Engine,
    tree: &dyn Tree,
    heap_use: HeapUse,
    soup: &Soup,
) -> Vec<Row> {
    let facts = tree.facts();
    let number = |metric, bytes: usize| {
        let each = bytes as f64 / soup.len().max(1) as f64;
        Row { median: each, min: each, max: each, ..row(case, engine, metric, 1, Unit::Bytes) }
    };
    let bytes = facts.bytes.unwrap_or(heap_use.after);
    // An engine in another language keeps its own count, or has none: then the allocator of this program has seen nothing.
    let peak = facts.peak.or((heap_use.peak >= bytes).then_some(heap_use.peak));
    let mut rows = vec![number(Metric::Memory, bytes)];
    rows.extend(peak.map(|peak| number(Metric::PeakMemory, peak)));
    rows
}

fn row(case: &str, engine: &dyn Engine, metric: Metric, threads: usize, unit: Unit) -> Row {
    Row {
        case: case.to_owned(),
        engine: engine.name().to_owned(),
        metric,
        rays: None,
        mode: None,
        instructions: engine.instructions().to_owned(),
        robust: engine.is_robust(),
        threads,
        unit,
        median: 0.0,
        min: 0.0,
        max: 0.0,
        class: engine.class(),
        count: 0,
        times: Vec::new(),
        walls: Vec::new(),
        wrong_answers: None,
        work: None,
    }
}
