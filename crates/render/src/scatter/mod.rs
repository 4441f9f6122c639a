//! What a surface does with light: one file for each kind of surface.
//!
//! A new kind, such as rough metal, is a file here, a variant of [`Scatter`], and an arm in the two functions below.

mod dielectric;
mod diffuse;
mod fresnel;
mod thin_dielectric;

use glam::Vec3;

use crate::interaction::SurfaceInteraction;
use crate::{Sampler, Scatter};

pub(crate) use thin_dielectric::straight_transmittance;

/// A direction in which a path goes on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BsdfSample {
    /// Unit vector, from the surface.
    pub(crate) direction: Vec3,
    /// Scattering function times cosine over pdf.
    pub(crate) weight: Vec3,
    /// How the direction was found.
    pub(crate) kind: ScatterKind,
}

/// How a direction was found, which decides what other ways could have found it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ScatterKind {
    /// One of many, with this pdf per solid angle.
    NonSpecular {
        /// Per steradian.
        pdf: f32,
    },
    /// The only one of its kind: a mirror's.
    SpecularReflection,
    /// The only one of its kind: bent.
    SpecularTransmission {
        /// Index of refraction beyond the boundary over that on the viewer's side.
        eta: f32,
    },
    /// Straight on, as if nothing were there.
    StraightThrough,
}

/// Whether light from any given direction is scattered to the viewer, so that asking lights makes sense.
pub(crate) fn is_non_specular(point: &SurfaceInteraction<'_>) -> bool {
    matches!(point.material.scatter, Scatter::Diffuse)
}

/// Scattering function times cosine, and the pdf of [`sample`], for light that comes from `direction` (unit, from the
/// surface). Zero for surfaces that do not spread.
pub(crate) fn evaluate(point: &SurfaceInteraction<'_>, direction: Vec3) -> (Vec3, f32) {
    match point.material.scatter {
        Scatter::Diffuse => diffuse::evaluate(point, direction),
        Scatter::Dielectric { .. } | Scatter::ThinDielectric { .. } => (Vec3::ZERO, 0.0),
    }
}

/// Where a path from the viewer goes on; `None` where it ends. `toward_viewer` is a unit vector.
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

/// An index of refraction that can be reckoned with; what is none counts as no boundary at all.
fn usable(ior: f32) -> f32 {
    if ior.is_finite() && ior > 0.0 { ior.clamp(0.01, 100.0) } else { 1.0 }
}

/// The mirror image of a unit vector about a unit normal.
fn reflected(toward_viewer: Vec3, normal: Vec3) -> Vec3 {
    (normal * (2.0 * normal.dot(toward_viewer)) - toward_viewer).normalize()
}

/// The normal that a mirror takes: the shading normal, unless it is turned away from the viewer or would throw the ray
/// into the surface.
fn reflection_normal(point: &SurfaceInteraction<'_>, toward_viewer: Vec3) -> Vec3 {
    let usable = point.shading_normal.dot(toward_viewer) > 0.0
        && reflected(toward_viewer, point.shading_normal).dot(point.geometric_normal) > 0.0;
    if usable { point.shading_normal } else { point.geometric_normal }
}
