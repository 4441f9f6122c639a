//! Opens what is spoken of: a file, or the race that is built in.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use kinetree::FrameReport;
use kinetree_gltf::{Clip, ClipInfo, Options};
use kinetree_render::default_lighting;
use kinetree_world::{Frame, World};

use crate::baked_trees::BakedTrees;
use crate::failure::Failure;

/// A scene that is ready for any moment.
pub(crate) struct Opened {
    /// What to call it in messages: the path as given, or "the built-in race".
    pub(crate) name: String,
    pub(crate) world: World,
    /// What was ignored or repaired, one line each.
    pub(crate) notes: Vec<String>,
    /// The animations of the file.
    pub(crate) clips: Vec<ClipInfo>,
    /// What was read besides the file: its buffers and images.
    pub(crate) files: Vec<PathBuf>,
    /// Reading and making the world, and taking in trees from a file, before any tree is built.
    pub(crate) load_time: Duration,
    /// The commit that built all trees, at time 0.
    pub(crate) first_commit: FrameReport,
    /// The scene brought no light and was given daylight.
    pub(crate) has_default_lighting: bool,
}

/// A scene without trees.
pub(crate) struct Loaded {
    /// As [`Opened::name`].
    pub(crate) name: String,
    pub(crate) world: World,
    /// What was ignored or repaired, one line each.
    pub(crate) notes: Vec<String>,
    /// The animations of the file.
    pub(crate) clips: Vec<ClipInfo>,
    /// What was read besides the file: its buffers and images.
    pub(crate) files: Vec<PathBuf>,
    /// Reading and making the world.
    pub(crate) load_time: Duration,
}

/// The race has the same trees and spectators always; the seed of a picture only changes its noise.
const RACE_SEED: u64 = 1;

/// What to call files after a scene.
pub(crate) fn stem(path: Option<&Path>) -> String {
    let Some(path) = path else { return "race".into() };
    path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned())
}

/// Loads a file, and one of its animations if one is named, or makes the race.
pub(crate) fn load(path: Option<&Path>, clip: Option<&Clip>) -> Result<Loaded, Failure> {
    let name = path.map_or_else(|| "the built-in race".to_owned(), |path| path.display().to_string());
    let start = Instant::now();
    let (world, notes, clips, files) = match path {
        None => (kinetree_race::world(RACE_SEED), Vec::new(), Vec::new(), Vec::new()),
        Some(path) => {
            check_extension(path)?;
            let options = Options::new().clip(clip.cloned().unwrap_or_default());
            let loaded = kinetree_gltf::load_with(path, &options).map_err(|error| Failure::work(error.to_string()))?;
            (loaded.world, loaded.notes, loaded.clips, loaded.files)
        }
    };
    Ok(Loaded { name, world, notes, clips, files, load_time: start.elapsed() })
}

/// Loads a file, or makes the race, and takes its trees from another file, or builds them.
pub(crate) fn open(path: Option<&Path>, clip: Option<&Clip>, trees: Option<&Path>) -> Result<Opened, Failure> {
    // What is wrong with the smaller file is said before the larger one is read.
    let trees = trees.map(BakedTrees::open).transpose()?;
    let Loaded { name, mut world, notes, clips, files, mut load_time } = load(path, clip)?;
    if let Some(trees) = trees {
        let start = Instant::now();
        trees.hand_to(&mut world.scene, &name, path)?;
        load_time += start.elapsed();
    }
    let first_commit = frame_of(&mut world, &name, 0.0)?.view.report().clone();
    let has_default_lighting =
        default_lighting(&mut world).map_err(|error| Failure::work(format!("{name}: at time 0: {error}")))?;
    Ok(Opened { name, world, notes, clips, files, load_time, first_commit, has_default_lighting })
}

impl Opened {
    /// The scene at a time, in seconds.
    pub(crate) fn frame(&mut self, seconds: f64) -> Result<Frame, Failure> {
        frame_of(&mut self.world, &self.name, seconds)
    }
}

fn frame_of(world: &mut World, name: &str, seconds: f64) -> Result<Frame, Failure> {
    world.frame(seconds).map_err(|error| Failure::work(format!("{name}: at time {seconds}: {error}")))
}

fn check_extension(path: &Path) -> Result<(), Failure> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    let problem = match extension.as_deref() {
        Some("glb" | "gltf") => return Ok(()),
        Some("obj") => "Wavefront .obj is not read yet; .glb and .gltf are".to_owned(),
        Some(other) => format!("is a .{other}; scenes that are read are .glb and .gltf"),
        None => "has no extension; scenes that are read are .glb and .gltf".to_owned(),
    };
    Err(Failure::work(format!("{}: {problem}", path.display())))
}
