//! glTF 2.0 files, `.glb` and `.gltf`: read apart from any scene, then inserted into one as often
//! as needed, or made into a world of their own.
//!
//! # In a scene of the caller's
//!
//! ```
//! use kinetree::{Affine, Ray, Scene};
//! use kinetree_gltf::{Clip, Options, read};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let bytes = include_bytes!("../examples/windmill.gltf");
//! // On any thread; a path does as well as bytes.
//! let asset = read(&bytes[..], &Options::new())?;
//!
//! let mut scene = Scene::new();
//! let root = scene.root();
//! let mut mill = asset.load_into(&mut scene, root)?;
//! scene.place(mill.root(), Affine::from_translation([10.0, 0.0, 0.0]))?;
//!
//! mill.player.go_to(&mut scene, &Clip::Name("turn".into()), 0.25)?;
//! let view = scene.commit();
//! let hit = view.closest_hit(&Ray::new([10.0, 1.0, 5.0], [0.0, 0.0, -1.0])).expect("the tower");
//! let material = mill.material(view.instance_id(&hit), hit.primitive).expect("of this file");
//! assert_eq!(material.base_color, [0.5, 0.45, 0.4, 1.0]);
//!
//! mill.remove(&mut scene)?;
//! assert_eq!(scene.commit().instances().len(), 0);
//! # Ok(())
//! # }
//! ```
//!
//! [`read`] gives an [`Asset`], which is `Send` and `Sync`. [`Asset::load_into`] inserts a copy of
//! it and gives a [`Loaded`]: its nodes, meshes, instances, skins, lights, cameras and animations
//! with their names, the material of each triangle, and a [`Player`]. An error leaves the scene as
//! it was; [`Loaded::remove`] takes the copy out again. User ids and masks are the caller's: set on
//! [`Loaded::root`], they hold for the whole copy.
//!
//! # As a world for a renderer
//!
//! ```no_run
//! let mut loaded = kinetree_gltf::load("scene.glb".as_ref())?;
//! loaded.notes.iter().for_each(|note| eprintln!("{note}"));
//! let frame = loaded.world.frame(0.5).expect("the animation fits the scene that it came with");
//! println!("{} instances after half a second", frame.snapshot.instances().len());
//! # Ok::<(), kinetree_gltf::LoadError>(())
//! ```
//!
//! [`load`] and [`Asset::into_world`] insert the file into a scene of its own, which has only the
//! nodes that it needs.
//!
//! # What a file becomes
//!
//! Every mesh of a file is one mesh of the scene, shared by the nodes that show it; a node that
//! deforms its mesh, by a skin or by morph targets, has one of its own, which nodes with the same
//! deformation share. A mesh that is deformed is [`Motion::Deforming`], another one below an
//! animated node is [`Motion::Rigid`], and one that nothing moves has the motion of
//! [`Options::motion`](field@Options::motion).
//!
//! Triangles without normals are flat in every pose: in a mesh that is deformed and that has
//! normals elsewhere, the normals of their vertices are zero, which stands for that of the
//! triangle. A skinned mesh stands where its joints are. The determinant of its node decides which
//! side is its front, as the specification has it; nothing else about that node counts.
//!
//! An instance is opaque ([`InstanceView::is_opaque`]) unless a ray can pass through a triangle
//! because of its alpha; glass is opaque in this sense.
//!
//! # Errors and notes
//!
//! A file may hold anything: whatever is wrong with it is a [`LoadError`], never a panic, and never
//! more memory than a file of its size can justify. Smaller defects are repaired and noted; a
//! texture whose image is missing or damaged is left out. Extensions and properties that are not
//! supported are noted, in one line each.
//!
//! # The map
//!
//! `source`, `container` and `uri` find bytes; `json`, `document` and `accessor` parse them;
//! `extensions` says what is not supported. `triangles`, `normals`, `influences`, `vertices`,
//! `geometry`, `merge`, `mesh`, `pixels`, `image`, `material`, `nodes`, `transform`, `instancing`,
//! `skeleton`, `skin`, `keys`, `clip`, `channels`, `lights` and `cameras` read one kind of thing
//! each. From this `input`, `file_mesh`, `deformation` and `assemble` make the `contents` of an
//! `asset`, and a `rig` for what moves. `insert` adds them to a scene, `loaded` lists what was
//! added, and `player` moves it. `world` makes a world of an asset.
//!
//! [`Motion::Deforming`]: kinetree::Motion::Deforming
//! [`Motion::Rigid`]: kinetree::Motion::Rigid
//! [`InstanceView::is_opaque`]: kinetree::InstanceView::is_opaque

mod accessor;
mod assemble;
mod asset;
mod budget;
mod cameras;
mod channels;
mod clip;
mod container;
mod contents;
mod deformation;
mod document;
mod error;
mod extensions;
mod file_mesh;
mod geometry;
mod image;
mod influences;
mod input;
mod insert;
mod instancing;
mod json;
mod keys;
mod lights;
mod loaded;
mod material;
mod merge;
mod mesh;
mod nodes;
mod normals;
mod notes;
mod options;
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

pub use crate::asset::{Asset, read};
pub use crate::clip::{Clip, ClipInfo, PlayError};
pub use crate::error::{Item, LoadError, Problem, Quoted};
pub use crate::loaded::{Loaded, LoadedInstance, LoadedMesh, LoadedNode, LoadedSkin};
pub use crate::options::Options;
pub use crate::player::Player;
pub use crate::source::Source;
pub use crate::world::{LoadedWorld, load, load_with};
