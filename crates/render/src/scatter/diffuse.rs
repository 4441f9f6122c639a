//! Lambertian reflection: the same radiance in every direction.
//!
//! A direction counts only if it lies on the viewer's side of both the geometric and the shading
//! normal: no light leaks through the surface, and energy is conserved.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::{BsdfSample, ScatterKind};
use crate::interaction::SurfaceInteraction;
use crate::warp::{Basis, cosine_hemisphere};

/// BSDF times cosine, and the pdf of [`sample`], per steradian.
pub(super) fn evaluate(point: &SurfaceInteraction<'_>, direction: Vec3) -> (Vec3, f32) {
    let cosine = point.shading_normal.dot(direction);
    if cosine <= 0.0 || point.geometric_normal.dot(direction) <= 0.0 {
        return (Vec3::ZERO, 0.0);
    }
    (point.color * (cosine / PI), cosine / PI)
}

/// A cosine-weighted direction about the shading normal; `None` when it lies below the surface.
pub(super) fn sample(point: &SurfaceInteraction<'_>, u: [f32; 2]) -> Option<BsdfSample> {
    let local = cosine_hemisphere(Vec2::from(u));
    let direction = Basis::around(point.shading_normal).to_world(local).normalize();
    let (_, pdf) = evaluate(point, direction);
    (pdf > 0.0).then_some(BsdfSample { direction, weight: point.color, kind: ScatterKind::NonSpecular { pdf } })
}
