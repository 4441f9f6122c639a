//! Path tracing with next event estimation: at every non-specular vertex one light of each group is
//! sampled, and combined with BSDF sampling by multiple importance sampling with the power
//! heuristic. Paths of small throughput are ended by Russian roulette.
//!
//! [`Integrator::radiance`] follows one path to its end, `wavefront.rs` many at once; both shade
//! their vertices with [`Path::shade_vertex`].
//!
//! Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering"; Arvo
//! and Kirk 1990, "Particle Transport and Image Synthesis" (roulette).

use glam::Vec3;
use kinetree::Ray;

use super::{Integrator, wavefront};
use crate::interaction::SurfaceInteraction;
use crate::lights::LightSample;
use crate::scatter::{BsdfSample, ScatterKind};
use crate::{Sampler, SceneContext, Tracer, scatter};

/// A path tracer, unbiased up to the number of bounces.
#[derive(Debug, Clone, Copy)]
pub struct Path {
    /// How often a path may scatter.
    pub max_depth: u32,
    /// Upper bound of a single contribution from beyond the first bounce, radiance, if there is
    /// one: less noise, but biased towards dark.
    pub clamp: Option<f32>,
    /// The bounce from which paths may be ended by Russian roulette.
    pub roulette_from: u32,
}

impl Default for Path {
    fn default() -> Self {
        Self { max_depth: 64, clamp: None, roulette_from: 3 }
    }
}

/// The last vertex at which lights were sampled, and how the path left it.
#[derive(Debug, Clone, Copy)]
struct PreviousVertex {
    /// Where its shadow rays started, world space.
    position: Vec3,
    /// Pdf of the direction that BSDF sampling chose there, per steradian.
    pdf: f32,
}

/// A path that has not ended yet.
#[derive(Debug, Clone, Copy)]
pub(super) struct PathState {
    /// Radiance that the path has collected so far.
    radiance: Vec3,
    throughput: Vec3,
    /// `None` when the last vertex was specular, or there was none: then light sampling could not
    /// have found what BSDF sampling finds.
    previous: Option<PreviousVertex>,
    /// Product of the squared relative indices of refraction, which takes the scaling of radiance
    /// by refraction out of the throughput for Russian roulette.
    eta_scale: f32,
    /// Upper bound of a single contribution.
    clamp: f32,
}

/// One light sample per group of lights, whose visibility has to be tested.
pub(super) type ShadowQueries = [Option<ShadowQuery>; 3];

/// A light sample whose visibility has to be tested.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShadowQuery {
    /// From the vertex to the light.
    pub(super) ray: Ray,
    /// Throughput times BSDF times cosine.
    throughput: Vec3,
    /// Radiance of the light sample.
    radiance: Vec3,
    /// Weight of multiple importance sampling over pdf.
    scale: f32,
}

impl Integrator for Path {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: &Ray, sampler: &mut Sampler) -> [f32; 3] {
        let context = tracer.context();
        let (mut ray, mut state) = (*ray, PathState::default());
        for bounce in 0..=self.max_depth {
            let point = tracer.intersect(&ray);
            let (shadow_queries, next) =
                self.shade_vertex(context, &mut state, (&ray, point.as_ref()), sampler, bounce);
            for query in shadow_queries.iter().flatten() {
                state.add_light_sample(query, tracer.transmittance(&query.ray));
            }
            let Some(next) = next else { break };
            ray = next;
        }
        state.radiance().into()
    }

    fn radiances(&self, tracer: &mut Tracer<'_>, rays: &[Ray], samplers: &mut [Sampler], colors: &mut [[f32; 3]]) {
        wavefront::radiances(self, tracer, rays, samplers, colors);
    }
}

impl Path {
    /// Shades the vertex where a ray of the path ends (`None`: it left the scene): adds emitted
    /// radiance, samples lights and the BSDF. Returns the light samples whose visibility has to be
    /// tested, and the next ray, if the path goes on.
    pub(super) fn shade_vertex(
        &self,
        context: &SceneContext<'_>,
        state: &mut PathState,
        (ray, point): (&Ray, Option<&SurfaceInteraction<'_>>),
        sampler: &mut Sampler,
        bounce: u32,
    ) -> (ShadowQueries, Option<Ray>) {
        let (lights, mut shadow_queries) = (&context.lights, [None; 3]);
        sampler.begin_bounce(bounce);
        if bounce > 0 {
            state.clamp = self.clamp.unwrap_or(f32::INFINITY);
        }
        let direction = Vec3::from(ray.direction);
        let Some(point) = point else {
            for (radiance, pdf) in lights.infinite_lights(direction) {
                state.add_emission(radiance, |_| pdf);
            }
            return (shadow_queries, None);
        };
        if point.emission != Vec3::ZERO {
            state.add_emission(point.emission, |from| {
                lights.area_light_pdf(from, point.instance, point.primitive, point.position)
            });
        }
        if bounce == self.max_depth {
            return (shadow_queries, None);
        }
        if scatter::is_non_specular(point) {
            let area = lights.sample_area_light(point, sampler);
            let punctual = lights.sample_punctual(point, sampler);
            let sun = lights.sample_sun(sampler);
            shadow_queries =
                [state.shadow_query(point, area), state.shadow_query(point, punctual), state.shadow_query(point, sun)];
        }
        let Some(next) = scatter::sample(point, -direction, sampler) else { return (shadow_queries, None) };
        state.scatter(point, &next);
        if bounce >= self.roulette_from && !state.survives_roulette(sampler.next_1d()) {
            return (shadow_queries, None);
        }
        (shadow_queries, Some(Ray::new(point.offset_origin(next.direction).into(), next.direction.into())))
    }
}

impl Default for PathState {
    fn default() -> Self {
        Self { radiance: Vec3::ZERO, throughput: Vec3::ONE, previous: None, eta_scale: 1.0, clamp: f32::INFINITY }
    }
}

impl PathState {
    /// Radiance that the path has collected so far.
    pub(super) fn radiance(&self) -> Vec3 {
        self.radiance
    }

    /// Adds emitted radiance found by BSDF sampling. `pdf` is that of light sampling at a position
    /// for the same direction.
    fn add_emission(&mut self, radiance: Vec3, pdf: impl Fn(Vec3) -> f32) {
        let weight = self.previous.map_or(1.0, |previous| power_heuristic(previous.pdf, pdf(previous.position)));
        self.add(self.throughput * radiance * weight);
    }

    /// The visibility test for a light sample; `None` when it would not contribute.
    fn shadow_query(&self, point: &SurfaceInteraction<'_>, light: Option<LightSample>) -> Option<ShadowQuery> {
        let light = light?;
        let (scattered, pdf) = scatter::evaluate(point, light.direction);
        if scattered == Vec3::ZERO {
            return None;
        }
        let weight = if light.is_delta { 1.0 } else { power_heuristic(light.pdf, pdf) };
        Some(ShadowQuery {
            ray: point.ray(light.direction, light.distance),
            throughput: self.throughput * scattered,
            radiance: light.radiance,
            scale: weight / light.pdf,
        })
    }

    /// Adds a light sample, times the transmittance of its shadow ray.
    pub(super) fn add_light_sample(&mut self, query: &ShadowQuery, transmittance: Vec3) {
        self.add(query.throughput * transmittance * query.radiance * query.scale);
    }

    fn add(&mut self, light: Vec3) {
        let brightest = light.max_element();
        self.radiance += if brightest > self.clamp { light * (self.clamp / brightest) } else { light };
    }

    /// Goes on in a sampled direction.
    fn scatter(&mut self, point: &SurfaceInteraction<'_>, next: &BsdfSample) {
        self.throughput *= next.weight;
        match next.kind {
            ScatterKind::NonSpecular { pdf } => {
                let position = point.offset_origin(point.geometric_normal);
                self.previous = Some(PreviousVertex { position, pdf });
            }
            ScatterKind::SpecularReflection => self.previous = None,
            ScatterKind::SpecularTransmission { eta } => {
                self.previous = None;
                self.eta_scale *= eta * eta;
            }
            // Light sampling computes its weight without the thin glass on the way. The previous
            // vertex is kept here too, so that the weights of both techniques sum to one.
            ScatterKind::StraightThrough => {}
        }
    }

    /// Russian roulette: the path survives with a probability of its throughput, which is divided
    /// by it.
    fn survives_roulette(&mut self, u: f32) -> bool {
        let probability = (self.throughput.max_element() * self.eta_scale).min(1.0);
        if u >= probability {
            return false;
        }
        self.throughput /= probability;
        true
    }
}

/// The power heuristic with exponent 2: the weight of a technique with pdf `own` against another
/// with pdf `other` (Veach and Guibas 1995).
fn power_heuristic(own: f32, other: f32) -> f32 {
    let ratio = other / own;
    let weight = 1.0 / (1.0 + ratio * ratio);
    if weight.is_finite() { weight } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_of_two_techniques_sum_to_one() {
        for (a, b) in [(1.0, 1.0), (0.1, 3.0), (1e-20, 1e20), (0.0, 1.0), (1.0, 0.0)] {
            assert!((power_heuristic(a, b) + power_heuristic(b, a) - 1.0).abs() < 1e-6, "{a} {b}");
        }
    }
}
