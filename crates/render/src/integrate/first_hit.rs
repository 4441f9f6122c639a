//! Integrators that need only the first hit of each camera ray, so that all rays are traced in
//! packets.

use kinetree::{Hit, Ray};

use crate::interaction::SurfaceInteraction;
use crate::{Sampler, SceneContext, Tracer};

/// Computes the colour of a sample from the first hit of its camera ray.
pub(super) trait FirstHitShader {
    /// The colour at the first hit of a ray; `point` is `None` when it hits nothing.
    fn color(&self, context: &SceneContext<'_>, ray: &Ray, point: Option<&SurfaceInteraction<'_>>) -> [f32; 3];
}

/// Traces one ray, and shades its first hit.
pub(super) fn shade(shader: &impl FirstHitShader, tracer: &mut Tracer<'_>, ray: &Ray) -> [f32; 3] {
    let point = tracer.intersect(ray);
    shader.color(tracer.context(), ray, point.as_ref())
}

/// Traces many rays, and shades the first hit of each.
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

/// The first hit of each ray, with the salt of its sampler.
pub(super) fn first_hits(tracer: &mut Tracer<'_>, rays: &[Ray], samplers: &[Sampler]) -> Vec<Option<Hit>> {
    let mut hits = vec![None; rays.len()];
    tracer.closest_hits(rays, &|ray| samplers[ray].salt(), &mut hits);
    hits
}
