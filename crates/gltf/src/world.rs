//! A file as a world of its own, for a renderer.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use kinetree::{EditError, Scene};
use kinetree_world::{Animation, World};

use crate::asset::{Asset, read};
use crate::clip::{Clip, ClipInfo, Playing};
use crate::error::{LoadError, Problem};
use crate::insert::{NodeSelection, insert};
use crate::options::Options;
use crate::player::Player;

/// A world that was made from a file.
pub struct LoadedWorld {
    /// What the file shows, at the first moment of its animation. It has no lights if the file has
    /// none.
    pub world: World,
    /// What was ignored or repaired, one line each; a long list ends with how many lines were left
    /// out.
    pub notes: Vec<String>,
    /// The animations of the file, in its order.
    pub clips: Vec<ClipInfo>,
    /// The files that were read besides: buffers and images.
    pub files: Vec<PathBuf>,
}

/// In short: how much there is of it.
impl fmt::Debug for LoadedWorld {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LoadedWorld")
            .field("scene", &self.world.scene)
            .field("notes", &self.notes)
            .field("clips", &self.clips)
            .field("files", &self.files)
            .finish_non_exhaustive()
    }
}

/// Loads a file as a world, with those of its animations that play together.
///
/// # Errors
/// A file that cannot be read, is broken, refers to something that is not there, or asks for too
/// much memory.
pub fn load(path: &Path) -> Result<LoadedWorld, LoadError> {
    load_with(path, &Options::default())
}

/// Loads a file as a world, with the animations of [`Options::clip`](field@Options::clip): without
/// a choice, those of [`Clip::Together`].
///
/// # Errors
/// As [`load`]; also an animation that is not there.
pub fn load_with(path: &Path, options: &Options) -> Result<LoadedWorld, LoadError> {
    // A world plays the same animations always, and need not read any others.
    let clip = options.clip.clone().unwrap_or(Clip::Together);
    read(path, &options.clone().clip(clip))?.into_world()
}

impl Asset {
    /// A world with nothing but this file, which plays the animations of [`Clip::Together`] among
    /// those that were read.
    ///
    /// # Errors
    /// What the library refuses, such as joints whose transforms overflow.
    pub fn into_world(self) -> Result<LoadedWorld, LoadError> {
        let world = self.world().map_err(|problem| self.error(problem))?;
        let (notes, clips, files) = (self.notes().to_vec(), self.clips().to_vec(), self.files().to_vec());
        Ok(LoadedWorld { world, notes, clips, files })
    }

    fn world(&self) -> Result<World, Problem> {
        let mut scene = Scene::new();
        let root = scene.root();
        let loaded = insert(self, &mut scene, root, NodeSelection::Needed, Playing::Together)?;
        let mut world = World::new(scene);
        world.material_set = Arc::clone(&loaded.material_set);
        world.material_bindings = loaded.material_bindings;
        if !loaded.player.is_still() {
            world.animation = Box::new(PlayTogether(loaded.player));
        }
        (world.lights, world.cameras) = (loaded.lights, loaded.cameras);
        Ok(world)
    }
}

/// The animations of [`Clip::Together`], over and over.
struct PlayTogether(Player);

impl Animation for PlayTogether {
    fn go_to(&mut self, scene: &mut Scene, seconds: f64) -> Result<(), EditError> {
        self.0.play(scene, Playing::Together, seconds)
    }

    fn duration(&self) -> f64 {
        self.0.duration_of(Playing::Together)
    }
}
