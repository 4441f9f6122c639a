//! kinetree beside the other CPU ray tracers.
//!
//! ```text
//! cargo run --release -p kinetree-bench -- fetch-peers
//! cargo run --release -p kinetree-bench -- compare [SCENES.glb ...] [--level avx2] [--quick] \
//!     [--processes 3] [--json FILE] [--results FOLDER]
//! ```
//!
//! All engines run in one process. They get the same triangles and the same rays, generated once
//! per scene from a seed. Their answers are compared with the reference before anything is timed;
//! then they run in turn, round by round, so that changes of the clock frequency affect all of
//! them. On one thread, processor time is measured, pinned to a core.
//!
//! The modules: `case` describes what is measured, `scene` generates or loads triangles (`soup`),
//! `rays` generates sets of rays with the random numbers of `rng`, `engine` holds the engines
//! behind one interface, `level` forces them to one set of instructions, `agree` compares answers,
//! `exact` computes the right ones, `measure` has clocks and statistics, `compare` runs it all,
//! `closed` counts wrong answers in closed shapes, `report` writes the results, `machine` names the
//! machine, `peers` downloads the libraries that are loaded at run time.

mod agree;
mod case;
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
mod rng;
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
    /// Counts wrong answers to rays from inside closed tubes and boxes: slips, false hits, wrong
    /// distances
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
            if let Some(code) = level::rerun_at(options.level)? {
                return Ok(code);
            }
            return Ok(if compare::run(&options)? { ExitCode::SUCCESS } else { ExitCode::from(2) });
        }
        Job::Closed(options) => {
            if let Some(code) = level::rerun_at(options.level)? {
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
