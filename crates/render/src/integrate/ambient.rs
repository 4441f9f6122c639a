//! How open a place is: the fraction of the light of an even dome that is not blocked nearby.
//!
//! Nearby means within half the distance to the viewer, so that a thimble shows as much as a
//! stadium.
//!
//! Zhukov, Iones and Kronin 1998, "An Ambient Light Illumination Model".

use glam::Vec3;
use kinetree::Ray;

use super::Integrator;
use super::first_hit::first_hits;
use crate::interaction::SurfaceInteraction;
use crate::warp::{Basis, cosine_hemisphere};
use crate::{Sampler, Tracer};

/// Ambient occlusion, in shades of grey.
#[derive(Debug, Clone, Copy)]
pub struct Ambient;

impl Ambient {
    /// A ray from a place that another ray has seen: the place is open if this one meets nothing.
    /// `None` where it leads below the true surface: there everything is blocked.
    fn feeler(point: &SurfaceInteraction<'_>, seen_by: &Ray, sampler: &mut Sampler) -> Option<Ray> {
        sampler.begin_bounce(0);
        let direction =
            Basis::around(point.shading_normal).to_world(cosine_hemisphere(sampler.next_2d().into())).normalize();
        let reach = 0.5 * point.position.distance(Vec3::from(seen_by.origin));
        (point.geometric_normal.dot(direction) > 0.0).then(|| point.ray(direction, reach))
    }
}

const OPEN: [f32; 3] = [1.0; 3];
const BLOCKED: [f32; 3] = [0.0; 3];

impl Integrator for Ambient {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: &Ray, sampler: &mut Sampler) -> [f32; 3] {
        let Some(point) = tracer.intersect(ray) else { return OPEN };
        let feeler = Self::feeler(&point, ray, sampler);
        if feeler.is_some_and(|feeler| !tracer.occluded(&feeler)) { OPEN } else { BLOCKED }
    }

    fn radiances(&self, tracer: &mut Tracer<'_>, rays: &[Ray], samplers: &mut [Sampler], colors: &mut [[f32; 3]]) {
        let context = tracer.context();
        let (mut places, mut feelers) = (Vec::new(), Vec::new());
        for (at, hit) in first_hits(tracer, rays, samplers).into_iter().enumerate() {
            colors[at] = if hit.is_some() { BLOCKED } else { OPEN };
            let Some(hit) = hit else { continue };
            let point = SurfaceInteraction::new(context.frame(), &hit, rays[at].direction.into());
            if let Some(feeler) = Self::feeler(&point, &rays[at], &mut samplers[at]) {
                places.push(at);
                feelers.push(feeler);
            }
        }
        let mut blocked = vec![false; feelers.len()];
        tracer.occluded_each(&feelers, &|ray| samplers[places[ray]].salt(), &mut blocked);
        for (&at, blocked) in places.iter().zip(blocked) {
            colors[at] = if blocked { BLOCKED } else { OPEN };
        }
    }

    fn is_display_ready(&self) -> bool {
        true
    }
}
