//! A frame made ready for rays: its lights gathered, its holes known, its rays counted.

use glam::Vec3;
use kinetree::{Candidate, Hit, Ray, Work};

use crate::dress::{Dress, is_there};
use crate::lights::LightTable;
use crate::shading::ShadingPoint;
use crate::{Alpha, Frame, Scatter, scatter};

/// A frame with what can be prepared before the first ray. Shared by all threads.
pub struct Stage<'a> {
    frame: &'a Frame,
    pub(crate) lights: LightTable<'a>,
    /// Whether any material has holes.
    has_alpha: bool,
    /// Whether any material lets light straight through.
    has_sheets: bool,
}

impl<'a> Stage<'a> {
    /// Gathers the lights of a frame; takes time in proportion to its emitting triangles.
    pub fn new(frame: &'a Frame) -> Self {
        let materials = &frame.look.materials;
        Self {
            frame,
            lights: LightTable::new(frame),
            has_alpha: materials.iter().any(|material| material.alpha != Alpha::Opaque),
            has_sheets: materials.iter().any(|material| matches!(material.scatter, Scatter::ThinDielectric { .. })),
        }
    }

    /// The frame.
    pub fn frame(&self) -> &'a Frame {
        self.frame
    }
}

/// Asks a stage about rays, and counts them. Each thread has its own.
pub struct Tracer<'a> {
    stage: &'a Stage<'a>,
    /// Decides, for one sample, where blended surfaces are.
    salt: u32,
    rays: u64,
}

/// After so many panes a shadow ray counts as blocked.
const MOST_PANES: u32 = 64;

impl<'a> Tracer<'a> {
    /// A tracer that has traced nothing.
    pub fn new(stage: &'a Stage<'a>) -> Self {
        Self { stage, salt: 0, rays: 0 }
    }

    /// Begins another sample: blended surfaces are decided anew.
    pub fn begin_sample(&mut self, salt: u32) {
        self.salt = salt;
    }

    /// The stage it asks.
    pub fn stage(&self) -> &'a Stage<'a> {
        self.stage
    }

    /// Rays asked so far.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// What a ray hits first; surfaces with holes are there or not as their alpha says.
    pub fn closest_hit(&mut self, ray: &Ray) -> Option<Hit> {
        self.rays += 1;
        let view = &self.stage.frame.view;
        if self.stage.has_alpha {
            view.query().filter(&|candidate: &Candidate<'_>| self.is_there(candidate)).closest_hit(ray)
        } else {
            view.closest_hit(ray)
        }
    }

    /// As [`Tracer::closest_hit`], and counts the work that it took.
    pub fn closest_hit_counted(&mut self, ray: &Ray, work: &mut Work) -> Option<Hit> {
        self.rays += 1;
        let query = self.stage.frame.view.query();
        if self.stage.has_alpha {
            query.filter(&|candidate: &Candidate<'_>| self.is_there(candidate)).closest_hit_counted(ray, work)
        } else {
            query.closest_hit_counted(ray, work)
        }
    }

    /// Whether anything at all lies on a ray.
    pub fn occluded(&mut self, ray: &Ray) -> bool {
        self.rays += 1;
        let view = &self.stage.frame.view;
        if self.stage.has_alpha {
            view.query().filter(&|candidate: &Candidate<'_>| self.is_there(candidate)).occluded(ray)
        } else {
            view.occluded(ray)
        }
    }

    /// The place that a ray of unit direction sees first, ready to be shaded.
    pub(crate) fn see(&mut self, ray: &Ray) -> Option<ShadingPoint<'a>> {
        let hit = self.closest_hit(ray)?;
        Some(ShadingPoint::new(self.stage.frame, &hit, ray.direction.into()))
    }

    /// The fraction of light that comes from a direction, out to a distance, straight to a place: all, nothing, or what
    /// panes let through.
    pub(crate) fn transmitted(&mut self, point: &ShadingPoint<'_>, direction: Vec3, distance: f32) -> Vec3 {
        let ray = Ray::new(point.origin(direction).into(), direction.into()).with_range(0.0, distance);
        if !self.occluded(&ray) {
            return Vec3::ONE;
        }
        if !self.stage.has_sheets {
            return Vec3::ZERO;
        }
        self.through_panes(ray)
    }

    fn through_panes(&mut self, mut ray: Ray) -> Vec3 {
        let direction = Vec3::from(ray.direction);
        let mut fraction = Vec3::ONE;
        for _ in 0..MOST_PANES {
            let Some(hit) = self.closest_hit(&ray) else { return fraction };
            let pane = ShadingPoint::new(self.stage.frame, &hit, direction);
            let Some(passed) = scatter::passed(&pane, -direction) else { return Vec3::ZERO };
            fraction *= passed;
            ray = Ray::new(pane.origin(direction).into(), ray.direction).with_range(0.0, ray.t_max - hit.t);
        }
        Vec3::ZERO
    }

    fn is_there(&self, candidate: &Candidate<'_>) -> bool {
        let frame = self.stage.frame;
        let instance = frame.view.instance_at(candidate.instance_index());
        let at = [candidate.u(), candidate.v()];
        let presence = Dress::at(&frame.look, &instance, candidate.primitive(), at).presence();
        is_there(presence, candidate.instance_index(), candidate.primitive(), at, self.salt)
    }
}
