//! Rows of results about builds, refits and memory.

use crate::engine::{Engine, Tree};
use crate::measure::clock::Elapsed;
use crate::measure::memory::HeapUse;
use crate::report::{Metric, Row, Unit};
use crate::soup::Soup;

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

/// Rows about memory: the size of the finished tree, and the peak of the build.
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
    // An engine in another language counts its memory itself, or not at all; the allocator of this
    // program does not see it.
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
