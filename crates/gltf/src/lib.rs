//! glTF 2.0 files, `.glb` and `.gltf`, as [`kinetree_render::World`]s.
//!
//! ```no_run
//! let mut loaded = kinetree_gltf::load("scene.glb".as_ref())?;
//! loaded.notes.iter().for_each(|note| eprintln!("{note}"));
//! let frame = loaded.world.frame(0.5).expect("the animation fits the scene that it came with");
//! println!("{} instances after half a second", frame.view.instances().len());
//! # Ok::<(), kinetree_gltf::LoadError>(())
//! ```
//!
//! Every mesh of a file is one mesh of the scene, shared by the nodes that show it; a node that bends its mesh, by a skin
//! or by morph targets, has one of its own. What never moves is [`Motion::Static`](kinetree::Motion::Static), what hangs
//! on an animated node is `Rigid`, what bends is `Deforming`.
//!
//! A file may hold anything: whatever is wrong with it is a [`LoadError`], never a panic, and never more memory than a
//! file of its size can justify. What is merely odd is repaired and noted.
//!
//! The map, in layers: `source` and `uri` find bytes, `document` and `accessor` make sense of them; `triangles`,
//! `normals`, `influences`, `vertices`, `mesh`, `image`, `material`, `nodes`, `skeleton`, `keys`, `clip`, `lights` and
//! `cameras` read one kind of thing each; `assemble` makes a world of them, and `player` moves it.

mod accessor;
mod assemble;
mod budget;
mod cameras;
mod clip;
mod document;
mod error;
mod image;
mod influences;
mod keys;
mod lights;
mod material;
mod mesh;
mod nodes;
mod normals;
mod notes;
mod player;
mod skeleton;
mod source;
mod triangles;
mod uri;
mod vertices;

use std::path::Path;

use kinetree_render::World;

use crate::accessor::Accessors;
use crate::budget::Budget;
use crate::document::Document;
use crate::image::Textures;
use crate::material::Materials;
use crate::mesh::Meshes;
use crate::nodes::Hierarchy;
use crate::notes::Notes;
use crate::source::Source;

pub use crate::error::{Item, LoadError, Problem, Quoted};

/// A file that has been loaded.
pub struct Loaded {
    /// What the file shows, at the first moment of its animation. It has no lights if the file has none.
    pub world: World,
    /// What was ignored or repaired, one line each, and not too many.
    pub notes: Vec<String>,
}

/// What to take from a file that offers several.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Options {
    /// The animation that is played.
    pub clip: Clip,
}

/// One of the animations of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Clip {
    /// By its place in the file. The first may be asked for even if there is none: then nothing moves.
    Index(usize),
    /// By its name.
    Name(String),
}

impl Default for Clip {
    fn default() -> Self {
        Self::Index(0)
    }
}

/// Loads a file with its first animation.
///
/// # Errors
/// A file that cannot be read, is broken, refers to something that is not there, or asks for too much.
pub fn load(path: &Path) -> Result<Loaded, LoadError> {
    load_with(path, &Options::default())
}

/// Loads a file.
///
/// # Errors
/// As [`load`]; also an animation that is not there.
pub fn load_with(path: &Path, options: &Options) -> Result<Loaded, LoadError> {
    let mut notes = Notes::default();
    let world = world(path, options, &mut notes).map_err(|problem| LoadError::new(path, problem))?;
    Ok(Loaded { world, notes: notes.into_lines() })
}

fn world(path: &Path, options: &Options, notes: &mut Notes) -> Result<World, Problem> {
    let source = Source::open(path)?;
    let document = Document::parse(&source.json, notes)?;
    let buffers = source.buffers(&document.root.buffers)?;
    let budget = Budget::for_bytes(source.size(&buffers));
    let accessors = Accessors::new(&document, &buffers, &budget);
    let hierarchy = Hierarchy::read(&document, notes)?;
    let clip = clip::Clip::read(&document, &accessors, options, notes)?;
    let textures = Textures::new(&document, &source, &accessors, &budget);
    let materials = Materials::new(&document, textures);
    let meshes = Meshes { document: &document, accessors: &accessors, budget: &budget };
    let parts = assemble::Parts { document: &document, hierarchy: &hierarchy, clip, meshes, budget: &budget };
    assemble::assemble(parts, materials, notes)
}
