//! Which instance and which triangle is where: a hue for each instance, a shade for each triangle.

use kinetree::Ray;

use super::{Integrator, NOTHING, shaded};
use crate::color::from_hue;
use crate::sampler::{combine, unit_hash};
use crate::{Sampler, Tracer};

/// Instances and triangles as colours.
#[derive(Debug, Clone, Copy)]
pub struct Ids;

impl Integrator for Ids {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: &Ray, _: &mut Sampler) -> [f32; 3] {
        let Some(point) = tracer.see(ray) else { return NOTHING };
        let shade = unit_hash(combine(point.instance, point.primitive));
        let color = from_hue(unit_hash(point.instance), 0.5 + 0.3 * shade, 0.45 + 0.5 * shade);
        shaded(color, &point, ray)
    }

    fn is_display_ready(&self) -> bool {
        true
    }
}
