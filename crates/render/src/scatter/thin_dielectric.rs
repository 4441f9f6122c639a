//! A dielectric sheet without thickness, such as a window pane: reflects, or transmits without
//! changing the direction.
//!
//! So a shadow ray may pass too: [`straight_transmittance`] is the factor. A path that is
//! transmitted keeps the pdf of its last scattering, and multiple importance sampling weighs light
//! sampling against BSDF sampling as if the sheet were not there.

use glam::Vec3;
use kinetree_world::Scatter;

use super::{BsdfSample, ScatterKind, fresnel, reflected, reflection_normal, usable};
use crate::interaction::SurfaceInteraction;

/// Reflects with the probability of Fresnel's reflectance of both boundaries together, and
/// transmits otherwise.
pub(super) fn sample(point: &SurfaceInteraction<'_>, toward_viewer: Vec3, ior: f32, u: f32) -> BsdfSample {
    let normal = reflection_normal(point, toward_viewer);
    let reflectance = fresnel::slab_reflectance(normal.dot(toward_viewer), ior);
    if u < reflectance {
        BsdfSample {
            direction: reflected(toward_viewer, normal),
            weight: Vec3::ONE,
            kind: ScatterKind::SpecularReflection,
        }
    } else {
        BsdfSample { direction: -toward_viewer, weight: point.color, kind: ScatterKind::StraightThrough }
    }
}

/// The fraction of light that a surface transmits without changing its direction; `None` for
/// surfaces that transmit none.
pub(crate) fn straight_transmittance(point: &SurfaceInteraction<'_>, toward_viewer: Vec3) -> Option<Vec3> {
    let Scatter::ThinDielectric { ior } = point.material.scatter else { return None };
    let normal = reflection_normal(point, toward_viewer);
    Some(point.color * (1.0 - fresnel::slab_reflectance(normal.dot(toward_viewer), usable(ior))))
}
