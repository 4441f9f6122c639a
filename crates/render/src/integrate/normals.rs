//! Shading normals as colours: x, y and z as red, green and blue.

use glam::Vec3;
use kinetree::Ray;

use super::first_hit::{FirstHitShader, shade, shade_each};
use super::{BACKGROUND, Integrator};
use crate::interaction::SurfaceInteraction;
use crate::{Sampler, SceneContext, Tracer};

/// Shading normals in world space as colours, on the side of the viewer.
#[derive(Debug, Clone, Copy)]
pub struct Normals;

impl FirstHitShader for Normals {
    fn color(&self, _: &SceneContext<'_>, _: &Ray, point: Option<&SurfaceInteraction<'_>>) -> [f32; 3] {
        point.map_or(BACKGROUND, |point| (point.shading_normal * 0.5 + Vec3::splat(0.5)).into())
    }
}

impl Integrator for Normals {
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
