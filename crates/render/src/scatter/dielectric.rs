//! A smooth dielectric boundary, such as the surface of water or of solid glass: reflects or
//! refracts.

use glam::Vec3;

use super::{BsdfSample, ScatterKind, fresnel, reflected, reflection_normal};
use crate::interaction::SurfaceInteraction;

/// Reflects with the probability of Fresnel's reflectance, and refracts otherwise. Radiance scales
/// with the square of the index of refraction when it crosses the boundary (Veach 1997, section
/// 5.2).
pub(super) fn sample(point: &SurfaceInteraction<'_>, toward_viewer: Vec3, ior: f32, u: f32) -> BsdfSample {
    let eta = if point.front { ior } else { 1.0 / ior };
    let normal = reflection_normal(point, toward_viewer);
    if u < fresnel::reflectance(normal.dot(toward_viewer), eta) {
        return BsdfSample {
            direction: reflected(toward_viewer, normal),
            weight: Vec3::ONE,
            kind: ScatterKind::SpecularReflection,
        };
    }
    let below = refracted(toward_viewer, normal, eta).filter(|direction| direction.dot(point.geometric_normal) < 0.0);
    // About the shading normal the refracted ray may stay on the viewer's side; about the geometric
    // normal it never does.
    match below.or_else(|| refracted(toward_viewer, point.geometric_normal, eta)) {
        Some(direction) => {
            BsdfSample { direction, weight: point.color / (eta * eta), kind: ScatterKind::SpecularTransmission { eta } }
        }
        None => BsdfSample {
            direction: reflected(toward_viewer, point.geometric_normal),
            weight: Vec3::ONE,
            kind: ScatterKind::SpecularReflection,
        },
    }
}

/// The direction beyond the boundary; `None` under total internal reflection.
fn refracted(toward_viewer: Vec3, normal: Vec3, eta: f32) -> Option<Vec3> {
    let cosine = normal.dot(toward_viewer).min(1.0);
    let beyond = fresnel::refracted_cosine(cosine, eta)?;
    Some(((normal * cosine - toward_viewer) / eta - normal * beyond).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refraction_follows_snell() {
        let viewer = Vec3::new(0.6, 0.0, 0.8);
        let direction = refracted(viewer, Vec3::Z, 1.5).expect("enters the dense side");
        assert!((direction.x + 0.4).abs() < 1e-6 && direction.z < 0.0 && direction.is_normalized());
        assert!(refracted(viewer, Vec3::Z, 0.5).is_none());
    }
}
