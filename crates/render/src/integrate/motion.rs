//! The motion of meshes as colours.

use glam::Vec3;
use kinetree::{Motion, Ray};

use super::first_hit::{FirstHitShader, shade, shade_each};
use super::{BACKGROUND, Integrator, shaded};
use crate::interaction::SurfaceInteraction;
use crate::{Sampler, SceneContext, Tracer};

/// The motion of meshes as colours: grey is static, blue rigid, green deforming, red dynamic,
/// purple any other.
#[derive(Debug, Clone, Copy)]
pub struct Motions;

impl FirstHitShader for Motions {
    fn color(&self, context: &SceneContext<'_>, ray: &Ray, point: Option<&SurfaceInteraction<'_>>) -> [f32; 3] {
        let Some(point) = point else { return BACKGROUND };
        let color = match context.frame().snapshot.instance_at(point.instance).motion() {
            Motion::Static => Vec3::new(0.45, 0.45, 0.45),
            Motion::Rigid => Vec3::new(0.08, 0.25, 0.85),
            Motion::Deforming => Vec3::new(0.1, 0.6, 0.12),
            Motion::Dynamic => Vec3::new(0.85, 0.12, 0.06),
            _ => Vec3::new(0.8, 0.1, 0.7),
        };
        shaded(color, point, ray)
    }
}

impl Integrator for Motions {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: &Ray, _: &mut Sampler) -> [f32; 3] {
        shade(self, tracer, ray)
    }

    fn radiances(&self, tracer: &mut Tracer<'_>, rays: &[Ray], samplers: &mut [Sampler], colors: &mut [[f32; 3]]) {
        shade_each(self, tracer, rays, samplers, colors);
    }

    fn is_display_ready(&self) -> bool {
        true
    }
}
