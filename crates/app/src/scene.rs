//! Loads scenes: glTF files, or the built-in race.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use kinetree::FrameReport;
use kinetree_gltf::{Clip, ClipInfo, Options};
use kinetree_render::default_lighting;
use kinetree_world::{Frame, World};

use crate::baked_trees::BakedTrees;
use crate::failure::Failure;

/// A scene with all trees built.
pub(crate) struct OpenedScene {
    /// The name in messages: the path as given, or "the built-in race".
    pub(crate) name: String,
    pub(crate) world: World,
    /// What was ignored or repaired, one line each.
    pub(crate) notes: Vec<String>,
    /// The animations of the file.
    pub(crate) clips: Vec<ClipInfo>,
    /// Other files that were read: buffers and images.
    pub(crate) files: Vec<PathBuf>,
    /// The time to read and convert the scene and to read trees from a file, before any tree is
    /// built.
    pub(crate) load_time: Duration,
    /// The report of the commit that built all trees, at time 0.
    pub(crate) first_commit: FrameReport,
    /// Whether the scene has no light, so that daylight was added.
    pub(crate) has_default_lighting: bool,
}

/// A scene without trees.
pub(crate) struct LoadedScene {
    /// The name in messages: the path as given, or "the built-in race".
    pub(crate) name: String,
    pub(crate) world: World,
    /// What was ignored or repaired, one line each.
    pub(crate) notes: Vec<String>,
    /// The animations of the file.
    pub(crate) clips: Vec<ClipInfo>,
    /// Other files that were read: buffers and images.
    pub(crate) files: Vec<PathBuf>,
    /// The time to read and convert the scene.
    pub(crate) load_time: Duration,
}

/// The seed of the race's trees and spectators; `--seed` changes only the noise of a picture.
const RACE_SEED: u64 = 1;

/// The stem of file names that are made from a scene's name.
pub(crate) fn stem(path: Option<&Path>) -> String {
    let Some(path) = path else { return "race".into() };
    path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned())
}

/// Loads a file with one of its animations, or builds the race.
pub(crate) fn load(path: Option<&Path>, clip: Option<&Clip>) -> Result<LoadedScene, Failure> {
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
    Ok(LoadedScene { name, world, notes, clips, files, load_time: start.elapsed() })
}

/// Loads a scene, takes its trees from a file if one is given, and builds the others.
pub(crate) fn open(path: Option<&Path>, clip: Option<&Clip>, trees: Option<&Path>) -> Result<OpenedScene, Failure> {
    // Trees are read first, so that an error in the smaller file is reported early.
    let trees = trees.map(BakedTrees::open).transpose()?;
    let LoadedScene { name, mut world, notes, clips, files, mut load_time } = load(path, clip)?;
    if let Some(trees) = trees {
        let start = Instant::now();
        trees.hand_to(&mut world.scene, &name, path)?;
        load_time += start.elapsed();
    }
    let first_commit = frame_of(&mut world, &name, 0.0)?.snapshot.report().clone();
    let has_default_lighting =
        default_lighting(&mut world).map_err(|error| Failure::work(format!("{name}: at time 0: {error}")))?;
    Ok(OpenedScene { name, world, notes, clips, files, load_time, first_commit, has_default_lighting })
}

impl OpenedScene {
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
