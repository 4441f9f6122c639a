//! Times builds, on one thread and on all.

use super::budget::{Budget, build_only_key};
use super::guarded::guarded;
use super::log::Log;
use super::plan::{Plan, QUICK_TRIANGLES};
use super::rows::time_row;
use crate::engine::{Class, Engine, Prepared, ThreadPool};
use crate::failure::Failure;
use crate::measure::clock::{ClockScope, Elapsed, Stopwatch};
use crate::measure::pin::Pinned;
use crate::measure::rounds::{Rounds, in_turn};
use crate::report::{Metric, Row};
use crate::soup::Soup;

/// Times the build of every engine. Engines that fail are left out, and so are those whose
/// predicted time, together with the engines before them, exceeds `seconds`.
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
        // On all threads, only engines whose scaling is compared.
        let scales = |name: &str| name.starts_with("kinetree") || name.starts_with("embree");
        let mut predicted = 0.0;
        let mut chosen: Vec<&dyn Engine> = Vec::new();
        let wanted = engines.iter().copied().filter(|engine| !engine.shares_builds());
        for engine in wanted.filter(|engine| threads == 1 || scales(engine.name())) {
            predicted += budget.expected_seconds(&build_only_key(engine.name()), soup.len());
            if predicted > seconds {
                log.print(&format!("  the build of {} is not timed: there is no time for it", engine.name()));
                predicted -= budget.expected_seconds(&build_only_key(engine.name()), soup.len());
            } else {
                chosen.push(engine);
            }
        }
        // Engines of one class take turns with each other, so that paired times are close in time
        // and a slow engine is only compared with its class.
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

fn build(prepared: &mut Box<dyn Prepared>, pool: &ThreadPool) -> Option<Elapsed> {
    prepared.set_up(pool).ok()?;
    let _pinned = (pool.threads == 1).then(|| Pinned::all_to(0));
    // Engines build on threads of their own, so the processor time of the whole process counts;
    // nothing else runs in it.
    let watch = Stopwatch::start(ClockScope::Process);
    let tree = guarded(|| prepared.build(pool)).ok()?;
    let elapsed = watch.read();
    drop(tree);
    Some(elapsed)
}
