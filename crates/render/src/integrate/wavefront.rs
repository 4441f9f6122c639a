//! Wavefront path tracing: many paths at once, bounce by bounce. All rays of a bounce are traced
//! together, then all shadow rays, so that coherent ones are traced as packets.
//!
//! Vertices are shaded by [`Path::shade_vertex`], as for a single path, and every path adds up its
//! contributions in the same order: [`Path::radiance`](super::Integrator::radiance) is the slow
//! twin, and pictures are the same to the bit.
//!
//! Laine, Karras and Aila 2013, "Megakernels Considered Harmful: Wavefront Path Tracing on GPUs".

use glam::Vec3;
use kinetree::Ray;

use super::Path;
use super::path::{PathState, ShadowQuery};
use crate::interaction::SurfaceInteraction;
use crate::{Sampler, Tracer};

/// The radiance along each camera ray.
pub(super) fn radiances(
    path: &Path,
    tracer: &mut Tracer<'_>,
    rays: &[Ray],
    samplers: &mut [Sampler],
    colors: &mut [[f32; 3]],
) {
    let context = tracer.context();
    let mut states = vec![PathState::default(); rays.len()];
    let mut current = RayQueue { paths: (0..rays.len()).collect(), rays: rays.to_vec() };
    let (mut next, mut hits) = (RayQueue::default(), Vec::new());
    let mut shadow_queues: [ShadowQueue; 3] = Default::default();
    for bounce in 0..=path.max_depth {
        hits.clear();
        hits.resize(current.rays.len(), None);
        tracer.closest_hits(&current.rays, &|ray| samplers[current.paths[ray]].salt(), &mut hits);
        for ((&index, ray), hit) in current.paths.iter().zip(&current.rays).zip(&hits) {
            let point = hit.as_ref().map(|hit| SurfaceInteraction::new(context.frame(), hit, ray.direction.into()));
            let (state, sampler) = (&mut states[index], &mut samplers[index]);
            let (shadow_queries, next_ray) = path.shade_vertex(context, state, (ray, point.as_ref()), sampler, bounce);
            for (queue, query) in shadow_queues.iter_mut().zip(shadow_queries) {
                queue.extend(query.map(|query| (index, query)));
            }
            if let Some(next_ray) = next_ray {
                next.paths.push(index);
                next.rays.push(next_ray);
            }
        }
        for queue in &mut shadow_queues {
            trace_shadow_rays(queue, tracer, samplers, &mut states);
        }
        std::mem::swap(&mut current, &mut next);
        next.paths.clear();
        next.rays.clear();
        if current.paths.is_empty() {
            break;
        }
    }
    for (color, state) in colors.iter_mut().zip(&states) {
        *color = state.radiance().into();
    }
}

/// The next ray of each path that goes on, and the index of the path.
#[derive(Default)]
struct RayQueue {
    paths: Vec<usize>,
    rays: Vec<Ray>,
}

/// Light samples of one group of lights, with the index of the path: at most one per path.
type ShadowQueue = Vec<(usize, ShadowQuery)>;

/// Traces the shadow rays of a queue, adds the light samples to their paths, and empties the queue.
fn trace_shadow_rays(queue: &mut ShadowQueue, tracer: &mut Tracer<'_>, samplers: &[Sampler], states: &mut [PathState]) {
    let rays: Vec<Ray> = queue.iter().map(|(_, query)| query.ray).collect();
    let transmittances: Vec<Vec3> = tracer.transmittances(&rays, &|ray| samplers[queue[ray].0].salt());
    for ((index, query), transmittance) in queue.drain(..).zip(transmittances) {
        states[index].add_light_sample(&query, transmittance);
    }
}
