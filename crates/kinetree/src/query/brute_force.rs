//! The slow twin of every question: look at every triangle of every instance. No tree, no box.

use super::in_double::RayInInstance;
use super::trace_ray::{HitCollector, Rules};
use super::{AllHits, Closest, Filter, Hit, Occluded};
use crate::geometry::Ray;
use crate::traverse::FrameBvh;

/// Brings every hit of a valid ray to `collector`.
pub(crate) fn look(world: &FrameBvh, ray: &Ray, rules: Rules<impl Filter>, collector: &mut impl HitCollector) {
    for instance in 0..world.instances.len() as u32 {
        let Some(ray) = RayInInstance::enter(world, ray, instance, rules) else { continue };
        let watertight = ray.sheared();
        for primitive in 0..ray.mesh().triangles.len() as u32 {
            let Some(hit) = ray.hit(&watertight, primitive, collector.t_max()) else { continue };
            if collector.collect(hit).is_break() {
                return;
            }
        }
    }
}

/// The nearest hit.
pub(crate) fn closest(world: &FrameBvh, ray: &Ray, rules: Rules<impl Filter>) -> Option<Hit> {
    let mut closest = Closest::within(ray.t_max);
    look(world, ray, rules, &mut closest);
    closest.answer(world.stamp)
}

/// Whether there is any hit.
pub(crate) fn occluded(world: &FrameBvh, ray: &Ray, rules: Rules<impl Filter>) -> bool {
    let mut occluded = Occluded::within(ray.t_max);
    look(world, ray, rules, &mut occluded);
    occluded.answer(world.stamp)
}

/// Every hit, near to far.
pub(crate) fn all_hits(world: &FrameBvh, ray: &Ray, rules: Rules<impl Filter>) -> Vec<Hit> {
    let mut all = AllHits::within(ray.t_max);
    look(world, ray, rules, &mut all);
    all.answer(world.stamp)
}
