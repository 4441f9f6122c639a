//! What a renderer of a [`kinetree`] scene needs beside geometry: materials, textures, lights,
//! cameras and animation. There is no renderer here; `kinetree-render` is one.
//!
//! A [`World`] is a scene with all of these. [`World::frame`] brings it to a time, and returns a
//! [`Frame`]: a snapshot of the scene with materials, and lights in world space. A frame borrows
//! nothing from the world and can be rendered on other threads while the next one is made.
//!
//! Positions are in metres, y is up, angles are in radians, colours are linear RGB.
//!
//! ```
//! use kinetree::{Affine, Mesh, Motion, Scene};
//! use kinetree_world::{Material, MaterialSet, Surface, World};
//!
//! let mut scene = Scene::new();
//! let triangle = Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
//! let mesh = scene.add_mesh(triangle, Motion::Static)?;
//! let instance = scene.add_instance(scene.root(), mesh, Affine::IDENTITY)?;
//!
//! let mut world = World::new(scene);
//! let materials = vec![Material::diffuse([0.8, 0.1, 0.1])];
//! let surfaces = vec![Surface::of(0)];
//! world.material_set = MaterialSet { materials, surfaces, ..MaterialSet::default() }.into();
//! world.material_bindings.bind(instance, 0);
//!
//! let frame = world.frame(0.0)?;
//! for instance in frame.snapshot.instances() {
//!     let surface = frame.surface(instance.index()).expect("it was bound");
//!     assert_eq!(surface.material_of(0), Some(0));
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The map
//!
//! | | |
//! |---|---|
//! | materials of triangles and instances | `material`, `texture`, `material_set`, `material_bindings` |
//! | lights and cameras | `light`, `sky`, `camera` |
//! | motion | `animation` |
//! | all together, and at one time | `world`, `frame` |

mod animation;
mod camera;
mod frame;
mod light;
mod material;
mod material_bindings;
mod material_set;
mod sky;
mod texture;
mod world;

pub use animation::{Animation, NoAnimation};
pub use camera::{Camera, CameraProjection};
pub use frame::Frame;
pub use light::Light;
pub use material::{Alpha, Material, Scatter};
pub use material_bindings::MaterialBindings;
pub use material_set::{MaterialSet, Part, Surface};
pub use sky::Sky;
pub use texture::{Filter, Texture, TextureRef, Wrap, linear_from_srgb};
pub use world::{CameraSource, LightSource, World};
