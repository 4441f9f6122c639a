//! The lights of a frame, and sampling them.
//!
//! There are three groups, each sampled at every vertex: emissive triangles, point and spot lights,
//! and suns. The groups do not compete for samples, so a lamp in a room is not neglected because of
//! the sun outside. Triangles and suns are drawn in proportion to their power, points and spots by
//! their unshadowed contribution to the vertex, as long as there are few enough to evaluate them
//! all.
//!
//! The sky is not sampled as a light: it is smooth, and BSDF sampling of a diffuse surface finds it
//! as well; a shadow ray to it would be a second ray with the same distribution. An environment map
//! would be another kind of sky, in `infinite.rs`, and would have to be sampled.

mod alias;
mod emitters;
mod infinite;
mod punctual;

use std::ops::Range;

use glam::Vec3;
use kinetree_world::Frame;

use crate::Sampler;
use crate::color::luminance;
use crate::interaction::SurfaceInteraction;
use crate::sampler::unit;
use alias::AliasTable;
use emitters::Emitter;
use infinite::Sun;
use punctual::Punctual;

/// A sample of the light that arrives at a point, before visibility.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LightSample {
    /// Unit vector to the light.
    pub(crate) direction: Vec3,
    /// Distance to the light, metres; infinite for suns.
    pub(crate) distance: f32,
    /// Radiance, linear RGB; for a delta light, irradiance on a surface that faces it.
    pub(crate) radiance: Vec3,
    /// Per steradian; for a delta light, a probability.
    pub(crate) pdf: f32,
    /// Whether this is a delta light, without extent, which BSDF sampling cannot find.
    pub(crate) is_delta: bool,
}

/// Up to so many point and spot lights are weighed by their contribution at every vertex; of more,
/// one is drawn by its power.
const MAX_WEIGHED: usize = 256;

/// The lights of a frame.
pub(crate) struct LightTable<'a> {
    frame: &'a Frame,
    emitters: Vec<Emitter>,
    /// For each instance, the range of its emitters.
    of_instance: Vec<Range<u32>>,
    /// Draws an emitter by its power.
    area_table: AliasTable,
    punctual: Vec<Punctual>,
    /// Draws a point or spot light by its power.
    punctual_table: AliasTable,
    suns: Vec<Sun>,
    /// Draws a sun by its power.
    sun_table: AliasTable,
    /// Whether the sky is not black.
    has_sky: bool,
}

impl<'a> LightTable<'a> {
    /// Collects all lights of a frame.
    pub(crate) fn new(frame: &'a Frame) -> Self {
        let emitters = emitters::collect(frame);
        let mut of_instance = vec![0..0; frame.snapshot.instances().len()];
        let mut start = 0;
        for run in emitters.chunk_by(|a, b| a.instance == b.instance) {
            let end = start + run.len() as u32;
            of_instance[run[0].instance as usize] = start..end;
            start = end;
        }
        let punctual: Vec<_> = frame.lights.iter().filter_map(Punctual::new).collect();
        let suns: Vec<_> = frame.lights.iter().filter_map(Sun::new).collect();
        let areas: Vec<f64> = emitters.iter().map(|emitter| f64::from(emitter.power)).collect();
        let points: Vec<f64> = punctual.iter().map(|light| f64::from(light.power())).collect();
        let powers: Vec<f64> = suns.iter().map(|sun| f64::from(sun.power())).collect();
        Self {
            area_table: AliasTable::new(&areas),
            punctual_table: AliasTable::new(&points),
            sun_table: AliasTable::new(&powers),
            has_sky: infinite::sky_power(&frame.sky) > 0.0,
            frame,
            emitters,
            of_instance,
            punctual,
            suns,
        }
    }

    /// Whether there is a sun, or a sky that is not black.
    pub(crate) fn has_infinite(&self) -> bool {
        !self.suns.is_empty() || self.has_sky
    }

    /// Radiance of the sky from a direction.
    pub(crate) fn sky(&self, direction: Vec3) -> Vec3 {
        infinite::sky_radiance(&self.frame.sky, direction)
    }

    /// The direction to each sun, and its irradiance on a surface that faces it.
    pub(crate) fn suns(&self) -> impl Iterator<Item = (Vec3, Vec3)> + '_ {
        self.suns.iter().map(Sun::center)
    }

    /// Approximate luminance of the irradiance of suns and sky at an unoccluded point.
    pub(crate) fn daylight(&self) -> f32 {
        self.suns.iter().map(Sun::power).sum::<f32>() + infinite::sky_power(&self.frame.sky)
    }

    /// Whether there is no light at all.
    pub(crate) fn is_empty(&self) -> bool {
        self.area_table.is_empty() && self.punctual.is_empty() && !self.has_infinite()
    }

    /// Samples one of the emissive triangles.
    pub(crate) fn sample_area_light(
        &self,
        point: &SurfaceInteraction<'_>,
        sampler: &mut Sampler,
    ) -> Option<LightSample> {
        if self.area_table.is_empty() {
            return None;
        }
        let index = draw(&self.area_table, sampler)?;
        let (from, u) = (point.offset_origin(point.geometric_normal), sampler.next_2d());
        with_probability(self.emitters[index].sample(self.frame, from, u), self.area_table.probability(index))
    }

    /// Samples one of the point and spot lights.
    pub(crate) fn sample_punctual(&self, point: &SurfaceInteraction<'_>, sampler: &mut Sampler) -> Option<LightSample> {
        if self.punctual.is_empty() {
            return None;
        }
        let from = point.offset_origin(point.geometric_normal);
        if self.punctual.len() <= MAX_WEIGHED {
            return punctual::sample_one(&self.punctual, from, point.shading_normal, sampler.next_1d());
        }
        let index = draw(&self.punctual_table, sampler)?;
        with_probability(self.punctual[index].sample(from), self.punctual_table.probability(index))
    }

    /// Samples one of the suns.
    pub(crate) fn sample_sun(&self, sampler: &mut Sampler) -> Option<LightSample> {
        if self.sun_table.is_empty() {
            return None;
        }
        let index = draw(&self.sun_table, sampler)?;
        with_probability(Some(self.suns[index].sample(sampler.next_2d())), self.sun_table.probability(index))
    }

    /// A sample of every delta light at a point.
    pub(crate) fn delta_lights(&self, from: Vec3) -> impl Iterator<Item = LightSample> + '_ {
        let near = self.punctual.iter().filter_map(move |light| light.sample(from));
        near.chain(self.suns.iter().map(|sun| sun.sample([0.5; 2]))).filter(|light| light.is_delta)
    }

    /// The pdf per steradian with which [`LightTable::sample_area_light`] samples, from `from`, the
    /// point `at` on a triangle. Zero for triangles that do not emit.
    pub(crate) fn area_light_pdf(&self, from: Vec3, instance: u32, primitive: u32, at: Vec3) -> f32 {
        let Some(range) = self.of_instance.get(instance as usize) else { return 0.0 };
        let (start, end) = (range.start as usize, range.end as usize);
        match self.emitters[start..end].binary_search_by_key(&primitive, |emitter| emitter.primitive) {
            Ok(found) => self.area_table.probability(start + found) * self.emitters[start + found].pdf(from, at),
            Err(_) => 0.0,
        }
    }

    /// Radiance of each infinite light in the direction of a ray that leaves the scene, and the pdf
    /// per steradian with which [`LightTable::sample_sun`] samples the direction.
    pub(crate) fn infinite_lights(&self, direction: Vec3) -> impl Iterator<Item = (Vec3, f32)> + '_ {
        let suns = self.suns.iter().enumerate().filter_map(move |(index, sun)| {
            sun.radiance_from(direction).map(|(radiance, pdf)| (radiance, pdf * self.sun_table.probability(index)))
        });
        suns.chain([(infinite::sky_radiance(&self.frame.sky, direction), 0.0)])
    }
}

fn draw(table: &AliasTable, sampler: &mut Sampler) -> Option<usize> {
    let [slot, owner] = sampler.next_bits();
    table.draw(slot, unit(owner))
}

/// The sample of a light that was drawn with a probability; `None` when it does not contribute.
fn with_probability(sample: Option<LightSample>, probability: f32) -> Option<LightSample> {
    sample
        .map(|light| LightSample { pdf: light.pdf * probability, ..light })
        .filter(|light| light.pdf > 0.0 && luminance(light.radiance) > 0.0)
}
