//! `kinetree`, the command line: pictures of moving scenes, and what their trees look like.
//!
//! `args` is what one can say, `scene` opens what is spoken of, `render`, `inspect` and `bake` do the work. For them, `camera` finds
//! who looks, `names` and `output` put files in their places, `tree_file` keeps trees for later, `progress` keeps people patient, and `summary`, `trees` and
//! `figures` tell what came of it. `failure` is how all of it ends when it ends badly.

mod args;
mod bake;
mod camera;
mod failure;
mod figures;
mod inspect;
mod memory;
mod names;
mod output;
mod progress;
mod render;
mod scene;
mod summary;
mod table;
mod tree_file;
mod trees;

use std::process::ExitCode;

use clap::Parser;

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

fn run(args: &Args) -> Result<(), Failure> {
    if let Some(count) = args.common.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count.into());
        pool.build_global().map_err(|error| Failure::work(format!("{count} threads cannot be had: {error}")))?;
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
