//! Path tracing that asks the lights: at every place that spreads light, one light of each group is sampled, and what
//! paths find by themselves is weighed against that by the power heuristic. Paths that carry little are ended by Russian
//! roulette.
//!
//! `radiance` follows one path to its end, `wavefront.rs` many at once; what happens at a place is the same.
//!
//! Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering"; Arvo and Kirk 1990,
//! "Particle Transport and Image Synthesis" (roulette).

use glam::Vec3;
use kinetree::Ray;

use super::{Integrator, wavefront};
use crate::interaction::SurfaceInteraction;
use crate::lights::LightSample;
use crate::scatter::{BsdfSample, ScatterKind};
use crate::{Sampler, SceneContext, Tracer, scatter};

/// Unbiased light transport, up to the number of bounces.
#[derive(Debug, Clone, Copy)]
pub struct Path {
    /// How often a path may scatter.
    pub max_depth: u32,
    /// The most radiance that one path may bring from beyond its first bounce, if bounded: less noise, and less light.
    pub clamp: Option<f32>,
    /// The bounce from which paths may end by roulette.
    pub roulette_from: u32,
}

impl Default for Path {
    fn default() -> Self {
        Self { max_depth: 64, clamp: None, roulette_from: 3 }
    }
}

/// The latest place at which lights were asked, and how the path left it.
#[derive(Debug, Clone, Copy)]
struct PreviousVertex {
    /// Where its rays started.
    position: Vec3,
    /// Per steradian.
    pdf: f32,
}

/// A path on its way.
#[derive(Debug, Clone, Copy)]
pub(super) struct PathState {
    radiance: Vec3,
    throughput: Vec3,
    /// `None` when only mirrors and boundaries lie between here and the camera: then no light was asked about this way.
    previous: Option<PreviousVertex>,
    /// Product of eta squared: how much radiance was compressed on the way in, and will be spread on the way out.
    eta_scale: f32,
    /// What one contribution may add.
    clamp: f32,
}

/// What a path would get from a light of each group, if nothing stood in the way.
pub(super) type ShadowQueries = [Option<ShadowQuery>; 3];

/// A light that is asked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShadowQuery {
    /// From the place to the light.
    pub(super) ray: Ray,
    /// What the path brings to the camera of the light that arrives.
    carried: Vec3,
    radiance: Vec3,
    /// Weight over pdf.
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
    /// What happens where a ray arrives, at a point or nowhere: the light found there is added, and lights are chosen to be
    /// asked. Gives the ray on which the path goes on, if it does.
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
            for (radiance, pdf) in lights.seen_far(direction) {
                state.add_emission(radiance, |_| pdf);
            }
            return (shadow_queries, None);
        };
        if point.emission != Vec3::ZERO {
            state.add_emission(point.emission, |from| {
                lights.near_density(from, point.instance, point.primitive, point.position)
            });
        }
        if bounce == self.max_depth {
            return (shadow_queries, None);
        }
        if scatter::is_non_specular(point) {
            let near = lights.sample_near(point, sampler);
            let punctual = lights.sample_punctual(point, sampler);
            let sun = lights.sample_sun(sampler);
            shadow_queries =
                [state.shadow_query(point, near), state.shadow_query(point, punctual), state.shadow_query(point, sun)];
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
    /// The light that the path has brought so far.
    pub(super) fn radiance(&self) -> Vec3 {
        self.radiance
    }

    /// Adds light that the path came upon. `pdf` says how likely asking from a place would have found it.
    fn add_emission(&mut self, radiance: Vec3, pdf: impl Fn(Vec3) -> f32) {
        let weight = self.previous.map_or(1.0, |previous| power_heuristic(previous.pdf, pdf(previous.position)));
        self.add(self.throughput * radiance * weight);
    }

    /// What is to be asked about a sampled light; `None` when it would not be seen anyway.
    fn shadow_query(&self, point: &SurfaceInteraction<'_>, light: Option<LightSample>) -> Option<ShadowQuery> {
        let light = light?;
        let (scattered, pdf) = scatter::evaluate(point, light.direction);
        if scattered == Vec3::ZERO {
            return None;
        }
        let weight = if light.is_delta { 1.0 } else { power_heuristic(light.pdf, pdf) };
        Some(ShadowQuery {
            ray: point.ray(light.direction, light.distance),
            carried: self.throughput * scattered,
            radiance: light.radiance,
            scale: weight / light.pdf,
        })
    }

    /// Adds the light that was asked for, as far as it got through.
    pub(super) fn add_light_sample(&mut self, query: &ShadowQuery, passed: Vec3) {
        self.add(query.carried * passed * query.radiance * query.scale);
    }

    fn add(&mut self, light: Vec3) {
        let brightest = light.max_element();
        self.radiance += if brightest > self.clamp { light * (self.clamp / brightest) } else { light };
    }

    /// Goes on in a direction.
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
            // Asking lights does not know what panes are on the way when it weighs: neither does this, so that the weights of
            // the two ways sum to one.
            ScatterKind::StraightThrough => {}
        }
    }

    /// Roulette: the path goes on as likely as it carries light, and carries accordingly more. What was compressed by a
    /// dense medium does not count as lost.
    fn survives_roulette(&mut self, u: f32) -> bool {
        let chance = (self.throughput.max_element() * self.eta_scale).min(1.0);
        if u >= chance {
            return false;
        }
        self.throughput /= chance;
        true
    }
}

/// The power heuristic with the square, for a way of pdf `own` against another of pdf `other`.
fn power_heuristic(own: f32, other: f32) -> f32 {
    let ratio = other / own;
    let weight = 1.0 / (1.0 + ratio * ratio);
    if weight.is_finite() { weight } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_of_two_ways_sum_to_one() {
        for (a, b) in [(1.0, 1.0), (0.1, 3.0), (1e-20, 1e20), (0.0, 1.0), (1.0, 0.0)] {
            assert!((power_heuristic(a, b) + power_heuristic(b, a) - 1.0).abs() < 1e-6, "{a} {b}");
        }
    }
}
