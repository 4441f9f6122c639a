//! BSDFs: one file for each kind of surface.
//!
//! A new kind, such as a rough conductor, is a file here, a variant of [`Scatter`], and an arm in
//! [`evaluate`] and in [`sample`].

mod dielectric;
mod diffuse;
mod fresnel;
mod thin_dielectric;

use glam::Vec3;
use kinetree_world::Scatter;

use crate::Sampler;
use crate::interaction::SurfaceInteraction;

pub(crate) use thin_dielectric::straight_transmittance;

/// A sampled direction of scattering.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BsdfSample {
    /// Unit vector, from the surface.
    pub(crate) direction: Vec3,
    /// BSDF times cosine over pdf.
    pub(crate) weight: Vec3,
    /// Which lobe was sampled.
    pub(crate) kind: ScatterKind,
}

/// Which lobe of a BSDF was sampled, which decides whether light sampling could have found the
/// direction too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ScatterKind {
    /// A lobe without a delta distribution.
    NonSpecular {
        /// Per steradian.
        pdf: f32,
    },
    /// Mirror reflection, a delta distribution.
    SpecularReflection,
    /// Refraction, a delta distribution.
    SpecularTransmission {
        /// Index of refraction beyond the boundary over that on the viewer's side.
        eta: f32,
    },
    /// Transmission that leaves the direction as it was.
    StraightThrough,
}

/// Whether the BSDF has a lobe without a delta distribution, so that light sampling can find light.
pub(crate) fn is_non_specular(point: &SurfaceInteraction<'_>) -> bool {
    matches!(point.material.scatter, Scatter::Diffuse)
}

/// BSDF times cosine, and the pdf of [`sample`] per steradian, for light that arrives from
/// `direction` (unit, from the surface). Zero for specular surfaces.
pub(crate) fn evaluate(point: &SurfaceInteraction<'_>, direction: Vec3) -> (Vec3, f32) {
    match point.material.scatter {
        Scatter::Diffuse => diffuse::evaluate(point, direction),
        Scatter::Dielectric { .. } | Scatter::ThinDielectric { .. } => (Vec3::ZERO, 0.0),
    }
}

/// Samples a direction for a path from the viewer; `None` where it is absorbed. `toward_viewer` is
/// a unit vector.
pub(crate) fn sample(point: &SurfaceInteraction<'_>, toward_viewer: Vec3, sampler: &mut Sampler) -> Option<BsdfSample> {
    let bounce = match point.material.scatter {
        Scatter::Diffuse => diffuse::sample(point, sampler.next_2d()),
        Scatter::Dielectric { ior } => Some(dielectric::sample(point, toward_viewer, usable(ior), sampler.next_1d())),
        Scatter::ThinDielectric { ior } => {
            Some(thin_dielectric::sample(point, toward_viewer, usable(ior), sampler.next_1d()))
        }
    };
    bounce.filter(|bounce| bounce.direction.is_finite() && bounce.weight.max_element() > 0.0)
}

/// An index of refraction in a range that keeps numbers finite; one that is not positive becomes 1,
/// no boundary at all.
fn usable(ior: f32) -> f32 {
    if ior.is_finite() && ior > 0.0 { ior.clamp(0.01, 100.0) } else { 1.0 }
}

/// The mirror image of a unit vector about a unit normal.
fn reflected(toward_viewer: Vec3, normal: Vec3) -> Vec3 {
    (normal * (2.0 * normal.dot(toward_viewer)) - toward_viewer).normalize()
}

/// The normal for specular reflection: the shading normal, unless it faces away from the viewer or
/// would reflect the ray into the surface.
fn reflection_normal(point: &SurfaceInteraction<'_>, toward_viewer: Vec3) -> Vec3 {
    let usable = point.shading_normal.dot(toward_viewer) > 0.0
        && reflected(toward_viewer, point.shading_normal).dot(point.geometric_normal) > 0.0;
    if usable { point.shading_normal } else { point.geometric_normal }
}
