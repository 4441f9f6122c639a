//! How open a place is: the fraction of the light of an even dome that is not blocked nearby.
//!
//! Nearby means within half the distance to the viewer, so that a thimble shows as much as a stadium.
//!
//! Zhukov, Iones and Kronin 1998, "An Ambient Light Illumination Model".

use glam::Vec3;
use kinetree::Ray;

use super::Integrator;
use crate::warp::{Basis, cosine_hemisphere};
use crate::{Sampler, Tracer};

/// Ambient occlusion, in shades of grey.
#[derive(Debug, Clone, Copy)]
pub struct Ambient;

impl Integrator for Ambient {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: &Ray, sampler: &mut Sampler) -> [f32; 3] {
        sampler.begin_bounce(0);
        let Some(point) = tracer.see(ray) else { return [1.0; 3] };
        let direction = Basis::around(point.normal).to_world(cosine_hemisphere(sampler.next_2d().into())).normalize();
        let reach = 0.5 * point.position.distance(Vec3::from(ray.origin));
        // Below the true surface everything is blocked.
        let open = point.facing.dot(direction) > 0.0
            && !tracer.occluded(&Ray::new(point.origin(direction).into(), direction.into()).with_range(0.0, reach));
        [f32::from(u8::from(open)); 3]
    }

    fn is_display_ready(&self) -> bool {
        true
    }
}
