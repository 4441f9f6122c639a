//! glTF 2.0 files, `.glb` and `.gltf`, as [`kinetree_world::World`]s.
//!
//! ```no_run
//! let mut loaded = kinetree_gltf::load("scene.glb".as_ref())?;
//! loaded.notes.iter().for_each(|note| eprintln!("{note}"));
//! let frame = loaded.world.frame(0.5).expect("the animation fits the scene that it came with");
//! println!("{} instances after half a second", frame.view.instances().len());
//! # Ok::<(), kinetree_gltf::LoadError>(())
//! ```
//!
//! Every mesh of a file is one mesh of the scene, shared by the nodes that show it; a node that
//! deforms its mesh, by a skin or by morph targets, has one of its own. What never moves is
//! [`Motion::Static`](kinetree::Motion::Static), what hangs on an animated node is `Rigid`, what is
//! deformed is `Deforming`.
//!
//! Triangles without normals are flat in every pose: in a mesh that is deformed and that has
//! normals elsewhere, the normals of their vertices are zero, which stands for that of the
//! triangle. The front of a skinned mesh is decided by the determinant of its node, as the
//! specification has it, although nothing else about that node counts.
//!
//! An instance is opaque ([`InstanceView::is_opaque`](kinetree::InstanceView::is_opaque)) unless a
//! ray can pass through a triangle because of its alpha; glass is opaque in this sense.
//!
//! A file may hold anything: whatever is wrong with it is a [`LoadError`], never a panic, and never
//! more memory than a file of its size can justify. What is merely odd is repaired and noted; an
//! image that is missing or damaged costs its texture. What a file asks for and does not get is
//! noted too, in one line for each extension or property.
//!
//! The map, in layers: `source` and `uri` find bytes, `json`, `document` and `accessor` make sense
//! of them, and `extensions` says what is not supported; `triangles`, `normals`, `influences`,
//! `vertices`, `mesh`, `pixels`, `image`, `material`, `nodes`, `instancing`, `skeleton`, `keys`,
//! `clip`, `lights` and `cameras` read one kind of thing each; `assemble` makes a world of them,
//! and `player` moves it.

mod accessor;
mod assemble;
mod budget;
mod cameras;
mod clip;
mod document;
mod error;
mod extensions;
mod image;
mod influences;
mod instancing;
mod json;
mod keys;
mod lights;
mod material;
mod mesh;
mod nodes;
mod normals;
mod notes;
mod pixels;
mod player;
mod skeleton;
mod source;
mod triangles;
mod uri;
mod vertices;

use std::path::{Path, PathBuf};

use kinetree_world::World;

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
    /// What the file shows, at the first moment of its animation. It has no lights if the file has
    /// none.
    pub world: World,
    /// What was ignored or repaired, one line each, and not too many.
    pub notes: Vec<String>,
    /// The animations of the file, in its order.
    pub clips: Vec<ClipInfo>,
    /// The files next to it that were read: buffers and images.
    pub files: Vec<PathBuf>,
}

/// An animation of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClipInfo {
    /// As written in the file.
    pub name: Option<String>,
    /// Whether it is among those that [`Options::clip`] chose.
    pub is_played: bool,
}

/// What to take from a file, and how much.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// The animations that are played.
    pub clip: Clip,
    /// How much memory the texels of all textures may take, bytes: four for every pixel. Images
    /// beyond that are left out, with a note.
    pub max_texture_bytes: u64,
}

impl Default for Options {
    /// Animations together, and 4 GiB of textures.
    fn default() -> Self {
        Self { clip: Clip::default(), max_texture_bytes: 4 << 30 }
    }
}

/// Which of the animations of a file are played.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Clip {
    /// The first, and all others that move nothing that one before them moves: one animation for
    /// each object, as many programs write them, is one performance, whereas several for the same
    /// object are alternatives. They begin together; the shorter ones wait at their ends for the
    /// longest.
    #[default]
    Together,
    /// By its index in the file. Index 0 is accepted even if the file has no animation: then
    /// nothing moves.
    Index(usize),
    /// By its name.
    Name(String),
}

/// Loads a file with those of its animations that play together.
///
/// # Errors
/// A file that cannot be read, is broken, refers to something that is not there, or asks for too
/// much.
pub fn load(path: &Path) -> Result<Loaded, LoadError> {
    load_with(path, &Options::default())
}

/// Loads a file.
///
/// # Errors
/// As [`load`]; also an animation that is not there.
pub fn load_with(path: &Path, options: &Options) -> Result<Loaded, LoadError> {
    let mut notes = Notes::default();
    let (world, clips, files) = world(path, options, &mut notes).map_err(|problem| LoadError::new(path, problem))?;
    Ok(Loaded { world, notes: notes.into_lines(), clips, files })
}

type Parts = (World, Vec<ClipInfo>, Vec<PathBuf>);

fn world(path: &Path, options: &Options, notes: &mut Notes) -> Result<Parts, Problem> {
    let source = Source::open(path)?;
    let document = Document::parse(&source.json, notes)?;
    let buffers = source.buffers(&document.root.buffers)?;
    let budget = Budget::for_bytes(source.size(&buffers));
    let accessors = Accessors::new(&document, &buffers, &budget);
    let hierarchy = Hierarchy::read(&document, notes)?;
    let mut clip = clip::Clip::read(&document, &accessors, options, notes)?;
    let textures = Textures::new(&document, &source, &accessors, options.max_texture_bytes);
    let materials = Materials::new(&document, textures);
    let meshes = Meshes { document: &document, accessors: &accessors, budget: &budget };
    let clips = std::mem::take(&mut clip.all);
    let parts = assemble::Parts { document: &document, hierarchy: &hierarchy, clip, meshes, budget: &budget };
    let world = assemble::assemble(parts, materials, notes)?;
    Ok((world, clips, source.files_read()))
}
