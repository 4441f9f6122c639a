//! Which way surfaces face: x, y and z of the shading normal as red, green and blue.

use glam::Vec3;
use kinetree::Ray;

use super::{Integrator, NOTHING};
use crate::{Sampler, Tracer};

/// Shading normals in world space as colours, on the side of the viewer.
#[derive(Debug, Clone, Copy)]
pub struct Normals;

impl Integrator for Normals {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: &Ray, _: &mut Sampler) -> [f32; 3] {
        tracer.see(ray).map_or(NOTHING, |point| (point.normal * 0.5 + Vec3::splat(0.5)).into())
    }

    fn is_display_ready(&self) -> bool {
        true
    }
}
