//! Tracing rays through a frame: closest hits, visibility, and what thin glass lets through.

use glam::Vec3;
use kinetree::{Candidate, Hit, Ray, Work};

use crate::coherent_runs::coherent_runs;
use crate::interaction::SurfaceInteraction;
use crate::{SceneContext, scatter};

/// Traces rays through a frame, and counts them. Each thread has its own.
#[derive(Debug)]
pub struct Tracer<'a> {
    context: &'a SceneContext<'a>,
    /// Seeds the stochastic alpha test: the same for all rays of one sample.
    salt: u32,
    rays: u64,
}

/// After so many hits on thin glass a shadow ray counts as blocked.
const MAX_THIN_GLASS: u32 = 64;

/// Behind thin glass a shadow ray starts again at this multiple of the distance to it, so that it
/// does not hit the same triangle again.
const BEYOND: f32 = 1.0 + 4.0 * f32::EPSILON;

impl<'a> Tracer<'a> {
    /// A tracer that has traced nothing.
    pub fn new(context: &'a SceneContext<'a>) -> Self {
        Self { context, salt: 0, rays: 0 }
    }

    /// Begins another sample, with its own salt for the stochastic alpha test.
    pub fn begin_sample(&mut self, salt: u32) {
        self.salt = salt;
    }

    /// The frame it traces, with lights.
    pub fn context(&self) -> &'a SceneContext<'a> {
        self.context
    }

    /// The number of rays traced so far.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// The closest hit of a ray, with the alpha test of the materials.
    pub fn closest_hit(&mut self, ray: &Ray) -> Option<Hit> {
        self.rays += 1;
        self.context
            .query(&|candidate: &Candidate<'_>| self.context.passes_alpha_test(candidate, self.salt))
            .closest_hit(ray)
    }

    /// As [`Tracer::closest_hit`], and adds the nodes and triangles tested to `work`.
    pub fn closest_hit_counted(&mut self, ray: &Ray, work: &mut Work) -> Option<Hit> {
        self.rays += 1;
        let filter = |candidate: &Candidate<'_>| self.context.passes_alpha_test(candidate, self.salt);
        self.context.query(&filter).closest_hit_counted(ray, work)
    }

    /// Whether a ray hits anything, thin glass included, with the alpha test of the materials.
    pub fn occluded(&mut self, ray: &Ray) -> bool {
        self.rays += 1;
        self.context
            .query(&|candidate: &Candidate<'_>| self.context.passes_alpha_test(candidate, self.salt))
            .occluded(ray)
    }

    /// The closest hit of each ray. Rays may belong to different samples: `salts` gives the salt of
    /// the ray with an index.
    ///
    /// # Panics
    /// When there are not as many hits as rays.
    pub fn closest_hits(&mut self, rays: &[Ray], salts: &(dyn Fn(usize) -> u32 + Sync), hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len(), "one hit per ray");
        self.rays += rays.len() as u64;
        for (run, coherence) in coherent_runs(rays) {
            let filter = |candidate: &Candidate<'_>| self.context.passes_alpha_test_in_run(candidate, run.start, salts);
            self.context.query(&filter).closest_hits(&rays[run.clone()], &mut hits[run.clone()], coherence);
        }
    }

    /// Whether each ray hits anything, with salts as for [`Tracer::closest_hits`].
    ///
    /// # Panics
    /// When there are not as many answers as rays.
    pub fn occluded_each(&mut self, rays: &[Ray], salts: &(dyn Fn(usize) -> u32 + Sync), answers: &mut [bool]) {
        assert_eq!(rays.len(), answers.len(), "one answer per ray");
        self.rays += rays.len() as u64;
        for (run, coherence) in coherent_runs(rays) {
            let filter = |candidate: &Candidate<'_>| self.context.passes_alpha_test_in_run(candidate, run.start, salts);
            self.context.query(&filter).occluded_each(&rays[run.clone()], &mut answers[run.clone()], coherence);
        }
    }

    /// The closest hit of a ray of unit direction, with all that shading needs.
    pub(crate) fn intersect(&mut self, ray: &Ray) -> Option<SurfaceInteraction<'a>> {
        let hit = self.closest_hit(ray)?;
        Some(SurfaceInteraction::new(self.context.frame, &hit, ray.direction.into()))
    }

    /// The transmittance of a shadow ray of unit direction: one, zero, or the product of what the
    /// thin glass on its way lets through.
    pub(crate) fn transmittance(&mut self, ray: &Ray) -> Vec3 {
        if !self.occluded(ray) {
            return Vec3::ONE;
        }
        if !self.context.thin_glass.may_intersect(ray) {
            return Vec3::ZERO;
        }
        let first = self.closest_hit(ray);
        self.through_thin_glass(*ray, first)
    }

    /// As [`Tracer::transmittance`], of many rays.
    pub(crate) fn transmittances(&mut self, rays: &[Ray], salts: &(dyn Fn(usize) -> u32 + Sync)) -> Vec<Vec3> {
        let mut dark = vec![false; rays.len()];
        self.occluded_each(rays, salts, &mut dark);
        let mut transmittances: Vec<Vec3> =
            dark.iter().map(|&is_dark| if is_dark { Vec3::ZERO } else { Vec3::ONE }).collect();
        let thin_glass = &self.context.thin_glass;
        let blocked: Vec<usize> =
            (0..rays.len()).filter(|&ray| dark[ray] && thin_glass.may_intersect(&rays[ray])).collect();
        let again: Vec<Ray> = blocked.iter().map(|&ray| rays[ray]).collect();
        let mut hits = vec![None; again.len()];
        self.closest_hits(&again, &|ray| salts(blocked[ray]), &mut hits);
        for ((ray, hit), &index) in again.iter().zip(hits).zip(&blocked) {
            self.salt = salts(index);
            transmittances[index] = self.through_thin_glass(*ray, hit);
        }
        transmittances
    }

    /// The transmittance of a ray whose closest hit is `hit`.
    fn through_thin_glass(&mut self, mut ray: Ray, mut hit: Option<Hit>) -> Vec3 {
        let direction = Vec3::from(ray.direction);
        let mut transmittance = Vec3::ONE;
        for count in 1..=MAX_THIN_GLASS {
            let Some(glass) = hit else { return transmittance };
            let point = SurfaceInteraction::new(self.context.frame, &glass, direction);
            let Some(transmitted) = scatter::straight_transmittance(&point, -direction) else { return Vec3::ZERO };
            transmittance *= transmitted;
            if count < MAX_THIN_GLASS {
                // The origin stays, so that `t_max` still is the distance to the light.
                ray = ray.with_range(glass.t * BEYOND, ray.t_max);
                hit = self.closest_hit(&ray);
            }
        }
        Vec3::ZERO
    }
}
