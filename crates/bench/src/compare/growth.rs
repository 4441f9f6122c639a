//! How build and trace times grow with the number of triangles, on terrain.

use super::budget::Budget;
use super::log::Log;
use super::plan::Plan;
use super::{builds, check, lineup, traces};
use crate::case::Case;
use crate::engine::{Class, Engine, Reference};
use crate::failure::Failure;
use crate::ray::Ray;
use crate::rays::{self, RayKind};
use crate::report::{self, Record};
use crate::scene::SceneChoice;

/// The numbers of triangles of the series.
const FULL: [usize; 4] = [10_000, 100_000, 1_000_000, 4_000_000];
const QUICK: [usize; 3] = [10_000, 40_000, 160_000];

/// Builds and traces the series with kinetree, Embree and tinybvh; the report says how the time per
/// triangle grows.
pub(crate) fn run(
    engines: &[Box<dyn Engine>],
    plan: &Plan,
    budget: &mut Budget,
    log: &mut Log,
    record: &mut Record,
) -> Result<(), Failure> {
    let leading = |name: &str| ["kinetree", "embree", "tinybvh"].iter().any(|start| name.starts_with(start));
    let wanted: Vec<&dyn Engine> = engines
        .iter()
        .map(|engine| &**engine)
        .filter(|engine| leading(engine.name()) && engine.class() != Class::Best)
        .collect();
    let from = record.rows.len();
    let plan = &Plan { threads: 1, ..*plan };
    let sizes: &[usize] = if plan.quick { &QUICK } else { &FULL };
    for (at, &triangles) in sizes.iter().enumerate() {
        let case = case(triangles, plan);
        let scene = case.scene.open()?;
        let soup = &scene.soup;
        let seconds = budget.share(1.0, (sizes.len() - at) as f64);
        if !lineup::is_possible(&case.name, &wanted, soup.len(), (&*budget, seconds * 0.6), log) {
            continue;
        }
        let reference = Reference::of(soup)?;
        let trace = |rays: &[Ray]| reference.closest(soup, rays);
        let sets = rays::sets(&scene, &case.sets, &|kind| case.count(kind, plan.quick), case.seed, &trace);
        let mut lineup = lineup::build(&case.name, &wanted, soup, (&mut *budget, seconds * 0.4), log, record)?;
        let checked = check::check(&case, plan, soup, &reference, &sets, &mut lineup, log);
        record.kinetree_is_wrong |= checked.kinetree_is_wrong;
        record.some_engine_differs |= checked.some_engine_differs;
        let rows = &mut record.rows;
        traces::run(&case, plan, &sets, &lineup, &checked.disagreements, seconds * 0.25, log, rows);
        drop(lineup);
        builds::run(&case.name, plan, &wanted, soup, (&*budget, seconds * 0.25), log, rows)?;
    }
    log.print(&report::table(&record.rows[from..]));
    Ok(())
}

fn case(triangles: usize, plan: &Plan) -> Case {
    Case {
        name: format!("{}{triangles}", report::GROWTH),
        scene: SceneChoice::Terrain { seed: 1, triangles },
        camera: None,
        seed: 1,
        triangles: None,
        rays: 1 << 17,
        quick_rays: 1 << 13,
        sets: if plan.quick { vec![RayKind::Primary] } else { vec![RayKind::Primary, RayKind::Diffuse] },
        engines: Vec::new(),
        quick_engines: Vec::new(),
        hits: std::collections::BTreeMap::new(),
    }
}
