//! All that shines in a frame, and how to ask for its light.
//!
//! There are three groups, asked separately at every place: triangles that emit, points and spots, and suns. None has to
//! compete with the others for samples, so a lamp in a room is not forgotten because of the sun outside. Triangles and suns
//! are drawn in proportion to their power, points and spots by what they would bring to the place, as long as there are not
//! too many to ask them all.
//!
//! The sky is not asked: it is smooth, and a surface that spreads light finds it by scattering as well as by any other draw.
//! A shadow ray to it would be a second ray with the same distribution; without it every sun has a sample at every place.
//! An image of the surroundings would be another kind of sky, in `far.rs`, and would have to be asked.

mod alias;
mod emitters;
mod far;
mod punctual;

use std::ops::Range;

use glam::Vec3;

use crate::color::luminance;
use crate::interaction::SurfaceInteraction;
use crate::sampler::unit;
use crate::{Frame, Sampler};
use alias::AliasTable;
use emitters::Emitter;
use far::Sun;
use punctual::Punctual;

/// Light that would shade_vertex at a place if nothing stood in its way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LightSample {
    /// Unit, to the light.
    pub(crate) direction: Vec3,
    /// Metres; infinite for what is far.
    pub(crate) distance: f32,
    /// Radiance; for a light without extent, irradiance on a surface that faces it.
    pub(crate) radiance: Vec3,
    /// Per steradian; for a light without extent, a probability.
    pub(crate) pdf: f32,
    /// Whether the light has no extent, so that no ray could have found it by itself.
    pub(crate) is_delta: bool,
}

/// Up to so many points and spots are weighed one by one at every place; of more, one is drawn by its power.
const MOST_WEIGHED: usize = 256;

/// The lights of a frame.
pub(crate) struct LightTable<'a> {
    frame: &'a Frame,
    emitters: Vec<Emitter>,
    /// For each instance, where its emitters stand.
    of_instance: Vec<Range<u32>>,
    /// By power.
    near: AliasTable,
    punctual: Vec<Punctual>,
    /// By power.
    punctual_odds: AliasTable,
    suns: Vec<Sun>,
    /// By power.
    sun_odds: AliasTable,
    /// Whether the sky is not black.
    has_sky: bool,
}

impl<'a> LightTable<'a> {
    /// Gathers all lights of a frame.
    pub(crate) fn new(frame: &'a Frame) -> Self {
        let emitters = emitters::gather(frame);
        let mut of_instance = vec![0..0; frame.view.instances().len()];
        let mut start = 0;
        for run in emitters.chunk_by(|a, b| a.instance == b.instance) {
            let end = start + run.len() as u32;
            of_instance[run[0].instance as usize] = start..end;
            start = end;
        }
        let punctual: Vec<_> = frame.lights.iter().filter_map(Punctual::new).collect();
        let suns: Vec<_> = frame.lights.iter().filter_map(Sun::new).collect();
        let near: Vec<f64> = emitters.iter().map(|emitter| f64::from(emitter.power)).collect();
        let points: Vec<f64> = punctual.iter().map(|light| f64::from(light.power())).collect();
        let powers: Vec<f64> = suns.iter().map(|sun| f64::from(sun.power())).collect();
        Self {
            near: AliasTable::new(&near),
            punctual_odds: AliasTable::new(&points),
            sun_odds: AliasTable::new(&powers),
            has_sky: far::sky_power(&frame.material_set.sky) > 0.0,
            frame,
            emitters,
            of_instance,
            punctual,
            suns,
        }
    }

    /// Whether there is a sun, or a sky that is not black.
    pub(crate) fn has_far(&self) -> bool {
        !self.suns.is_empty() || self.has_sky
    }

    /// Radiance of the sky from a direction.
    pub(crate) fn sky(&self, direction: Vec3) -> Vec3 {
        far::sky_radiance(&self.frame.material_set.sky, direction)
    }

    /// The direction to each sun, and its irradiance on a surface that faces it.
    pub(crate) fn suns(&self) -> impl Iterator<Item = (Vec3, Vec3)> + '_ {
        self.suns.iter().map(Sun::middle)
    }

    /// Luminance of the irradiance of suns and sky in the open, about.
    pub(crate) fn daylight(&self) -> f32 {
        self.suns.iter().map(Sun::power).sum::<f32>() + far::sky_power(&self.frame.material_set.sky)
    }

    /// Whether anything shines at all.
    pub(crate) fn is_empty(&self) -> bool {
        self.near.is_empty() && self.punctual.is_empty() && !self.has_far()
    }

    /// Asks one of the triangles.
    pub(crate) fn sample_near(&self, point: &SurfaceInteraction<'_>, sampler: &mut Sampler) -> Option<LightSample> {
        if self.near.is_empty() {
            return None;
        }
        let index = draw(&self.near, sampler)?;
        let (from, u) = (point.offset_origin(point.geometric_normal), sampler.next_2d());
        chosen(self.emitters[index].sample(self.frame, from, u), self.near.probability(index))
    }

    /// Asks one of the points and spots.
    pub(crate) fn sample_punctual(&self, point: &SurfaceInteraction<'_>, sampler: &mut Sampler) -> Option<LightSample> {
        if self.punctual.is_empty() {
            return None;
        }
        let from = point.offset_origin(point.geometric_normal);
        if self.punctual.len() <= MOST_WEIGHED {
            return punctual::sample_one(&self.punctual, from, point.shading_normal, sampler.next_1d());
        }
        let index = draw(&self.punctual_odds, sampler)?;
        chosen(self.punctual[index].sample(from), self.punctual_odds.probability(index))
    }

    /// Asks one of the suns.
    pub(crate) fn sample_sun(&self, sampler: &mut Sampler) -> Option<LightSample> {
        if self.sun_odds.is_empty() {
            return None;
        }
        let index = draw(&self.sun_odds, sampler)?;
        chosen(Some(self.suns[index].sample(sampler.next_2d())), self.sun_odds.probability(index))
    }

    /// Every light without extent, as it arrives where rays start.
    pub(crate) fn deltas(&self, from: Vec3) -> impl Iterator<Item = LightSample> + '_ {
        let near = self.punctual.iter().filter_map(move |light| light.sample(from));
        near.chain(self.suns.iter().map(|sun| sun.sample([0.5; 2]))).filter(|light| light.is_delta)
    }

    /// The pdf per solid angle with which [`LightTable::sample_near`] at `from` finds a place on a triangle. Zero for
    /// triangles that are no lights.
    pub(crate) fn near_density(&self, from: Vec3, instance: u32, primitive: u32, at: Vec3) -> f32 {
        let Some(range) = self.of_instance.get(instance as usize) else { return 0.0 };
        let (start, end) = (range.start as usize, range.end as usize);
        match self.emitters[start..end].binary_search_by_key(&primitive, |emitter| emitter.primitive) {
            Ok(found) => self.near.probability(start + found) * self.emitters[start + found].pdf(from, at),
            Err(_) => 0.0,
        }
    }

    /// What is seen in a direction in which nothing is: each light's radiance, and the pdf per solid angle with which
    /// [`LightTable::sample_sun`] finds the direction.
    pub(crate) fn seen_far(&self, direction: Vec3) -> impl Iterator<Item = (Vec3, f32)> + '_ {
        let suns = self.suns.iter().enumerate().filter_map(move |(index, sun)| {
            sun.seen(direction).map(|(radiance, pdf)| (radiance, pdf * self.sun_odds.probability(index)))
        });
        suns.chain([(far::sky_radiance(&self.frame.material_set.sky, direction), 0.0)])
    }
}

fn draw(table: &AliasTable, sampler: &mut Sampler) -> Option<usize> {
    let [slot, owner] = sampler.next_bits();
    table.draw(slot, unit(owner))
}

/// A sample of a light that was itself drawn with a probability; `None` when nothing arrives.
fn chosen(sample: Option<LightSample>, probability: f32) -> Option<LightSample> {
    sample
        .map(|light| LightSample { pdf: light.pdf * probability, ..light })
        .filter(|light| light.pdf > 0.0 && luminance(light.radiance) > 0.0)
}
