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
mod asset;
mod budget;
mod cameras;
mod channels;
mod clip;
mod container;
mod deformation;
mod document;
mod error;
mod extensions;
mod image;
mod influences;
mod insert;
mod instancing;
mod json;
mod keys;
mod lights;
mod loaded;
mod material;
mod mesh;
mod nodes;
mod normals;
mod notes;
mod pixels;
mod player;
mod rig;
mod skeleton;
mod skin;
mod source;
mod transform;
mod triangles;
mod uri;
mod vertices;
mod world;

pub use crate::asset::{Asset, Options, read};
pub use crate::clip::{Clip, ClipInfo, PlayError};
pub use crate::error::{Item, LoadError, Problem, Quoted};
pub use crate::loaded::{Loaded, LoadedInstance, LoadedMesh, LoadedNode, LoadedSkin};
pub use crate::player::Player;
pub use crate::source::Source;
pub use crate::world::{LoadedWorld, load, load_with};
