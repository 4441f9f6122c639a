//! A path tracer for moving scenes, on [`kinetree`].

mod camera;
mod light;
mod look;
mod texture;
mod world;

pub use camera::Camera;
pub use light::Light;
pub use look::{Alpha, Look, Material, Part, Scatter, Sky, Surface, TextureRef};
pub use texture::{Filter, Texture, Wrap};
pub use world::{Animation, CameraSource, Frame, LightSource, Still, World};
