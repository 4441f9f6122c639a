//! The whole comparison, case by case: first the answers, then the times.

mod budget;
mod builds;
mod check;
mod collect;
mod growth;
mod guarded;
mod lineup;
mod log;
mod options;
mod plan;
mod processes;
mod refits;
mod rows;
mod traces;

use std::path::Path;

use kinetree::simd::Level;

use self::budget::Budget;
use self::log::Log;
pub(crate) use self::options::Options;
use self::plan::{Plan, QUICK_TRIANGLES};
use crate::case::Case;
use crate::engine::{self, Class, Engine, Reference};
use crate::failure::Failure;
use crate::machine;
use crate::ray::Ray;
use crate::rays;
use crate::report::{self, Record};
use crate::scene::PinholeCamera;

/// Runs the comparison; true if all answers of kinetree were right.
///
/// # Errors
/// A scene that cannot be opened, or results that cannot be written.
pub(crate) fn run(options: &Options) -> Result<bool, Failure> {
    let mut log = Log::default();
    let record = if options.part.is_none() && options.processes > 1 {
        let record = processes::run(options.processes)?;
        log.text.push_str(&record.text);
        log.print("\n#### all processes together");
        log.print(&report::table(&record.rows));
        record
    } else {
        measure(options, &mut log)?
    };
    if let Some(part) = &options.part {
        save(part, &serde_json::to_string(&Record { text: log.text, ..record })?)?;
        return Ok(true);
    }
    log.print(&report::goals(&record, Level::current().name(), machine::second_cache()));
    log.print(match (record.kinetree_is_wrong, record.some_engine_differs) {
        (true, _) => "NOT all answers of kinetree are right",
        (false, true) => "all answers of kinetree are right; those of others that differ are counted above",
        (false, false) => "every engine agrees with the reference",
    });
    write(options, &record, &log)?;
    Ok(!record.kinetree_is_wrong)
}

/// Measures all cases in this process.
fn measure(options: &Options, log: &mut Log) -> Result<Record, Failure> {
    let plan = Plan::of(options);
    let mut budget = Budget::new(options.quick);
    let (mut engines, notes) = engine::all();
    let is_selected =
        |name: &str| options.engine.is_empty() || options.engine.iter().any(|start| name.starts_with(start.as_str()));
    engines.retain(|engine| is_selected(engine.name()));
    let (processor, level, date) = (machine::processor(), Level::current().name(), machine::date());
    log.print(&format!("{processor}, {} threads, level {level}, {date}", plan.threads));
    log.print(&machine::versions());
    notes.iter().for_each(|note| log.print(note));

    let mut record = Record::default();
    let cases = cases(options)?;
    let grows = !options.rays_only && !options.no_growth && options.case.is_empty();
    for (at, case) in cases.iter().enumerate() {
        let after: f64 = cases[at + 1..].iter().map(weight).sum::<f64>() + if grows { 1.0 } else { 0.0 };
        let seconds = budget.share(weight(case), weight(case) + after);
        one_case(case, &engines, &plan, (&mut budget, seconds), options.rays_only, log, &mut record)?;
    }
    if grows {
        growth::run(&engines, &plan, &mut budget, log, &mut record)?;
    }
    Ok(record)
}

fn cases(options: &Options) -> Result<Vec<Case>, Failure> {
    let mut cases = Case::built_in()?;
    for path in &options.scenes {
        cases.push(Case::of_file(path)?);
    }
    cases.retain(|case| options.case.is_empty() || options.case.contains(&case.name));
    // The largest last: by then, build times can be predicted.
    cases.sort_by(|a, b| weight(a).total_cmp(&weight(b)));
    Ok(cases)
}

/// The weight of a case when the time of a quick run is shared out.
fn weight(case: &Case) -> f64 {
    if matches!(case.scene, crate::scene::SceneChoice::Race { .. }) { 4.0 } else { 1.0 }
}

fn one_case(
    case: &Case,
    engines: &[Box<dyn Engine>],
    plan: &Plan,
    (budget, seconds): (&mut Budget, f64),
    rays_only: bool,
    log: &mut Log,
    record: &mut Record,
) -> Result<(), Failure> {
    let mut scene = case.scene.open().map_err(|failure| format!("{}: {failure}", case.name))?;
    log.print(&format!("\n== {}: {} triangles", case.name, scene.soup.len()));
    let mut wanted: Vec<&dyn Engine> =
        engines.iter().map(|engine| &**engine).filter(|engine| case.wants(engine.name(), plan.quick)).collect();
    if !lineup::is_possible(&case.name, &wanted, scene.soup.len(), (&*budget, seconds * 0.6), log) {
        return Ok(());
    }
    let reference = Reference::of(&scene.soup)?;
    match &case.camera {
        Some(camera) => scene.camera = PinholeCamera::look_at(camera.position.into(), camera.target(), camera.half),
        None => scene.narrow_view(&|soup, rays| reference.closest(soup, rays)),
    }
    log.print(&format!("  seen from {}", scene.camera));
    let trace = |rays: &[Ray]| reference.closest(&scene.soup, rays);
    let sets = rays::sets(&scene, &case.sets, &|kind| case.count(kind, plan.quick), case.seed, &trace);
    // If time runs out, the less important engines are left out.
    wanted.sort_by_key(|engine| urgency(*engine));
    let from = record.rows.len();
    let soup = &scene.soup;
    let mut lineup = lineup::build(&case.name, &wanted, soup, (&mut *budget, seconds * 0.45), log, record)?;
    log.duration_of("scene, rays, trees");
    let checked = check::check(case, plan, soup, &reference, &sets, &mut lineup, log);
    record.kinetree_is_wrong |= checked.kinetree_is_wrong;
    record.some_engine_differs |= checked.some_engine_differs;
    log.duration_of("answers");
    let rows = &mut record.rows;
    traces::run(case, plan, &sets, &lineup, &checked.disagreements, seconds * 0.25, log, rows);
    log.duration_of("rays");
    wanted.retain(|engine| lineup.iter().any(|built| built.name == engine.name()));
    drop(lineup);
    if !rays_only {
        builds::run(&case.name, plan, &wanted, soup, (&*budget, seconds * 0.2), log, rows)?;
        if plan.quick && soup.len() > QUICK_TRIANGLES {
            log.print("  refits and builds by several threads are left to full runs: there are too many triangles");
        } else {
            refits::run(&case.name, plan, &wanted, soup, seconds * 0.05, log, rows)?;
        }
    }
    log.duration_of("builds and refits");
    log.print(&report::table(&record.rows[from..]));
    Ok(())
}

/// The order of engines: those that the goals are about come first.
fn urgency(engine: &dyn Engine) -> u32 {
    let leading = ["kinetree", "embree", "tinybvh"].iter().any(|start| engine.name().starts_with(start));
    u32::from(!leading) * 2 + u32::from(engine.class() == Class::Best)
}

fn write(options: &Options, record: &Record, log: &Log) -> Result<(), Failure> {
    let rows = &record.rows;
    let level = Level::current().name();
    let title = format!("{}, level {level}, {}", machine::processor(), machine::date());
    let chart = || report::chart(rows, &title);
    if let Some(path) = &options.json {
        save(path, &report::json(rows, level)?)?;
    }
    if let Some(path) = &options.svg {
        save(path, &chart())?;
    }
    if let Some(folder) = &options.results {
        let folder = folder.join(machine::folder_name()).join(level);
        let name = if options.quick { "quick" } else { "compare" };
        save(&folder.join(format!("{name}.json")), &report::json(rows, level)?)?;
        save(&folder.join(format!("{name}.svg")), &chart())?;
        save(&folder.join(format!("{name}.txt")), &log.text)?;
    }
    Ok(())
}

fn save(path: &Path, text: &str) -> Result<(), Failure> {
    let describe = |error: std::io::Error| format!("{}: {error}", path.display());
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(describe)?;
    }
    Ok(std::fs::write(path, text).map_err(describe)?)
}
