//! Path tracing in its simplest form: follow a path from the camera, sample the BSDF at each
//! vertex, and add what is emitted.
//!
//! Only delta lights are sampled directly, since BSDF sampling cannot find them. Kajiya 1986, "The
//! Rendering Equation".

use glam::Vec3;
use kinetree::Ray;

use super::Integrator;
use crate::{Sampler, Tracer, scatter};

/// The slow twin of [`Path`](super::Path).
#[derive(Debug, Clone, Copy)]
pub struct SimplePath {
    /// How often a path may scatter.
    pub max_depth: u32,
}

impl Integrator for SimplePath {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: &Ray, sampler: &mut Sampler) -> [f32; 3] {
        let lights = &tracer.context().lights;
        let (mut ray, mut gathered, mut throughput) = (*ray, Vec3::ZERO, Vec3::ONE);
        for bounce in 0..=self.max_depth {
            sampler.begin_bounce(bounce);
            let direction = Vec3::from(ray.direction);
            let Some(point) = tracer.intersect(&ray) else {
                let seen: Vec3 = lights.infinite_lights(direction).map(|(radiance, _)| radiance).sum();
                return (gathered + throughput * seen).into();
            };
            gathered += throughput * point.emission;
            if bounce == self.max_depth {
                break;
            }
            if scatter::is_non_specular(&point) {
                for light in lights.delta_lights(point.offset_origin(point.geometric_normal)) {
                    let (scattered, _) = scatter::evaluate(&point, light.direction);
                    if scattered != Vec3::ZERO {
                        let arriving =
                            tracer.transmittance(&point.ray(light.direction, light.distance)) * light.radiance;
                        gathered += throughput * scattered * arriving;
                    }
                }
            }
            let Some(next) = scatter::sample(&point, -direction, sampler) else { break };
            throughput *= next.weight;
            ray = Ray::new(point.offset_origin(next.direction).into(), next.direction.into());
        }
        gathered.into()
    }
}
