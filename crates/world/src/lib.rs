//! What a renderer of a [`kinetree`] scene needs beside geometry: materials, textures, lights,
//! cameras and animation. There is no renderer here; `kinetree-render` is one.
//!
//! A [`World`] is a scene with all of these. [`World::frame`] brings it to a time, and returns a
//! [`Frame`]: a snapshot of the scene with materials, and lights in world space. A frame borrows
//! nothing from the world and can be rendered on other threads while the next one is made.
//!
//! Positions are in metres, y is up, angles are in radians, colours are linear RGB.
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
