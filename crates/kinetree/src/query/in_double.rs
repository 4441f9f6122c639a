//! A ray in one instance, triangle by triangle: for the slow twin, and for placements that rays
//! enter in double precision.
//!
//! See [`inverse`](crate::geometry::inverse) for those. They are rare, so this is compiled once, at
//! the scalar level.

use std::ops::ControlFlow;

use super::Hit;
use super::candidate::{Filter, QueryFilter};
use super::collector::{DynamicCollector, HitCollector};
use super::two_level::{Instance, Rules};
use crate::geometry::inverse::LocalRay;
use crate::geometry::slab::{ErrorBound, SafeRay};
use crate::geometry::{Precision, Ray, WatertightRay};
use crate::simd::Scalar;
use crate::traverse::{DoublePrecisionRay, FrameBvh, MeshFrame, Tally, WideVisitor, Work, walk_wide};
use crate::wide::WideLink;

/// A ray in the space of one instance.
pub(crate) struct RayInInstance<'a> {
    local: Ray,
    /// The same, where it was entered in double precision.
    double: Option<LocalRay>,
    t_min: f32,
    instance: Instance<'a>,
    rules: Rules<QueryFilter<'a>>,
}

impl<'a> RayInInstance<'a> {
    /// `None` when the ray cannot hit anything there.
    pub(crate) fn enter(world: &'a FrameBvh, ray: &Ray, instance: u32, rules: Rules<QueryFilter<'a>>) -> Option<Self> {
        let instance = Instance::of(world, instance);
        let Instance { index, record, mesh } = instance;
        if record.mask & rules.mask == 0 || !rules.filter.sees(index) {
            return None;
        }
        let double = if record.in_double { Some(world.double(index)?.enter(ray, &mesh.bvh.bounds())?) } else { None };
        let local = match &double {
            Some(double) => double.ray,
            None => record.enter(ray)?,
        };
        Some(Self { local, double, t_min: ray.t_min, instance, rules })
    }

    pub(crate) fn mesh(&self) -> &'a MeshFrame {
        self.instance.mesh
    }

    pub(crate) fn watertight(&self) -> WatertightRay {
        WatertightRay::new(&self.local)
    }

    /// Hits beyond this along the local ray are beyond `t_max` in the world.
    fn local_t_max(&self, t_max: f32) -> f32 {
        self.double.as_ref().map_or(t_max, |double| double.beyond(t_max))
    }

    /// The hit of one triangle, if it counts.
    #[inline]
    pub(crate) fn hit(&self, watertight: &WatertightRay, primitive: u32, t_max: f32) -> Option<Hit> {
        let triangle = self.instance.mesh.triangles.get(primitive);
        let local_t_max = self.local_t_max(t_max);
        let mut hit = match self.instance.mesh.precision {
            Precision::Watertight => watertight.hit(&triangle, self.local.t_min, local_t_max)?,
            Precision::Fast => watertight.hit_fast(&triangle, self.local.t_min, local_t_max)?,
        };
        if let Some(double) = &self.double {
            hit.t = double.in_world(hit.t);
            if !(self.t_min <= hit.t && hit.t <= t_max && hit.t.is_finite()) {
                return None;
            }
        }
        let counts = self.rules.count(&hit, primitive, &self.instance);
        counts.then(|| Hit::new(&hit, primitive, self.instance.index))
    }
}

/// Walks the tree of an instance that is entered in double precision.
#[cold]
#[inline(never)]
pub(super) fn enter(
    world: &FrameBvh,
    ray: &Ray,
    instance: u32,
    rules: Rules<QueryFilter<'_>>,
    collector: &mut DynamicCollector,
    work: &mut Work,
) -> ControlFlow<()> {
    let Some(ray) = RayInInstance::enter(world, ray, instance, rules) else { return ControlFlow::Continue(()) };
    let tree = ray.mesh().bvh.tree();
    let safe = SafeRay::new(&ray.local, tree.around(), ErrorBound::TRIANGLES);
    let mut visitor = OneByOne { watertight: ray.watertight(), ray: &ray, collector, done: ControlFlow::Continue(()) };
    walk_wide(Scalar, tree, DoublePrecisionRay(&safe), &mut visitor, work);
    visitor.done
}

struct OneByOne<'a> {
    ray: &'a RayInInstance<'a>,
    watertight: WatertightRay,
    collector: &'a mut DynamicCollector,
    done: ControlFlow<()>,
}

impl<T: Tally> WideVisitor<Scalar, T> for OneByOne<'_> {
    fn wants_any(&self) -> bool {
        self.collector.wants_any()
    }

    fn t_max(&self) -> f32 {
        self.ray.local_t_max(self.collector.t_max())
    }

    fn leaf(&mut self, _: Scalar, link: WideLink, tally: &mut T) -> ControlFlow<()> {
        for item in link.item_index()..link.item_index() + link.item_count() {
            let block = self.ray.mesh().bvh.block(item);
            tally.block(block.count);
            for &primitive in &block.primitives[..block.count as usize] {
                if let Some(hit) = self.ray.hit(&self.watertight, primitive, self.collector.t_max()) {
                    self.done = self.collector.collect(hit);
                    self.done?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}
