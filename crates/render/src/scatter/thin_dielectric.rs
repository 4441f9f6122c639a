//! A pane without thickness: reflects, or lets light pass straight on.
//!
//! Because what passes is not bent, a shadow ray may pass too: [`straight_transmittance`] says how much gets through. A path that passes goes on
//! as if nothing had been there, and the two ways of finding a light are weighed against each other without the pane.

use glam::Vec3;

use super::{BsdfSample, ScatterKind, fresnel, reflected, reflection_normal, usable};
use crate::Scatter;
use crate::interaction::SurfaceInteraction;

/// Reflects with the probability that Fresnel gives for both boundaries together, and passes otherwise.
pub(super) fn sample(point: &SurfaceInteraction<'_>, toward_viewer: Vec3, ior: f32, u: f32) -> BsdfSample {
    let normal = reflection_normal(point, toward_viewer);
    let reflected = fresnel::slab_reflectance(normal.dot(toward_viewer), ior);
    if u < reflected {
        BsdfSample {
            direction: reflected(toward_viewer, normal),
            weight: Vec3::ONE,
            kind: ScatterKind::SpecularReflection,
        }
    } else {
        BsdfSample { direction: -toward_viewer, weight: point.color, kind: ScatterKind::StraightThrough }
    }
}

/// The fraction of light that goes straight on through a surface; `None` where none does.
pub(crate) fn straight_transmittance(point: &SurfaceInteraction<'_>, toward_viewer: Vec3) -> Option<Vec3> {
    let Scatter::ThinDielectric { ior } = point.material.scatter else { return None };
    let normal = reflection_normal(point, toward_viewer);
    Some(point.color * (1.0 - fresnel::slab_reflectance(normal.dot(toward_viewer), usable(ior))))
}
