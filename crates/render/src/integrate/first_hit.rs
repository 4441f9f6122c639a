//! Pictures of what is seen at first sight: one ray for each sample, so that all of them go in packets.

use kinetree::{Hit, Ray};

use crate::interaction::SurfaceInteraction;
use crate::{Sampler, SceneContext, Tracer};

/// A picture of what rays from the camera see first.
pub(super) trait FirstHitShader {
    /// The colour of a place, or of none, that a ray sees.
    fn color(&self, context: &SceneContext<'_>, ray: &Ray, point: Option<&SurfaceInteraction<'_>>) -> [f32; 3];
}

/// What one ray sees.
pub(super) fn shade(shader: &impl FirstHitShader, tracer: &mut Tracer<'_>, ray: &Ray) -> [f32; 3] {
    let point = tracer.intersect(ray);
    shader.color(tracer.context(), ray, point.as_ref())
}

/// What each of many rays sees.
pub(super) fn shade_each(
    shader: &impl FirstHitShader,
    tracer: &mut Tracer<'_>,
    rays: &[Ray],
    samplers: &[Sampler],
    colors: &mut [[f32; 3]],
) {
    let context = tracer.context();
    for ((color, ray), hit) in colors.iter_mut().zip(rays).zip(first_hits(tracer, rays, samplers)) {
        let point = hit.map(|hit| SurfaceInteraction::new(context.frame(), &hit, ray.direction.into()));
        *color = shader.color(context, ray, point.as_ref());
    }
}

/// What rays from the camera hit first.
pub(super) fn first_hits(tracer: &mut Tracer<'_>, rays: &[Ray], samplers: &[Sampler]) -> Vec<Option<Hit>> {
    let mut hits = vec![None; rays.len()];
    tracer.closest_hits(rays, &|ray| samplers[ray].salt(), &mut hits);
    hits
}
