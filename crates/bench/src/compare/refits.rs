//! Times refits to slightly moved vertices.

use super::guarded::guarded;
use super::log::Log;
use super::plan::Plan;
use super::rows::time_row;
use crate::engine::{Engine, Refit, ThreadPool};
use crate::failure::Failure;
use crate::measure::clock::{ClockScope, Stopwatch};
use crate::measure::pin::Pinned;
use crate::measure::rounds::{Rounds, in_turn};
use crate::report::{Metric, Row, UNINDEXED};
use crate::soup::Soup;

/// How far vertices move, relative to the size of the scene.
const SWAY: f32 = 1e-4;

/// Times every engine that can refit, with shared vertices and, in full runs, with three vertices
/// for each triangle. Each of the two takes about `seconds`.
pub(crate) fn run(
    case: &str,
    plan: &Plan,
    engines: &[&dyn Engine],
    soup: &Soup,
    seconds: f64,
    log: &mut Log,
    rows: &mut Vec<Row>,
) -> Result<(), Failure> {
    let unindexed = (!plan.quick).then(|| soup.unindexed());
    let soups = [(case.to_owned(), Some(soup)), (format!("{case}{UNINDEXED}"), unindexed.as_ref())];
    for (name, soup) in soups.into_iter().filter_map(|(name, soup)| Some((name, soup?))) {
        let pool = ThreadPool::new(1)?;
        let mut refitters: Vec<(&dyn Engine, Box<dyn Refit>)> = Vec::new();
        for engine in engines {
            match guarded(|| engine.refitter(soup, &pool)) {
                Ok(Some(refit)) => refitters.push((*engine, refit)),
                Ok(None) => {}
                Err(failure) => log.print(&format!("  {} cannot refit: {failure}", engine.name())),
            }
        }
        let poses = [sway(soup, 1.0), sway(soup, -1.0)];
        let mut turns = vec![0_usize; refitters.len()];
        let mut failures = Vec::new();
        let times = in_turn(refitters.len(), Rounds { seconds, ..plan.builds }, |at| {
            let positions = &poses[turns[at] % 2];
            turns[at] += 1;
            let (engine, refit) = &mut refitters[at];
            let _pinned = Pinned::all_to(0);
            let watch = Stopwatch::start(ClockScope::Process);
            let done = guarded(|| refit.refit(positions));
            let elapsed = watch.read();
            if let Err(failure) = done {
                failures.push(format!("  {} cannot refit: {failure}", engine.name()));
                return None;
            }
            Some(elapsed)
        });
        failures.iter().for_each(|failure| log.print(failure));
        for ((engine, _), times) in refitters.iter().zip(times) {
            rows.extend(time_row(&name, *engine, Metric::Refit, 1, &times));
        }
    }
    Ok(())
}

/// The positions with every vertex moved a little; neighbouring vertices move alike.
fn sway(soup: &Soup, sign: f32) -> Vec<[f32; 3]> {
    let bounds = soup.bounds();
    let size = bounds.extent().into_iter().fold(0.0, f32::max);
    let moved = |[x, y, z]: [f32; 3]| {
        let wave = ((x + 2.0 * y + 3.0 * z) / size.max(f32::MIN_POSITIVE) * 7.0).fract();
        [x + sign * wave * SWAY * size, y, z - sign * wave * SWAY * size]
    };
    soup.positions.iter().copied().map(moved).collect()
}
