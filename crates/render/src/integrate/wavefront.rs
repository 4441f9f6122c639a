//! Many paths at once, bounce by bounce: all rays of a bounce are traced together, then all that ask for lights, so that
//! those that go alike share the walk through the trees.
//!
//! What happens at a place is [`Path::shade_vertex`], as for a path that is followed alone, and every path adds up its light in the
//! same order: [`Path::radiance`](super::Integrator::radiance) is the slow twin, and pictures are the same to the bit.
//!
//! Laine, Karras and Aila 2013, "Megakernels Considered Harmful: Wavefront Path Tracing on GPUs".

use glam::Vec3;
use kinetree::Ray;

use super::Path;
use super::path::{PathState, ShadowQuery};
use crate::interaction::SurfaceInteraction;
use crate::{Sampler, Tracer};

/// The light that comes along each ray from the camera.
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
        for ((&number, ray), hit) in current.paths.iter().zip(&current.rays).zip(&hits) {
            let point = hit.as_ref().map(|hit| SurfaceInteraction::new(context.frame(), hit, ray.direction.into()));
            let (state, sampler) = (&mut states[number], &mut samplers[number]);
            let (shadow_queries, next_ray) = path.shade_vertex(context, state, (ray, point.as_ref()), sampler, bounce);
            for (queue, query) in shadow_queues.iter_mut().zip(shadow_queries) {
                queue.extend(query.map(|query| (number, query)));
            }
            if let Some(next_ray) = next_ray {
                next.paths.push(number);
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

/// The paths that are still on their way, by number, and their rays.
#[derive(Default)]
struct RayQueue {
    paths: Vec<usize>,
    rays: Vec<Ray>,
}

/// What is asked of the lights of one group, with the number of the path: at most one question of each.
type ShadowQueue = Vec<(usize, ShadowQuery)>;

/// Looks which of the lights are seen, adds their light to the paths, and leaves the group empty.
fn trace_shadow_rays(queue: &mut ShadowQueue, tracer: &mut Tracer<'_>, samplers: &[Sampler], states: &mut [PathState]) {
    let rays: Vec<Ray> = queue.iter().map(|(_, query)| query.ray).collect();
    let passed: Vec<Vec3> = tracer.transmittances(&rays, &|ray| samplers[queue[ray].0].salt());
    for ((number, query), passed) in queue.drain(..).zip(passed) {
        states[number].add_light_sample(&query, passed);
    }
}
