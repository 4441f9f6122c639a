//! How cost grows with the number of triangles: builds and rays on terrain.

use super::{Log, Plan, builds, check, field, traces};
use crate::Failure;
use crate::case::Case;
use crate::engine::{Class, Engine, ours};
use crate::rays::{self, Kind};
use crate::report::{self, Metric, Row};
use crate::scene::SceneChoice;

/// Triangles of the series.
const FULL: [usize; 4] = [10_000, 100_000, 1_000_000, 4_000_000];
const QUICK: [usize; 3] = [10_000, 40_000, 160_000];

/// Builds and traces the series with ours and with the leading others, and says how the time per triangle grows.
pub(crate) fn run(engines: &[Box<dyn Engine>], plan: &Plan, log: &mut Log, rows: &mut Vec<Row>) -> Result<(), Failure> {
    let leading = |name: &str| ["kinetree", "embree", "tinybvh"].iter().any(|start| name.starts_with(start));
    let wanted: Vec<&dyn Engine> = engines
        .iter()
        .map(|engine| &**engine)
        .filter(|engine| leading(engine.name()) && engine.class() != Class::Best)
        .collect();
    let from = rows.len();
    let sizes: &[usize] = if plan.quick { &QUICK } else { &FULL };
    let mut per_triangle: Vec<Vec<(usize, f64)>> = vec![Vec::new(); wanted.len()];
    for &triangles in sizes {
        let case = case(triangles, plan);
        let scenery = case.scene.open()?;
        let soup = &scenery.soup;
        let reference = ours::Reference::of(soup)?;
        let count = if plan.quick { case.quick_rays } else { case.rays };
        let sets = rays::sets(&scenery, &case.sets, count, case.seed, &|rays| reference.closest(rays));
        let mut field = field::build(&case.name, &wanted, soup, log, rows)?;
        check::check(&case, plan, soup, &reference, &sets, &mut field, log);
        traces::run(&case, plan, &sets, &field, log, rows)?;
        drop(field);
        let first = rows.len();
        builds::run(&case.name, plan, &wanted, soup, rows)?;
        for (engine, series) in wanted.iter().zip(&mut per_triangle) {
            let built = |row: &&Row| row.metric == Metric::Build && row.threads == 1 && row.engine == engine.name();
            series
                .extend(rows[first..].iter().find(built).map(|row| (soup.len(), row.median * 1e6 / soup.len() as f64)));
        }
    }
    log.say(&report::table(&rows[from..]));
    log.say("growth: ns of building per triangle, and that per log2(N/4) of the largest over the smallest");
    for (engine, series) in wanted.iter().zip(&per_triangle) {
        let numbers: Vec<String> = series.iter().map(|(_, time)| format!("{time:.0}")).collect();
        let grown = growth(series).map_or_else(|| "-".to_owned(), |growth| format!("{growth:.2}x"));
        log.say(&format!("  {:<22} {}  {grown}", engine.name(), numbers.join(" / ")));
    }
    Ok(())
}

fn case(triangles: usize, plan: &Plan) -> Case {
    Case {
        name: format!("growth {triangles}"),
        scene: SceneChoice::Terrain { seed: 1, triangles },
        seed: 1,
        rays: 1 << 17,
        quick_rays: 1 << 13,
        sets: if plan.quick { vec![Kind::Primary] } else { vec![Kind::Primary, Kind::Diffuse] },
        engines: Vec::new(),
        quick_engines: Vec::new(),
        hits: std::collections::BTreeMap::new(),
    }
}

/// Time per triangle over the depth of a tree of fours, at the last size over the first.
fn growth(series: &[(usize, f64)]) -> Option<f64> {
    let (first, last) = (series.first()?, series.last()?);
    let each = |(triangles, time): &(usize, f64)| time / (*triangles as f64 / 4.0).log2();
    (series.len() > 1).then(|| each(last) / each(first))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_one_when_time_follows_the_depth() {
        let at = |triangles: usize| (triangles, 3.0 * (triangles as f64 / 4.0).log2());
        assert!((growth(&[at(10_000), at(100_000), at(4_000_000)]).unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(growth(&[at(10)]), None);
    }
}
