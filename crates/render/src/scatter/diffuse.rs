//! Lambert's law: the same radiance in every direction.
//!
//! Light counts only when it lies on the viewer's side of the true surface as well as of the shading normal: nothing leaks
//! through, and no more leaves than arrives.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::{BsdfSample, ScatterKind};
use crate::interaction::SurfaceInteraction;
use crate::warp::{Basis, cosine_hemisphere};

/// Scattering function times cosine, and pdf.
pub(super) fn evaluate(point: &SurfaceInteraction<'_>, direction: Vec3) -> (Vec3, f32) {
    let cosine = point.shading_normal.dot(direction);
    if cosine <= 0.0 || point.geometric_normal.dot(direction) <= 0.0 {
        return (Vec3::ZERO, 0.0);
    }
    (point.color * (cosine / PI), cosine / PI)
}

/// A direction by the cosine about the shading normal; `None` when it lies below the surface.
pub(super) fn sample(point: &SurfaceInteraction<'_>, u: [f32; 2]) -> Option<BsdfSample> {
    let local = cosine_hemisphere(Vec2::from(u));
    let direction = Basis::around(point.shading_normal).to_world(local).normalize();
    let (_, pdf) = evaluate(point, direction);
    (pdf > 0.0).then_some(BsdfSample { direction, weight: point.color, kind: ScatterKind::NonSpecular { pdf } })
}
