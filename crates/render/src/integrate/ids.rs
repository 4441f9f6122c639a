//! Instance and triangle ids as colours: a hue for each instance, a shade for each triangle.

use kinetree::Ray;

use super::first_hit::{FirstHitShader, shade, shade_each};
use super::{BACKGROUND, Integrator, shaded};
use crate::color::from_hue;
use crate::interaction::SurfaceInteraction;
use crate::sampler::{combine, unit_hash};
use crate::{Sampler, SceneContext, Tracer};

/// Instances and triangles as colours.
#[derive(Debug, Clone, Copy)]
pub struct Ids;

impl FirstHitShader for Ids {
    fn color(&self, _: &SceneContext<'_>, ray: &Ray, point: Option<&SurfaceInteraction<'_>>) -> [f32; 3] {
        let Some(point) = point else { return BACKGROUND };
        let shade = unit_hash(combine(point.instance, point.primitive));
        let color = from_hue(unit_hash(point.instance), 0.5 + 0.3 * shade, 0.45 + 0.5 * shade);
        shaded(color, point, ray)
    }
}

impl Integrator for Ids {
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
