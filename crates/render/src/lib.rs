//! A path tracer for moving scenes, on [`kinetree`].
//!
//! [`render`] makes a picture of a [`kinetree_world::Frame`].
//!
//! ```
//! use kinetree::{Affine, Mesh, Motion, Scene};
//! use kinetree_render::{Settings, render, tone_map};
//! use kinetree_world::{Camera, Frame, Light};
//!
//! let mut scene = Scene::new();
//! let triangle = Mesh::new(&[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.5, 0.0]], &[[0, 1, 2]])?;
//! let mesh = scene.add_mesh(triangle, Motion::Static)?;
//! scene.add_instance(scene.root(), mesh, Affine::IDENTITY)?;
//! let sun = Light::Sun { direction: [0.0, 0.0, -1.0], irradiance: [3.0; 3], angle: 0.0 };
//! let mut frame = Frame::new(scene.commit());
//! frame.lights.push(sun);
//! let camera = Camera::look_at([0.0, 0.5, 3.0], [0.0, 0.5, 0.0], 0.9);
//! let settings = Settings { width: 32, height: 24, spp: 4, ..Settings::default() };
//! let picture = render(&frame, &camera, &settings, &|_| std::ops::ControlFlow::Continue(()))?;
//! let srgb: Vec<u8> = tone_map(&picture.film, 1.0);
//! assert!(srgb[3 * (12 * 32 + 16)] > 100); // the middle is lit
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The map
//!
//! | | |
//! |---|---|
//! | default light and camera | `lighting`, `framing` |
//! | from a frame to a film to bytes | `settings`, `render`, `film`, `metering`, `tonemap` |
//! | integrators | `integrate`: `simple_path` first, then `path`, then `wavefront`; `coherent_runs` |
//! | rays through a frame | `scene_context`, `tracer` |
//! | shading | `shading_attributes`, `interaction`, `scatter`, `thin_glass` |
//! | lights | `lights` |
//! | sampling and colour | `sampler`, `warp`, `color` |

mod coherent_runs;
mod color;
mod film;
mod framing;
mod integrate;
mod interaction;
mod lighting;
mod lights;
mod metering;
mod render;
mod sampler;
mod scatter;
mod scene_context;
mod settings;
mod shading_attributes;
mod thin_glass;
mod tonemap;
mod tracer;
mod warp;

pub use film::Film;
pub use framing::default_camera;
pub use integrate::{
    Ambient, Heatmap, Ids, Integrator, IntegratorKind, Motions, Normals, Path, SimplePath, UnknownIntegrator,
};
pub use lighting::{daylight, default_lighting, is_dark};
pub use metering::metered_exposure;
pub use render::{Progress, Rendered, render, render_with};
pub use sampler::Sampler;
pub use scene_context::SceneContext;
pub use settings::{MAX_PIXELS, MAX_SIDE, RenderError, Settings};
pub use tonemap::{automatic_exposure, encode_srgb, tone_map};
pub use tracer::Tracer;
