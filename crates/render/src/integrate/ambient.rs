//! Ambient occlusion: the cosine-weighted part of the hemisphere that is not blocked nearby.
//!
//! Nearby means within half the distance to the camera, so that the picture does not depend on the
//! scale of the scene.
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
    /// A cosine-weighted occlusion ray at the hit of a camera ray. `None` if it points below the
    /// geometric surface, which counts as blocked.
    fn occlusion_ray(point: &SurfaceInteraction<'_>, camera_ray: &Ray, sampler: &mut Sampler) -> Option<Ray> {
        sampler.begin_bounce(0);
        let direction =
            Basis::around(point.shading_normal).to_world(cosine_hemisphere(sampler.next_2d().into())).normalize();
        let reach = 0.5 * point.position.distance(Vec3::from(camera_ray.origin));
        (point.geometric_normal.dot(direction) > 0.0).then(|| point.ray(direction, reach))
    }
}

const UNOCCLUDED: [f32; 3] = [1.0; 3];
const OCCLUDED: [f32; 3] = [0.0; 3];

impl Integrator for Ambient {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: &Ray, sampler: &mut Sampler) -> [f32; 3] {
        let Some(point) = tracer.intersect(ray) else { return UNOCCLUDED };
        let occlusion_ray = Self::occlusion_ray(&point, ray, sampler);
        if occlusion_ray.is_some_and(|occlusion_ray| !tracer.occluded(&occlusion_ray)) { UNOCCLUDED } else { OCCLUDED }
    }

    fn radiances(&self, tracer: &mut Tracer<'_>, rays: &[Ray], samplers: &mut [Sampler], colors: &mut [[f32; 3]]) {
        let context = tracer.context();
        let (mut indices, mut occlusion_rays) = (Vec::new(), Vec::new());
        for (at, hit) in first_hits(tracer, rays, samplers).into_iter().enumerate() {
            colors[at] = if hit.is_some() { OCCLUDED } else { UNOCCLUDED };
            let Some(hit) = hit else { continue };
            let point = SurfaceInteraction::new(context.frame(), &hit, rays[at].direction.into());
            if let Some(occlusion_ray) = Self::occlusion_ray(&point, &rays[at], &mut samplers[at]) {
                indices.push(at);
                occlusion_rays.push(occlusion_ray);
            }
        }
        let mut blocked = vec![false; occlusion_rays.len()];
        tracer.occluded_each(&occlusion_rays, &|ray| samplers[indices[ray]].salt(), &mut blocked);
        for (&at, blocked) in indices.iter().zip(blocked) {
            colors[at] = if blocked { OCCLUDED } else { UNOCCLUDED };
        }
    }

    fn is_display_ready(&self) -> bool {
        true
    }
}
