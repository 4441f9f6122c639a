//! `kinetree`, the command line: pictures of moving scenes, and what their trees look like.
//!
//! `args` is what one can say, `scene` opens what is spoken of, `render`, `inspect` and `bake` do the work. For them, `camera` finds
//! who looks, `names`, `destination`, `draft` and `file_id` put files in their places, `output`
//! speaks, `baked_trees` reads trees from files, `progress` keeps people patient, and `summary`,
//! `trees` and `figures` tell what came of it. `failure` is how all of it ends when it ends badly.

mod args;
mod bake;
mod baked_trees;
mod camera;
mod destination;
mod draft;
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
            output::remark(&format!("error: {failure}"));
            failure.exit_code()
        }
    }
}

/// Makes the pool of the process: more threads than cores would only take turns.
fn use_threads(asked_for: u32, quiet: bool) -> Result<(), Failure> {
    let asked_for = usize::try_from(asked_for).unwrap_or(usize::MAX);
    let cores = std::thread::available_parallelism().map_or(1, Into::into);
    let count = asked_for.min(cores);
    if count < asked_for && !quiet {
        output::remark(&format!("note: {asked_for} threads were asked for; {count} are used, one for each core"));
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
                output::remark("no window in this build yet: rendering the built-in race to race.png");
            }
            render::run(&race, &args.common)
        }
    }
}
