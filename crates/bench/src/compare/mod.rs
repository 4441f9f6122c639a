//! The whole comparison: case by case, answers before times.

mod builds;
mod check;
mod field;
mod growth;
mod refits;
mod traces;

use std::path::{Path, PathBuf};

use crate::Failure;
use crate::case::Case;
use crate::engine::{self, Engine, ours};
use crate::machine;
use crate::measure::rounds::Rounds;
use crate::rays;
use crate::report::{self, Row};

/// What is compared, and where results go.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Options {
    /// More scenes (.glb, .gltf) or case files (.toml), beside those that come with the program
    scenes: Vec<PathBuf>,
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
    /// Rounds of measurement [default: 9, or 5 when quick]
    #[arg(long)]
    rounds: Option<usize>,
    /// Only rays: no builds, refits or growth
    #[arg(long)]
    rays_only: bool,
    /// Keeps table, rows and chart in a folder of the machine's name within this one, too
    #[arg(long, value_name = "FOLDER")]
    results: Option<PathBuf>,
}

/// The most triangles that are refitted, or built by several threads, in a quick run.
pub(crate) const QUICK_TRIANGLES: usize = 700_000;

/// What all parts of a comparison need to know.
pub(crate) struct Plan {
    quick: bool,
    /// Of rays.
    rounds: Rounds,
    /// Of builds and refits, which take longer.
    builds: Rounds,
    /// All that the machine has.
    threads: usize,
}

/// Compares, and tells whether every engine agreed with the reference.
///
/// # Errors
/// A scene that cannot be opened, or results that cannot be written.
pub(crate) fn run(options: &Options) -> Result<bool, Failure> {
    let rounds = options.rounds.unwrap_or(if options.quick { 5 } else { 9 }).max(1);
    let plan = Plan {
        quick: options.quick,
        rounds: Rounds { full: rounds, behind: rounds.min(if options.quick { 1 } else { 3 }), warm_up: true },
        // Every tree has been built once before.
        builds: Rounds {
            full: if options.quick { 1 } else { rounds },
            behind: if options.quick { 1 } else { rounds.min(3) },
            warm_up: false,
        },
        threads: machine::threads(),
    };
    let (mut engines, notes) = engine::all();
    let asked =
        |name: &str| options.engine.is_empty() || options.engine.iter().any(|start| name.starts_with(start.as_str()));
    engines.retain(|engine| asked(engine.name()));
    let mut log = Log::default();
    log.say(&format!("{}, {} threads, {}", machine::processor(), plan.threads, machine::date()));
    notes.iter().for_each(|note| log.say(note));

    let mut rows = Vec::new();
    let mut agreed = true;
    for case in cases(options)? {
        agreed &= one_case(&case, &engines, &plan, options.rays_only, &mut log, &mut rows)?;
    }
    if !options.rays_only && options.case.is_empty() {
        growth::run(&engines, &plan, &mut log, &mut rows)?;
    }
    log.say(&report::means(&rows));
    log.say(if agreed {
        "every engine agrees with the reference"
    } else {
        "NOT every engine agrees with the reference"
    });
    write(options, &rows, &log)?;
    Ok(agreed)
}

fn cases(options: &Options) -> Result<Vec<Case>, Failure> {
    let mut cases = Case::built_in()?;
    for path in &options.scenes {
        cases.push(Case::of_file(path)?);
    }
    cases.retain(|case| options.case.is_empty() || options.case.contains(&case.name));
    Ok(cases)
}

fn one_case(
    case: &Case,
    engines: &[Box<dyn Engine>],
    plan: &Plan,
    rays_only: bool,
    log: &mut Log,
    rows: &mut Vec<Row>,
) -> Result<bool, Failure> {
    let scenery = case.scene.open().map_err(|failure| format!("{}: {failure}", case.name))?;
    log.say(&format!("\n== {}: {} triangles", case.name, scenery.soup.len()));
    let reference = ours::Reference::of(&scenery.soup)?;
    let count = if plan.quick { case.quick_rays } else { case.rays };
    let sets = rays::sets(&scenery, &case.sets, count, case.seed, &|rays| reference.closest(rays));
    let wanted: Vec<&dyn Engine> =
        engines.iter().map(|engine| &**engine).filter(|engine| case.wants(engine.name(), plan.quick)).collect();
    let from = rows.len();
    let mut field = field::build(&case.name, &wanted, &scenery.soup, log, rows)?;
    log.took("scene, rays, trees");
    field::describe(&field, log);
    let agreed = check::check(case, plan, &scenery.soup, &reference, &sets, &mut field, log);
    log.took("answers");
    traces::run(case, plan, &sets, &field, log, rows)?;
    log.took("rays");
    drop(field);
    if !rays_only {
        builds::run(&case.name, plan, &wanted, &scenery.soup, rows)?;
        if plan.quick && scenery.soup.len() > QUICK_TRIANGLES {
            log.say("  refits and builds by several threads are left to full runs: there are too many triangles");
        } else {
            refits::run(&case.name, plan, &wanted, &scenery.soup, log, rows)?;
        }
    }
    log.took("builds and refits");
    log.say(&report::table(&rows[from..]));
    Ok(agreed)
}

/// What is said, kept for the file.
pub(crate) struct Log {
    text: String,
    since: std::time::Instant,
}

impl Default for Log {
    fn default() -> Self {
        Self { text: String::new(), since: std::time::Instant::now() }
    }
}

impl Log {
    /// Prints a line, and keeps it.
    pub(crate) fn say(&mut self, line: &str) {
        println!("{line}");
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// Says how long a part took, since the last one.
    pub(crate) fn took(&mut self, part: &str) {
        self.say(&format!("  [{part}: {:.1} s]", self.since.elapsed().as_secs_f64()));
        self.since = std::time::Instant::now();
    }
}

fn write(options: &Options, rows: &[Row], log: &Log) -> Result<(), Failure> {
    let json = || serde_json::to_string_pretty(rows);
    let title = format!("{}, {}", machine::processor(), machine::date());
    let chart = || report::chart(rows, &title);
    if let Some(path) = &options.json {
        save(path, &json()?)?;
    }
    if let Some(path) = &options.svg {
        save(path, &chart())?;
    }
    if let Some(folder) = &options.results {
        let folder = folder.join(machine::folder_name());
        let name = if options.quick { "quick" } else { "compare" };
        save(&folder.join(format!("{name}.json")), &json()?)?;
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
