//! Tracing rays through a frame: closest hits, visibility, and what thin glass lets through.

use glam::Vec3;
use kinetree::{Candidate, Hit, Ray, Work};

use crate::shading::ShadingPoint;
use crate::{SceneContext, alike, scatter};

/// Traces rays through a frame, and counts them. Each thread has its own.
pub struct Tracer<'a> {
    context: &'a SceneContext<'a>,
    /// Decides, for one sample, where blended surfaces are.
    salt: u32,
    rays: u64,
}

/// After so many panes a shadow ray counts as blocked.
const MAX_THIN_GLASS: u32 = 64;

/// A shadow ray goes on at this multiple of the distance to a pane: what is nearer is the pane itself.
const BEYOND: f32 = 1.0 + 4.0 * f32::EPSILON;

impl<'a> Tracer<'a> {
    /// A tracer that has traced nothing.
    pub fn new(context: &'a SceneContext<'a>) -> Self {
        Self { context, salt: 0, rays: 0 }
    }

    /// Begins another sample: blended surfaces are decided anew.
    pub fn begin_sample(&mut self, salt: u32) {
        self.salt = salt;
    }

    /// The frame it traces, with lights.
    pub fn context(&self) -> &'a SceneContext<'a> {
        self.context
    }

    /// Rays asked so far.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// What a ray hits first; surfaces with holes are there or not as their alpha says.
    pub fn closest_hit(&mut self, ray: &Ray) -> Option<Hit> {
        self.rays += 1;
        self.context
            .query(&|candidate: &Candidate<'_>| self.context.passes_alpha_test(candidate, self.salt))
            .closest_hit(ray)
    }

    /// As [`Tracer::closest_hit`], and counts the work that it took.
    pub fn closest_hit_counted(&mut self, ray: &Ray, work: &mut Work) -> Option<Hit> {
        self.rays += 1;
        let filter = |candidate: &Candidate<'_>| self.context.passes_alpha_test(candidate, self.salt);
        self.context.query(&filter).closest_hit_counted(ray, work)
    }

    /// Whether anything at all lies on a ray.
    pub fn occluded(&mut self, ray: &Ray) -> bool {
        self.rays += 1;
        self.context
            .query(&|candidate: &Candidate<'_>| self.context.passes_alpha_test(candidate, self.salt))
            .occluded(ray)
    }

    /// What each of many rays hits first. Rays are of different samples; `salts` gives the salt of each.
    ///
    /// # Panics
    /// When there are not as many hits as rays.
    pub fn closest_hits(&mut self, rays: &[Ray], salts: &(dyn Fn(usize) -> u32 + Sync), hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len(), "one hit per ray");
        self.rays += rays.len() as u64;
        for (run, coherence) in alike::runs(rays) {
            let filter = |candidate: &Candidate<'_>| self.context.passes_alpha_test_in_run(candidate, run.start, salts);
            self.context.query(&filter).closest_hits(&rays[run.clone()], &mut hits[run.clone()], coherence);
        }
    }

    /// Whether anything at all lies on each of many rays, as for [`Tracer::closest_hits`].
    ///
    /// # Panics
    /// When there are not as many answers as rays.
    pub fn occluded_each(&mut self, rays: &[Ray], salts: &(dyn Fn(usize) -> u32 + Sync), answers: &mut [bool]) {
        assert_eq!(rays.len(), answers.len(), "one answer per ray");
        self.rays += rays.len() as u64;
        for (run, coherence) in alike::runs(rays) {
            let filter = |candidate: &Candidate<'_>| self.context.passes_alpha_test_in_run(candidate, run.start, salts);
            self.context.query(&filter).occluded_each(&rays[run.clone()], &mut answers[run.clone()], coherence);
        }
    }

    /// The place that a ray of unit direction sees first, ready to be shaded.
    pub(crate) fn see(&mut self, ray: &Ray) -> Option<ShadingPoint<'a>> {
        let hit = self.closest_hit(ray)?;
        Some(ShadingPoint::new(self.context.frame, &hit, ray.direction.into()))
    }

    /// The fraction of light that comes straight along a ray of unit direction, against its direction: all, nothing, or
    /// what panes let through.
    pub(crate) fn transmitted(&mut self, ray: &Ray) -> Vec3 {
        if !self.occluded(ray) {
            return Vec3::ONE;
        }
        if !self.context.thin_glass.may_intersect(ray) {
            return Vec3::ZERO;
        }
        let first = self.closest_hit(ray);
        self.through_thin_glass(*ray, first)
    }

    /// As [`Tracer::transmitted`], of many rays.
    pub(crate) fn transmitted_each(&mut self, rays: &[Ray], salts: &(dyn Fn(usize) -> u32 + Sync)) -> Vec<Vec3> {
        let mut dark = vec![false; rays.len()];
        self.occluded_each(rays, salts, &mut dark);
        let mut fractions: Vec<Vec3> =
            dark.iter().map(|&is_dark| if is_dark { Vec3::ZERO } else { Vec3::ONE }).collect();
        let thin_glass = &self.context.thin_glass;
        let blocked: Vec<usize> =
            (0..rays.len()).filter(|&ray| dark[ray] && thin_glass.may_intersect(&rays[ray])).collect();
        let again: Vec<Ray> = blocked.iter().map(|&ray| rays[ray]).collect();
        let mut hits = vec![None; again.len()];
        self.closest_hits(&again, &|ray| salts(blocked[ray]), &mut hits);
        for ((ray, hit), &place) in again.iter().zip(hits).zip(&blocked) {
            self.salt = salts(place);
            fractions[place] = self.through_thin_glass(*ray, hit);
        }
        fractions
    }

    /// `hit` is what the ray hits first.
    fn through_thin_glass(&mut self, mut ray: Ray, mut hit: Option<Hit>) -> Vec3 {
        let direction = Vec3::from(ray.direction);
        let mut fraction = Vec3::ONE;
        for count in 1..=MAX_THIN_GLASS {
            let Some(met) = hit else { return fraction };
            let point = ShadingPoint::new(self.context.frame, &met, direction);
            let Some(passed) = scatter::passed(&point, -direction) else { return Vec3::ZERO };
            fraction *= passed;
            if count < MAX_THIN_GLASS {
                // The same ray, so that it ends where it was to end.
                ray = ray.with_range(met.t * BEYOND, ray.t_max);
                hit = self.closest_hit(&ray);
            }
        }
        Vec3::ZERO
    }
}
