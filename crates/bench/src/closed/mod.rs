//! Rays from inside closed tubes and boxes. Every such ray crosses the surface, so a watertight
//! tracer must report a hit.

mod rays;
mod shape;
mod tally;

use std::path::PathBuf;

use kinetree::Coherence;
use kinetree::simd::Level;
use serde::Serialize;

use self::shape::Shape;
use self::tally::{DISTANCE_BOUND, Tally};
use crate::engine::{self, Engine, ThreadPool};
use crate::failure::Failure;
use crate::ray::{Answer, Ray};
use crate::soup::Soup;
use crate::{level, machine};

/// How many rays, and how they are made.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Options {
    /// How many rays
    #[arg(long, default_value_t = 10_000_000)]
    rays: usize,
    /// Forces every engine that can be forced to these instructions: scalar, avx2, avx512 or neon
    /// [default: the best of this machine]
    #[arg(long, value_name = "LEVEL", value_parser = level::by_name)]
    pub(crate) level: Option<Level>,
    /// The seed of shapes and rays
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Writes the counts as a JSON object
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// The number of rays for each shape.
const RAYS_PER_SHAPE: usize = 4096;

/// How rays are handed to an engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CallMode {
    Single,
    Batch,
}

/// What is tested: a name, the engines, and how rays are handed over. Where one name has several
/// engines, they take turns from shape to shape.
const TESTED: [(&str, &[&str], CallMode); 4] = [
    ("kinetree, single", &["kinetree fast", "kinetree best", "kinetree fastest"], CallMode::Single),
    ("kinetree, batch", &["kinetree fast", "kinetree best", "kinetree fastest"], CallMode::Batch),
    ("embree robust", &["embree medium robust"], CallMode::Single),
    ("embree", &["embree medium"], CallMode::Single),
];

/// The engines of one name, with their counts.
#[derive(Serialize)]
struct TestedEngine {
    engine: &'static str,
    instructions: String,
    #[serde(skip)]
    settings: Vec<usize>,
    #[serde(skip)]
    mode: CallMode,
    #[serde(flatten)]
    tally: Tally,
}

/// The JSON object with all counts.
#[derive(Serialize)]
struct Summary<'a> {
    processor: String,
    level: &'static str,
    date: String,
    seed: u64,
    shapes: u64,
    rays: usize,
    distance_bound: f64,
    engines: &'a [TestedEngine],
}

/// Counts wrong answers; true if kinetree gave none.
///
/// # Errors
/// An engine that cannot build, or results that cannot be written.
pub(crate) fn run(options: &Options) -> Result<bool, Failure> {
    let (engines, notes) = engine::all();
    let level = Level::current().name();
    println!("{}, level {level}, seed {}, {}", machine::processor(), options.seed, machine::date());
    notes.iter().filter(|note| note.contains("Embree")).for_each(|note| println!("{note}"));
    let mut tested: Vec<TestedEngine> = TESTED.iter().filter_map(|tested| tested_engine(&engines, tested)).collect();
    let shapes = options.rays.div_ceil(RAYS_PER_SHAPE) as u64;
    let pool = ThreadPool::new(1)?;
    for number in 0..shapes {
        let shape = Shape::new(options.seed, number);
        let rays = rays::rays(
            &shape,
            RAYS_PER_SHAPE.min(options.rays - number as usize * RAYS_PER_SHAPE),
            options.seed,
            number,
        );
        let exact = tally::exact_hits(&shape, &rays);
        for tested in &mut tested {
            let engine = &engines[tested.settings[number as usize % tested.settings.len()]];
            let answers = answers(&**engine, &pool, &shape.soup, &rays, tested.mode)?;
            tested.tally.count(number, &shape, &rays, &exact, &answers);
        }
        if shapes >= 10 && (number + 1) * 10 / shapes > number * 10 / shapes {
            eprintln!("{} %", (number + 1) * 100 / shapes);
        }
    }
    print!("{}", table(&tested));
    if let Some(path) = &options.json {
        let (seed, rays) = (options.seed, options.rays);
        let found = Summary {
            processor: machine::processor(),
            level,
            date: machine::date(),
            seed,
            shapes,
            rays,
            distance_bound: DISTANCE_BOUND,
            engines: &tested,
        };
        std::fs::write(path, serde_json::to_string_pretty(&found)?)
            .map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(tested.iter().all(|tested| !tested.engine.starts_with("kinetree") || tested.tally.is_clean()))
}

fn tested_engine(
    engines: &[Box<dyn Engine>],
    (name, settings, mode): &(&'static str, &[&str], CallMode),
) -> Option<TestedEngine> {
    let find = |setting: &&str| engines.iter().position(|engine| engine.name() == *setting);
    let settings: Vec<usize> = settings.iter().filter_map(find).collect();
    let instructions = engines[*settings.first()?].instructions().to_owned();
    Some(TestedEngine { engine: name, instructions, settings, mode: *mode, tally: Tally::default() })
}

fn answers(
    engine: &dyn Engine,
    pool: &ThreadPool,
    soup: &Soup,
    rays: &[Ray],
    mode: CallMode,
) -> Result<Vec<Answer>, Failure> {
    let tree = engine.prepare(soup)?.build(pool)?;
    let mut answers = vec![Answer::MISS; rays.len()];
    match mode {
        CallMode::Single => tree.closest(rays, &mut answers),
        CallMode::Batch => {
            let batches = tree.batches();
            let batch = batches.first().ok_or("it has no batches")?;
            batch.closest(rays, &mut answers, Coherence::Coherent);
        }
    }
    Ok(answers)
}

fn table(tested: &[TestedEngine]) -> String {
    let mut text = format!(
        "\n{:<18} {:<9} {:>11} {:>8} {:>11} {:>11} {:>12} {:>11} {:>12}\n",
        "", "", "rays", "slips", "false hits", "worst pass", "distances", "worst", "worst error"
    );
    text += &format!(
        "{:<18} {:<9} {:>11} {:>8} {:>11} {:>11} {:>12} {:>11} {:>12}\n",
        "", "", "", "", "", "/ half w.", "off > 2^-14", "part off", "/ half w."
    );
    for TestedEngine { engine, instructions, tally, .. } in tested {
        let Tally { rays, slips, false_hits, worst_pass, wrong_distances, worst_part, worst_error, .. } = tally;
        text += &format!(
            "{engine:<18} {instructions:<9} {rays:>11} {slips:>8} {false_hits:>11} {worst_pass:>11.1e} {wrong_distances:>12} {worst_part:>11.1e} {worst_error:>12.1e}\n"
        );
    }
    for TestedEngine { engine, tally, .. } in tested {
        let examples = [
            ("slip", tally.first_slip),
            ("false hit", tally.first_false_hit),
            ("distance", tally.first_wrong_distance),
        ];
        for (what, example) in examples.into_iter().filter_map(|(what, example)| Some((what, example?))) {
            text += &format!("first {what} of {engine}: {example:?}\n");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_and_rays_are_the_same_every_time() {
        let of = |seed, number| {
            let shape = Shape::new(seed, number);
            (rays::rays(&shape, 100, seed, number), shape.soup.positions)
        };
        assert_eq!(of(3, 5), of(3, 5));
        assert_ne!(of(3, 5).1, of(4, 5).1);
        assert_ne!(of(3, 5).1, of(3, 6).1);
    }
}
