//! `kinetree`, the command line: renders moving scenes, and reports what their trees are like.
//!
//! `args` declares the arguments, `scene` loads scenes, `render`, `inspect` and `bake` are the
//! commands. They use `camera` for the camera of a picture, `names`, `destination`, `partial_file`
//! and `file_id` for the files that they write, `output` for the standard streams, `baked_trees`
//! for files of trees, `progress` for the progress bar, and `summary`, `trees`, `figures`, `table`
//! and `memory` for what they report. `failure` is how a command fails.

mod args;
mod bake;
mod baked_trees;
mod camera;
mod destination;
mod partial_file;
mod failure;
mod figures;
mod file_id;
mod inspect;
mod memory;
mod names;
mod output;
mod progress;
mod render;
mod scene;
mod summary;
mod table;
mod trees;

use std::process::ExitCode;

use clap::Parser;
use kinetree::simd::Level;

use crate::args::{Args, Command, RenderArgs};
use crate::failure::Failure;

fn main() -> ExitCode {
    let args = Args::parse();
    match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            output::print_to_stderr(&format!("error: {failure}"));
            failure.exit_code()
        }
    }
}

/// Configures the global thread pool. More threads than cores would only compete.
fn use_threads(asked_for: u32, quiet: bool) -> Result<(), Failure> {
    let asked_for = usize::try_from(asked_for).unwrap_or(usize::MAX);
    let cores = std::thread::available_parallelism().map_or(1, Into::into);
    let count = asked_for.min(cores);
    if count < asked_for && !quiet {
        output::print_to_stderr(&format!(
            "note: {asked_for} threads were asked for; {count} are used, one for each core"
        ));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count);
    pool.build_global().map_err(|error| Failure::work(format!("{count} threads cannot be had: {error}")))
}

fn run(args: &Args) -> Result<(), Failure> {
    Level::from_environment().map_err(|error| Failure::arguments(error.to_string()))?;
    if let Some(count) = args.common.threads {
        use_threads(count, args.common.quiet)?;
    }
    match &args.command {
        Some(Command::Render(render)) => render::run(render, &args.common),
        Some(Command::Inspect(inspect)) => inspect::run(inspect, &args.common),
        Some(Command::Bake(bake)) => bake::run(bake, &args.common),
        None => {
            let race = RenderArgs::built_in_race();
            if !args.common.quiet {
                output::print_to_stderr("no window in this build yet: rendering the built-in race to race.png");
            }
            render::run(&race, &args.common)
        }
    }
}
