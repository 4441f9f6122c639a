//! Integrators: from a camera ray to a colour, one file for each kind of picture.
//!
//! `simple_path.rs` is the one to read first; `path.rs` computes the same with less noise. The
//! others show properties of the scene and its trees.

mod ambient;
mod first_hit;
mod heatmap;
mod ids;
mod motion;
mod normals;
mod path;
mod simple_path;
mod wavefront;

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

use glam::Vec3;
use kinetree::Ray;

use crate::interaction::SurfaceInteraction;
use crate::{Sampler, Settings, Tracer};

pub use ambient::Ambient;
pub use heatmap::Heatmap;
pub use ids::Ids;
pub use motion::Motions;
pub use normals::Normals;
pub use path::Path;
pub use simple_path::SimplePath;

/// Turns a ray from the camera into a colour. A pure function of the frame, the ray and the
/// sampler's numbers.
pub trait Integrator: Send + Sync {
    /// The colour that comes along a ray of unit direction, linear RGB: radiance, or for pictures
    /// that [are ready](Integrator::is_display_ready) a colour in 0..=1.
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: &Ray, sampler: &mut Sampler) -> [f32; 3];

    /// The colours along the camera rays of many samples, neighbours of which are nearly parallel:
    /// the same as [`Integrator::radiance`] gives for each, to the bit. The default calls it for
    /// one after another.
    ///
    /// # Panics
    /// When there are fewer samplers or colours than rays.
    fn radiances(&self, tracer: &mut Tracer<'_>, rays: &[Ray], samplers: &mut [Sampler], colors: &mut [[f32; 3]]) {
        for (at, ray) in rays.iter().enumerate() {
            tracer.begin_sample(samplers[at].salt());
            colors[at] = self.radiance(tracer, ray, &mut samplers[at]);
        }
    }

    /// Whether colours are meant to be shown as they are, without exposure and tone mapping.
    fn is_display_ready(&self) -> bool {
        false
    }
}

/// The integrators that can be chosen by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum IntegratorKind {
    /// [`Path`]: path tracing with light sampling.
    #[default]
    Path,
    /// [`SimplePath`]: the same picture, by BSDF sampling alone.
    Simple,
    /// [`Ambient`]: ambient occlusion.
    Ambient,
    /// [`Heatmap`]: the cost of camera rays.
    Heatmap,
    /// [`Normals`]: shading normals.
    Normals,
    /// [`Ids`]: instances and triangles.
    Ids,
    /// [`Motions`]: the motion of meshes.
    Motion,
}

/// The error of parsing a name that no integrator has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no integrator {0:?}; there are path, simple, ambient, heatmap, normals, ids and motion")]
pub struct UnknownIntegrator(pub String);

impl IntegratorKind {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Path, Self::Simple, Self::Ambient, Self::Heatmap, Self::Normals, Self::Ids, Self::Motion];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Simple => "simple",
            Self::Ambient => "ambient",
            Self::Heatmap => "heatmap",
            Self::Normals => "normals",
            Self::Ids => "ids",
            Self::Motion => "motion",
        }
    }

    /// The integrator itself, set up as the settings say.
    pub fn with(self, settings: &Settings) -> Box<dyn Integrator> {
        match self {
            Self::Path => Box::new(Path { max_depth: settings.max_depth, clamp: settings.clamp, ..Path::default() }),
            Self::Simple => Box::new(SimplePath { max_depth: settings.max_depth }),
            Self::Ambient => Box::new(Ambient),
            Self::Heatmap => Box::new(Heatmap),
            Self::Normals => Box::new(Normals),
            Self::Ids => Box::new(Ids),
            Self::Motion => Box::new(Motions),
        }
    }
}

impl Display for IntegratorKind {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for IntegratorKind {
    type Err = UnknownIntegrator;

    fn from_str(name: &str) -> Result<Self, UnknownIntegrator> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| UnknownIntegrator(name.to_owned()))
    }
}

/// The background colour of pictures that show properties instead of light.
const BACKGROUND: [f32; 3] = [0.02, 0.02, 0.025];

/// A headlight for pictures that show properties: brighter where the surface faces the viewer.
fn shaded(color: Vec3, point: &SurfaceInteraction<'_>, ray: &Ray) -> [f32; 3] {
    let facing = point.shading_normal.dot(Vec3::from(ray.direction)).abs();
    (color * (0.35 + 0.65 * facing)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back_to_their_integrators() {
        for kind in IntegratorKind::ALL {
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
        assert_eq!("bidirectional".parse::<IntegratorKind>(), Err(UnknownIntegrator("bidirectional".into())));
    }
}
