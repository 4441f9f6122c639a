//! Many paths at once, bounce by bounce: all rays of a bounce are traced together, then all that ask for lights, so that
//! those that go alike share the walk through the trees.
//!
//! What happens at a place is [`Path::arrive`], as for a path that is followed alone, and every path adds up its light in the
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
    let mut front = Front { paths: (0..rays.len()).collect(), rays: rays.to_vec() };
    let (mut next, mut hits) = (Front::default(), Vec::new());
    let mut groups: [Group; 3] = Default::default();
    for bounce in 0..=path.max_depth {
        hits.clear();
        hits.resize(front.rays.len(), None);
        tracer.closest_hits(&front.rays, &|ray| samplers[front.paths[ray]].salt(), &mut hits);
        for ((&number, ray), hit) in front.paths.iter().zip(&front.rays).zip(&hits) {
            let point = hit.as_ref().map(|hit| SurfaceInteraction::new(context.frame(), hit, ray.direction.into()));
            let (state, sampler) = (&mut states[number], &mut samplers[number]);
            let (shadow_queries, ahead) = path.arrive(context, state, (ray, point.as_ref()), sampler, bounce);
            for (group, query) in groups.iter_mut().zip(shadow_queries) {
                group.extend(query.map(|query| (number, query)));
            }
            if let Some(ahead) = ahead {
                next.paths.push(number);
                next.rays.push(ahead);
            }
        }
        for group in &mut groups {
            answer(group, tracer, samplers, &mut states);
        }
        std::mem::swap(&mut front, &mut next);
        next.paths.clear();
        next.rays.clear();
        if front.paths.is_empty() {
            break;
        }
    }
    for (color, state) in colors.iter_mut().zip(&states) {
        *color = state.radiance().into();
    }
}

/// The paths that are still on their way, by number, and their rays.
#[derive(Default)]
struct Front {
    paths: Vec<usize>,
    rays: Vec<Ray>,
}

/// What is asked of the lights of one group, with the number of the path: at most one question of each.
type Group = Vec<(usize, ShadowQuery)>;

/// Looks which of the lights are seen, adds their light to the paths, and leaves the group empty.
fn answer(group: &mut Group, tracer: &mut Tracer<'_>, samplers: &[Sampler], states: &mut [PathState]) {
    let rays: Vec<Ray> = group.iter().map(|(_, query)| query.ray).collect();
    let passed: Vec<Vec3> = tracer.transmittances(&rays, &|ray| samplers[group[ray].0].salt());
    for ((number, query), passed) in group.drain(..).zip(passed) {
        states[number].add_light_sample(&query, passed);
    }
}
