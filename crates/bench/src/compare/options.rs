//! The command line options of `compare`.

use std::path::PathBuf;

use kinetree::simd::Level;

use crate::level;

/// What is compared, and where results go.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Options {
    /// More scenes (.glb, .gltf) or case files (.toml), beside those that come with the program
    pub(super) scenes: Vec<PathBuf>,
    /// Forces every engine that can be forced to these instructions: scalar, avx2, avx512 or neon
    /// [default: the best of this machine]
    #[arg(long, value_name = "LEVEL", value_parser = level::by_name)]
    pub(crate) level: Option<Level>,
    /// Fewer rays and rounds: ends within five minutes
    #[arg(long)]
    pub(super) quick: bool,
    /// Writes the rows as a JSON array
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Writes the chart
    #[arg(long, value_name = "FILE")]
    pub(super) svg: Option<PathBuf>,
    /// Only cases with these names
    #[arg(long, value_name = "NAME")]
    pub(super) case: Vec<String>,
    /// Only engines whose names begin with this
    #[arg(long, value_name = "NAME")]
    pub(super) engine: Vec<String>,
    /// Rounds of measurement in each process [default: 9, or 5 when quick]
    #[arg(long)]
    pub(super) rounds: Option<usize>,
    /// Repeats the measurement in this many processes, so that the bounds include what differs
    /// between processes
    #[arg(long, default_value_t = 1, value_name = "NUMBER")]
    pub(super) processes: usize,
    /// Only rays: no builds, refits or growth
    #[arg(long)]
    pub(super) rays_only: bool,
    /// Skips the growth of times with the number of triangles, which is measured unless cases are
    /// picked by name
    #[arg(long)]
    pub(super) no_growth: bool,
    /// Also writes log, rows and chart to a folder named after machine and level within this one
    #[arg(long, value_name = "FOLDER")]
    pub(super) results: Option<PathBuf>,
    /// The file in which a child process leaves its measurements for its parent
    #[arg(long, hide = true, value_name = "FILE")]
    pub(super) part: Option<PathBuf>,
    /// The index of this child process
    #[arg(long, hide = true, default_value_t = 0)]
    pub(super) number: usize,
}
