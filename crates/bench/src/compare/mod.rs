//! The whole comparison: case by case, answers before times.

mod budget;
mod builds;
mod check;
mod lineup;
mod growth;
mod log;
mod processes;
mod refits;
mod traces;

use std::path::{Path, PathBuf};

use kinetree::simd::Level;

use self::budget::Budget;
use self::log::Log;
use crate::case::Case;
use crate::engine::{self, Class, Engine, Reference};
use crate::failure::Failure;
use crate::level;
use crate::machine;
use crate::measure::rounds::Rounds;
use crate::ray::Ray;
use crate::rays;
use crate::report::{self, Record};
use crate::scene::PinholeCamera;

/// What is compared, and where results go.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Options {
    /// More scenes (.glb, .gltf) or case files (.toml), beside those that come with the program
    scenes: Vec<PathBuf>,
    /// Forces every engine that can to these instructions: scalar, avx2, avx512 or neon [default: the best of this machine]
    #[arg(long, value_name = "LEVEL", value_parser = level::named)]
    pub(crate) level: Option<Level>,
    /// Fewer rays and rounds: ends within five minutes
    #[arg(long)]
    quick: bool,
    /// Writes the rows as a JSON array
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes the chart
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Only cases with these names
    #[arg(long, value_name = "NAME")]
    case: Vec<String>,
    /// Only engines whose names begin so
    #[arg(long, value_name = "NAME")]
    engine: Vec<String>,
    /// Rounds of measurement in each process [default: 9, or 5 when quick]
    #[arg(long)]
    rounds: Option<usize>,
    /// Measures all of it so many times, each in a process of its own, for bounds that count what differs between processes
    #[arg(long, default_value_t = 1, value_name = "NUMBER")]
    processes: usize,
    /// Only rays: no builds, refits or growth
    #[arg(long)]
    rays_only: bool,
    /// No growth of cost with the number of triangles, which is measured unless cases are picked by name
    #[arg(long)]
    no_growth: bool,
    /// Keeps table, rows and chart in a folder of the machine's name and the level within this one, too
    #[arg(long, value_name = "FOLDER")]
    results: Option<PathBuf>,
    /// Where a process leaves what it has measured for the one that started it
    #[arg(long, hide = true, value_name = "FILE")]
    part: Option<PathBuf>,
    /// Which process it is, the first being 0
    #[arg(long, hide = true, default_value_t = 0)]
    number: usize,
}

/// The most triangles that are refitted, or built by several threads, in a quick run.
pub(crate) const QUICK_TRIANGLES: usize = 700_000;

/// What all parts of a comparison need to know.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plan {
    quick: bool,
    /// Whether this is the first process: what is always the same is done in that one only.
    first: bool,
    /// Of rays.
    rounds: Rounds,
    /// Of builds and refits, which take longer.
    builds: Rounds,
    /// All that the machine has.
    threads: usize,
}

impl Plan {
    fn of(options: &Options) -> Self {
        let rounds = options.rounds.unwrap_or(if options.quick { 5 } else { 9 }).max(1);
        let seconds = f64::INFINITY;
        // Of those who are far behind, three rounds in all are enough.
        let behind = if options.quick || options.processes > 1 { 1 } else { rounds.min(3) };
        Self {
            quick: options.quick,
            first: options.number == 0,
            rounds: Rounds { full: rounds, behind, seconds, warm_up: true },
            // Every tree has been built once before.
            builds: Rounds {
                full: if options.quick { rounds.min(3) } else { rounds },
                behind,
                seconds,
                warm_up: false,
            },
            threads: machine::threads(),
        }
    }

    #[cfg(test)]
    fn minimal() -> Self {
        let rounds = Rounds { full: 1, behind: 1, seconds: f64::INFINITY, warm_up: false };
        Self { quick: true, first: true, rounds, builds: rounds, threads: 1 }
    }
}

/// Compares, and tells whether all answers of ours were right.
///
/// # Errors
/// A scene that cannot be opened, or results that cannot be written.
pub(crate) fn run(options: &Options) -> Result<bool, Failure> {
    let mut log = Log::default();
    let record = if options.part.is_none() && options.processes > 1 {
        let record = processes::run(options.processes)?;
        log.text.push_str(&record.text);
        log.say("\n#### all processes together");
        log.say(&report::table(&record.rows));
        record
    } else {
        measure(options, &mut log)?
    };
    if let Some(part) = &options.part {
        save(part, &serde_json::to_string(&Record { text: log.text, ..record })?)?;
        return Ok(true);
    }
    log.say(&report::goals(&record, Level::current().name(), machine::second_cache()));
    log.say(match (record.kinetree_is_wrong, record.some_engine_differs) {
        (true, _) => "NOT all answers of kinetree are right",
        (false, true) => "all answers of kinetree are right; those of others that differ are counted above",
        (false, false) => "every engine agrees with the reference",
    });
    write(options, &record, &log)?;
    Ok(!record.kinetree_is_wrong)
}

/// In this process.
fn measure(options: &Options, log: &mut Log) -> Result<Record, Failure> {
    let plan = Plan::of(options);
    let mut budget = Budget::new(options.quick);
    let (mut engines, notes) = engine::all();
    let asked =
        |name: &str| options.engine.is_empty() || options.engine.iter().any(|start| name.starts_with(start.as_str()));
    engines.retain(|engine| asked(engine.name()));
    let (processor, level, date) = (machine::processor(), Level::current().name(), machine::date());
    log.say(&format!("{processor}, {} threads, level {level}, {date}", plan.threads));
    log.say(&machine::versions());
    notes.iter().for_each(|note| log.say(note));

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
    // The largest last: by then it is known how long builds take.
    cases.sort_by(|a, b| weight(a).total_cmp(&weight(b)));
    Ok(cases)
}

/// How much of a quick run's time a case is given.
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
    log.say(&format!("\n== {}: {} triangles", case.name, scene.soup.len()));
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
    log.say(&format!("  seen from {}", scene.camera));
    let trace = |rays: &[Ray]| reference.closest(&scene.soup, rays);
    let sets = rays::sets(&scene, &case.sets, &|kind| case.count(kind, plan.quick), case.seed, &trace);
    // Should time run out, it does so for those who matter less.
    wanted.sort_by_key(|engine| urgency(*engine));
    let from = record.rows.len();
    let soup = &scene.soup;
    let mut lineup = lineup::build(&case.name, &wanted, soup, (&mut *budget, seconds * 0.45), log, record)?;
    log.took("scene, rays, trees");
    let checked = check::check(case, plan, soup, &reference, &sets, &mut lineup, log);
    record.kinetree_is_wrong |= checked.kinetree_is_wrong;
    record.some_engine_differs |= checked.some_engine_differs;
    log.took("answers");
    let rows = &mut record.rows;
    traces::run(case, plan, &sets, &lineup, &checked.disagreements, seconds * 0.25, log, rows);
    log.took("rays");
    wanted.retain(|engine| lineup.iter().any(|built| built.name == engine.name()));
    drop(lineup);
    if !rays_only {
        builds::run(&case.name, plan, &wanted, soup, (&*budget, seconds * 0.2), log, rows)?;
        if plan.quick && soup.len() > QUICK_TRIANGLES {
            log.say("  refits and builds by several threads are left to full runs: there are too many triangles");
        } else {
            refits::run(&case.name, plan, &wanted, soup, seconds * 0.05, log, rows)?;
        }
    }
    log.took("builds and refits");
    log.say(&report::table(&record.rows[from..]));
    Ok(())
}

/// First those that the goals are about.
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
