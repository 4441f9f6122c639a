//! The command line arguments.

use std::ops::Range;
use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{ArgAction, Parser, Subcommand};
use kinetree_gltf::Clip;
use kinetree_render::{IntegratorKind, MAX_PIXELS, MAX_SIDE};

use crate::camera::CameraChoice;

/// Ray tracing for scenes that move.
///
/// Opens a glTF 2.0 scene (.glb, .gltf) or the built-in race, updates its acceleration structures
/// for every frame, and renders it or reports what its trees are like. Without a command, renders
/// the race to race.png.
#[derive(Debug, Parser)]
#[command(name = "kinetree", version, propagate_version = true, after_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) common: Common,
}

const EXAMPLES: &str = "\
Examples:
  kinetree                                              the built-in race, to race.png
  kinetree render town.glb --time 2.5 --out town.png    a scene at 2.5 seconds
  kinetree inspect town.glb                             its meshes and trees
  kinetree bake town.glb --out town.trees               its trees, built once at best quality";

/// Options that every command has.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Options of every command")]
pub(crate) struct Common {
    /// Use at most N threads, and never more than there are cores [default: one for each core]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) threads: Option<u32>,
    /// Print all figures as one JSON object
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Print nothing but errors, and JSON if it is requested
    #[arg(long, short, global = true, action = ArgAction::SetTrue)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene
    #[command(after_help = RENDER_EXAMPLES)]
    Render(RenderArgs),
    /// Report what a scene consists of, and check every tree
    #[command(after_help = INSPECT_EXAMPLES)]
    Inspect(InspectArgs),
    /// Build the trees of a scene's static and rigid meshes at best quality, once, into a file
    #[command(after_help = BAKE_EXAMPLES)]
    Bake(BakeArgs),
}

const RENDER_EXAMPLES: &str = "\
Examples:
  kinetree render --time 4 --camera chase --out chase.png
  kinetree render town.glb --size 1920x1080 --spp 256
  kinetree render town.glb --camera 4,2,6:0,1,0:40 --exposure 1
  kinetree render town.glb --frames 0..24 --fps 12 --out lap/%04d.png
  kinetree render town.glb --integrator heatmap --out heat.png --json
  kinetree render town.glb --trees town.trees --out town.png

A file name may contain one %04d (or %d, %02d, ...), which stands for the number of the frame. Missing folders are
created. Files appear whole or not at all; symbolic links are followed. The picture may be written to a pipe or a
device, such as /dev/stdout; the summary goes to standard error then. Files that are read are never overwritten. The
same seed gives the same picture for any number of threads.";

const INSPECT_EXAMPLES: &str = "\
Examples:
  kinetree inspect
  kinetree inspect town.glb --time 2.5 --all
  kinetree inspect town.glb --json
  kinetree inspect town.glb --trees town.trees

Ends with exit code 1 when any tree breaks one of its promises.";

const BAKE_EXAMPLES: &str = "\
Examples:
  kinetree bake --out race.trees
  kinetree bake town.glb --out town.trees
  kinetree render town.glb --trees town.trees --out town.png

With trees from a file, loading builds no static or rigid trees, and rays are traced faster. Each tree is bound to its
mesh: when the scene changes, bake again. The file has no trees of deforming and dynamic meshes. It appears whole or
not at all; it may also be a pipe or a device, such as /dev/stdout.";

/// Arguments of `kinetree render`.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct RenderArgs {
    /// A glTF 2.0 file (.glb or .gltf) [default: the built-in race]
    pub(crate) scene: Option<PathBuf>,
    /// The picture to write, a .png [default: the scene's name in the current directory]
    #[arg(long, short, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// The time to show, in seconds
    #[arg(long, value_name = "S", default_value = "0", value_parser = seconds, allow_hyphen_values = true)]
    pub(crate) time: f64,
    /// Render the frames A to B - 1; frame N shows the time N / fps
    #[arg(long, value_name = "A..B", value_parser = frames, conflicts_with = "time")]
    pub(crate) frames: Option<Range<u32>>,
    /// Frames per second of the scene's time
    #[arg(long, value_name = "N", default_value = "24", value_parser = frames_per_second, requires = "frames")]
    pub(crate) fps: f64,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub(crate) size: [u32; 2],
    /// Samples per pixel: four times as many halve the noise
    #[arg(long, value_name = "N", default_value = "16", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) spp: u32,
    /// The seed of the random numbers, which changes the noise
    #[arg(long, value_name = "N", default_value = "0")]
    pub(crate) seed: u64,
    /// A camera of the scene by name; or a position, a target and the vertical field of view in
    /// degrees, 50 by default [default: the first camera of the scene, or one that shows most of
    /// it]
    #[arg(long, value_name = "NAME|px,py,pz:tx,ty,tz[:fov]", allow_hyphen_values = true)]
    pub(crate) camera: Option<CameraChoice>,
    /// What the picture shows
    #[arg(long, value_name = "KIND", default_value = "path", value_parser = integrators())]
    pub(crate) integrator: IntegratorKind,
    /// Exposure; each step of one doubles the brightness [default: automatic, and the first frame's
    /// for all frames]
    #[arg(long, value_name = "EV", value_parser = exposure_value, allow_hyphen_values = true)]
    pub(crate) exposure: Option<f32>,
    /// Play one animation of the file, by its name or its number from 0 [default: the first, and
    /// all that move other nodes]
    #[arg(long, value_name = "NAME|N", value_parser = clip, requires = "scene")]
    pub(crate) clip: Option<Clip>,
    /// Take the trees of static and rigid meshes from a file that `kinetree bake` made
    #[arg(long, value_name = "TREES")]
    pub(crate) trees: Option<PathBuf>,
}

impl RenderArgs {
    /// The arguments when the program is called without any: a picture that two cores render in a
    /// minute or two.
    pub(crate) fn built_in_race() -> Self {
        Self {
            scene: None,
            out: Some("race.png".into()),
            time: 0.0,
            frames: None,
            fps: 24.0,
            size: [960, 540],
            spp: 32,
            seed: 0,
            camera: None,
            integrator: IntegratorKind::Path,
            exposure: None,
            clip: None,
            trees: None,
        }
    }
}

/// Arguments of `kinetree inspect`.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct InspectArgs {
    /// A glTF 2.0 file (.glb or .gltf) [default: the built-in race]
    pub(crate) scene: Option<PathBuf>,
    /// The time to inspect, in seconds
    #[arg(long, value_name = "S", default_value = "0", value_parser = seconds, allow_hyphen_values = true)]
    pub(crate) time: f64,
    /// List all meshes, not only the largest
    #[arg(long)]
    pub(crate) all: bool,
    /// Play one animation of the file, by its name or its number from 0 [default: the first, and
    /// all that move other nodes]
    #[arg(long, value_name = "NAME|N", value_parser = clip, requires = "scene")]
    pub(crate) clip: Option<Clip>,
    /// Take the trees of static and rigid meshes from a file that `kinetree bake` made
    #[arg(long, value_name = "TREES")]
    pub(crate) trees: Option<PathBuf>,
}

/// Arguments of `kinetree bake`.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct BakeArgs {
    /// A glTF 2.0 file (.glb or .gltf) [default: the built-in race]
    pub(crate) scene: Option<PathBuf>,
    /// The animation that will be played, by its name or its number from 0 [default: as in
    /// `kinetree render`]
    #[arg(long, value_name = "NAME|N", value_parser = clip, requires = "scene")]
    pub(crate) clip: Option<Clip>,
    /// The file to write [default: the scene's name with .trees, in the current directory]
    #[arg(long, short, value_name = "TREES")]
    pub(crate) out: Option<PathBuf>,
}

fn integrators() -> impl TypedValueParser<Value = IntegratorKind> {
    PossibleValuesParser::new(IntegratorKind::ALL.map(IntegratorKind::name)).try_map(|name| name.parse())
}

fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| "not a number".into())
}

fn seconds(text: &str) -> Result<f64, String> {
    finite(text)
}

fn frames_per_second(text: &str) -> Result<f64, String> {
    finite(text).and_then(|fps| if fps > 0.0 { Ok(fps) } else { Err("must be more than 0".into()) })
}

/// A number is an index into the file's animations; anything else is a name.
fn clip(text: &str) -> Result<Clip, String> {
    Ok(text.parse().map_or_else(|_| Clip::Name(text.to_owned()), Clip::Index))
}

fn exposure_value(text: &str) -> Result<f32, String> {
    let value = finite(text)? as f32;
    if value.abs() <= 30.0 { Ok(value) } else { Err("goes from -30 to 30".into()) }
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let [width, height]: [u32; 2] = sides.ok_or("write it as WIDTHxHEIGHT, such as 960x540")?;
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(format!("sides go from 1 to {MAX_SIDE}"));
    }
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(format!("there can be {MAX_PIXELS} pixels at most"));
    }
    Ok([width, height])
}

fn frames(text: &str) -> Result<Range<u32>, String> {
    let ends = text.split_once("..").and_then(|(a, b)| Some(a.parse().ok()?..b.parse().ok()?));
    let range: Range<u32> = ends.ok_or("write it as FIRST..END, such as 0..24, which is 24 frames")?;
    if range.is_empty() { Err("the end comes after the first, and is not included".into()) } else { Ok(range) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn sizes_and_frames_are_what_they_say_or_refused() {
        assert_eq!(size("960x540"), Ok([960, 540]));
        assert_eq!(frames("3..24"), Ok(3..24));
        for wrong in ["", "x", "960", "0x5", "5x0", "-1x5", "70000x1", "65536x65536", "1x2x3", "99999999999x1"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
        for wrong in ["", "..", "5", "5..5", "6..5", "-1..5", "0..=5", "0..99999999999"] {
            assert!(frames(wrong).is_err(), "{wrong}");
        }
        for wrong in ["nan", "inf", "", "1s"] {
            assert!(seconds(wrong).is_err() && frames_per_second(wrong).is_err() && exposure_value(wrong).is_err());
        }
        assert!(frames_per_second("0").is_err() && exposure_value("31").is_err() && seconds("-1.5").is_ok());
    }

    #[test]
    fn the_picture_of_the_race_is_one_that_could_be_asked_for() {
        let asked =
            Args::try_parse_from(["kinetree", "render", "--out", "race.png", "--size", "960x540", "--spp", "32"]);
        let Some(Command::Render(asked)) = asked.unwrap().command else { panic!("render was asked for") };
        assert_eq!(format!("{asked:?}"), format!("{:?}", RenderArgs::built_in_race()));
    }
}
