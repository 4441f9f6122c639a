//! kinetree beside the other CPU ray tracers.
//!
//! ```text
//! cargo run --release -p kinetree-bench -- fetch-peers
//! cargo run --release -p kinetree-bench -- compare [SCENES.glb ...] [--level avx2] [--quick] [--processes 3] [--json FILE] [--results FOLDER]
//! ```
//!
//! All engines are in one process. They get the same triangles and the same rays, made once per
//! scene from a seed; their answers are compared with the reference before a time is believed; then
//! they run in turn, round by round, so that a machine that changes its mind changes it for all of
//! them. One-thread times are those of the thread's processor clock, pinned to a core.
//!
//! The map: `case` says what is measured, `scene` makes or loads triangles (`soup`), `rays` makes
//! sets of rays, `engine` holds the engines behind one trait, `level` forces them to one set of
//! instructions, `agree` compares answers, `exact` says which are right, `measure` has clocks and
//! statistics, `compare` runs it all, `closed` counts what slips out of closed shapes, `report`
//! writes it down, `peers` fetches what is opened at run time.

mod agree;
mod case;
mod rng;
mod closed;
mod compare;
mod engine;
mod exact;
mod failure;
mod level;
mod machine;
mod measure;
mod peers;
mod ray;
mod rays;
mod report;
mod scene;
mod soup;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::failure::Failure;

#[global_allocator]
static ALLOCATOR: measure::memory::Counting = measure::memory::Counting;

#[derive(Parser)]
#[command(about = "kinetree beside the other CPU ray tracers: the same rays, answers compared before times")]
struct Arguments {
    #[command(subcommand)]
    command: Job,
}

#[derive(Subcommand)]
enum Job {
    /// Measures all engines on the built-in scenes and on those given
    Compare(Box<compare::Options>),
    /// Counts what rays from inside closed tubes and boxes do: slips, false hits, wrong distances
    Closed(closed::Options),
    /// Downloads Embree (through pip) and unpacks it where `compare` finds it
    FetchPeers,
    /// Lists the engines that can be measured here
    Engines,
}

fn main() -> ExitCode {
    match run(Arguments::parse().command) {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn run(job: Job) -> Result<ExitCode, Failure> {
    match job {
        Job::Compare(options) => {
            if let Some(code) = level::elsewhere(options.level)? {
                return Ok(code);
            }
            return Ok(if compare::run(&options)? { ExitCode::SUCCESS } else { ExitCode::from(2) });
        }
        Job::Closed(options) => {
            if let Some(code) = level::elsewhere(options.level)? {
                return Ok(code);
            }
            return Ok(if closed::run(&options)? { ExitCode::SUCCESS } else { ExitCode::from(2) });
        }
        Job::FetchPeers => peers::fetch()?.iter().for_each(|path| println!("{}", path.display())),
        Job::Engines => {
            let (engines, notes) = engine::all();
            engines.iter().for_each(|engine| println!("{}", engine.name()));
            notes.iter().for_each(|note| eprintln!("{note}"));
        }
    }
    Ok(ExitCode::SUCCESS)
}
