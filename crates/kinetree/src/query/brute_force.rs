//! The slow twin of every query: tests every triangle of every instance. No tree, no box.

use super::candidate::QueryFilter;
use super::collector::{DynamicCollector, HitCollector, Wanted};
use super::in_double::RayInInstance;
use super::two_level::Rules;
use crate::geometry::Ray;
use crate::traverse::FrameBvh;

/// What is wanted of the hits of a ray; `None` when the ray cannot hit anything.
pub(crate) fn trace(
    world: &FrameBvh,
    ray: &Ray,
    rules: Rules<QueryFilter<'_>>,
    wanted: Wanted,
) -> Option<DynamicCollector> {
    let ray = ray.validated()?;
    let mut collector = DynamicCollector::new(wanted, ray.t_max);
    for instance in 0..world.instances.len() as u32 {
        let Some(ray) = RayInInstance::enter(world, &ray, instance, rules) else { continue };
        let watertight = ray.watertight();
        for primitive in 0..ray.mesh().triangles.len() as u32 {
            let Some(hit) = ray.hit(&watertight, primitive, collector.t_max()) else { continue };
            if collector.collect(hit).is_break() {
                return Some(collector);
            }
        }
    }
    Some(collector)
}
