//! The engines that take part in a case, with their trees.

use super::budget::{Budget, build_only_key};
use super::guarded::guarded;
use super::log::Log;
use super::rows::memory_rows;
use crate::engine::{Class, Engine, ThreadPool, Tree};
use crate::failure::Failure;
use crate::measure::clock::{ClockScope, Stopwatch};
use crate::measure::memory;
use crate::report::{Record, TreeNote};
use crate::soup::Soup;

/// An engine with its tree.
pub(crate) struct BuiltEngine {
    /// Name and settings.
    pub(crate) name: String,
    /// See [`Engine::instructions`].
    pub(crate) instructions: String,
    /// What the tree was built for.
    pub(crate) class: Class,
    /// Whether the engine promises watertight hits.
    pub(crate) robust: bool,
    /// The tree.
    pub(crate) tree: Box<dyn Tree>,
}

/// The name of an engine with the suffix of one of its batches.
pub(crate) fn named(engine: &str, suffix: &str) -> String {
    format!("{engine} {suffix}").trim_end().to_owned()
}

/// Whether this is an engine without which a comparison is pointless.
fn is_core(engine: &str) -> bool {
    ["kinetree fast", "embree medium", "tinybvh"].contains(&engine)
}

/// Whether the engines without which a comparison is pointless can be built in time; if not, the
/// log says so.
pub(crate) fn is_possible(
    case: &str,
    engines: &[&dyn Engine],
    triangles: usize,
    (budget, seconds): (&Budget, f64),
    log: &mut Log,
) -> bool {
    let core = engines.iter().filter(|engine| is_core(engine.name()));
    let predicted: f64 = core.map(|engine| budget.expected_seconds(engine.name(), triangles)).sum();
    if predicted > seconds {
        log.print(&format!("  {case} is left out: there is no time for it"));
    }
    predicted <= seconds
}

/// The largest scene, in triangles, that a quick run builds once more to learn the cost of a tree.
const MAX_TRIANGLES_FOR_COST: usize = 700_000;

/// Builds a tree with each engine on one thread and records its memory. Engines that fail are left
/// out, and so are those whose predicted time exceeds what remains of `seconds`; the log says why.
pub(crate) fn build(
    case: &str,
    engines: &[&dyn Engine],
    soup: &Soup,
    (budget, seconds): (&mut Budget, f64),
    log: &mut Log,
    record: &mut Record,
) -> Result<Vec<BuiltEngine>, Failure> {
    let pool = ThreadPool::new(1)?;
    let all = Stopwatch::start(ClockScope::Process);
    let mut lineup = Vec::new();
    for engine in engines {
        let name = engine.name().to_owned();
        if !is_core(&name) && all.read().wall + budget.expected_seconds(&name, soup.len()) > seconds {
            log.print(&format!("  {name} is left out: there is no time for its build"));
            continue;
        }
        let watch = Stopwatch::start(ClockScope::Process);
        let built = guarded(|| {
            let mut prepared = engine.prepare(soup)?;
            prepared.set_up(&pool)?;
            let watch = Stopwatch::start(ClockScope::Process);
            let (tree, heap_use) = memory::count(|| prepared.build(&pool));
            let (tree, build_seconds) = (tree?, watch.read().wall);
            let is_cost_measured =
                (seconds.is_infinite() || soup.len() <= MAX_TRIANGLES_FOR_COST) && !engine.shares_builds();
            let facts = tree.facts();
            let cost = facts.cost.or_else(|| if is_cost_measured { prepared.measure_cost(&pool) } else { None });
            Ok((tree, heap_use, cost, build_seconds))
        });
        budget.record_build(&name, soup.len(), watch.read().wall);
        match built {
            Ok((tree, heap_use, cost, build_seconds)) => {
                budget.record_build(&build_only_key(&name), soup.len(), build_seconds);
                let note = TreeNote {
                    case: case.to_owned(),
                    engine: name.clone(),
                    triangles: soup.len(),
                    bytes: tree.facts().bytes.unwrap_or(heap_use.after),
                    cost,
                    overlap: tree.facts().overlap,
                };
                log.print(&format!("  {}", note.sentence()));
                record.trees.push(note);
                if !engine.shares_builds() {
                    record.rows.extend(memory_rows(case, *engine, &*tree, heap_use, soup));
                }
                let (instructions, class, robust) =
                    (engine.instructions().to_owned(), engine.class(), engine.is_robust());
                lineup.push(BuiltEngine { name, instructions, class, robust, tree });
            }
            Err(failure) => log.print(&format!("  {name} is left out: {failure}")),
        }
    }
    Ok(lineup)
}
