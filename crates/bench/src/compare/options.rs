//! What `compare` can be told on the command line.

use std::path::PathBuf;

use kinetree::simd::Level;

use crate::level;

/// What is compared, and where results go.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Options {
    /// More scenes (.glb, .gltf) or case files (.toml), beside those that come with the program
    pub(super) scenes: Vec<PathBuf>,
    /// Forces every engine that can to these instructions: scalar, avx2, avx512 or neon [default: the best of this machine]
    #[arg(long, value_name = "LEVEL", value_parser = level::named)]
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
    /// Only engines whose names begin so
    #[arg(long, value_name = "NAME")]
    pub(super) engine: Vec<String>,
    /// Rounds of measurement in each process [default: 9, or 5 when quick]
    #[arg(long)]
    pub(super) rounds: Option<usize>,
    /// Measures all of it so many times, each in a process of its own, for bounds that count what differs between processes
    #[arg(long, default_value_t = 1, value_name = "NUMBER")]
    pub(super) processes: usize,
    /// Only rays: no builds, refits or growth
    #[arg(long)]
    pub(super) rays_only: bool,
    /// No growth of cost with the number of triangles, which is measured unless cases are picked by name
    #[arg(long)]
    pub(super) no_growth: bool,
    /// Keeps table, rows and chart in a folder of the machine's name and the level within this one, too
    #[arg(long, value_name = "FOLDER")]
    pub(super) results: Option<PathBuf>,
    /// Where a process leaves what it has measured for the one that started it
    #[arg(long, hide = true, value_name = "FILE")]
    pub(super) part: Option<PathBuf>,
    /// Which process it is, the first being 0
    #[arg(long, hide = true, default_value_t = 0)]
    pub(super) number: usize,
}
