//! One ray through both levels.
//!
//! Two queries are compiled for each vector level: the closest hit and occlusion, without filter or
//! counters. All others share a third kernel, which decides at run time what it keeps and which
//! filter it calls; so do all queries at the scalar level. Rays for which single precision
//! overflows, and instances that are entered in double precision, take paths that are compiled
//! once.

use std::ops::ControlFlow;

use super::candidate::{Filter, NoFilter, QueryFilter};
use super::collector::{Closest, DynamicCollector, HitCollector, Occluded, Wanted};
use super::two_level::{EntersInstances, Instance, Rules, enter_instances};
use super::{Hit, in_double};
use crate::geometry::slab::ErrorBound;
use crate::geometry::{Aabb, Precision, Ray, SafeRay};
use crate::simd::{Isa, Kernel, Scalar};
use crate::traverse::{
    DoublePrecisionRay, FrameBvh, RayLanes, RayQuads, Tally, WatertightLanes, WideVisitor, Work, walk_wide,
};
use crate::wide::WideLink;

/// The closest hit.
#[inline]
pub(super) fn closest(world: &FrameBvh, ray: &Ray, rules: Rules<NoFilter>) -> Option<Hit> {
    // The kernel writes the answer where the caller wants it: a copy would wait for its stores.
    world.level.run_vector(TraceRay::<_, Closest, _> { world, ray, rules, wanted: (), tally: &mut () }, || {
        dynamic(world, ray, rules.to_dynamic(world), Wanted::Closest, &mut Work::default())?.hit(world.stamp)
    })
}

/// Whether anything is hit.
#[inline]
pub(super) fn occluded(world: &FrameBvh, ray: &Ray, rules: Rules<NoFilter>) -> bool {
    world.level.run_vector(TraceRay::<_, Occluded, _> { world, ray, rules, wanted: (), tally: &mut () }, || {
        dynamic(world, ray, rules.to_dynamic(world), Wanted::Any, &mut Work::default())
            .is_some_and(|collector| collector.is_hit())
    })
}

/// Any query, with or without a filter, and counted. `None` when the ray cannot hit anything.
pub(super) fn dynamic(
    world: &FrameBvh,
    ray: &Ray,
    rules: Rules<QueryFilter<'_>>,
    wanted: Wanted,
    work: &mut Work,
) -> Option<DynamicCollector> {
    world.level.run(TraceRay::<_, DynamicCollector, _> { world, ray, rules, wanted, tally: work })
}

struct TraceRay<'a, F, C: HitCollector, T> {
    world: &'a FrameBvh,
    ray: &'a Ray,
    rules: Rules<F>,
    wanted: C::Wanted,
    tally: &'a mut T,
}

impl<'a, F: Filter + 'a, C: HitCollector, T: Tally> Kernel for TraceRay<'a, F, C, T> {
    type Output = C::Answer;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> C::Answer {
        // The ray is read where it stands; it is copied only if its range has to be corrected.
        let corrected;
        let ray = if self.ray.has_valid_range() {
            self.ray
        } else {
            let Some(valid) = self.ray.validated() else { return C::Answer::default() };
            corrected = valid;
            &corrected
        };
        let mut collector = C::new(self.wanted, ray.t_max);
        trace_top_level(isa, self.world, ray, self.rules, &mut collector, self.tally);
        collector.answer(self.world.stamp)
    }
}

#[inline(always)]
fn trace_top_level<I: Isa, F: Filter, C: HitCollector, T: Tally>(
    isa: I,
    world: &FrameBvh,
    ray: &Ray,
    rules: Rules<F>,
    collector: &mut C,
    tally: &mut T,
) {
    let top = &world.top;
    let mut visitor = TopLevelVisitor { world, ray, rules, collector };
    if top.instances().len() == 1 {
        // The boxes in the root of its mesh say as much as its own.
        let _ = visitor.leaf(isa, WideLink::items(0..1), tally);
        return;
    }
    let (tree, bound) = (top.tree(), ErrorBound::instances(top.far()));
    let quads = RayQuads::new(isa, ray);
    let lanes = match RayLanes::new(isa, &quads, tree.around(), bound) {
        Some(lanes) => lanes,
        None => match safe(ray, tree.around(), bound) {
            Some(safe) if safe.needs_double_precision() => {
                return on_rare_path(visitor.collector, tally, |collector, work| {
                    trace_top_level_in_double(world, ray, rules.to_dynamic(world), &safe, collector, work);
                });
            }
            Some(safe) => RayLanes::of(isa, &quads, &safe),
            None => return,
        },
    };
    walk_wide(isa, tree, lanes, &mut visitor, tally);
}

/// Runs one of the paths that are compiled once, on a copy of the collector in memory, so that the
/// collector itself can stay in registers elsewhere.
#[inline(always)]
fn on_rare_path<C: HitCollector, T: Tally, R>(
    collector: &mut C,
    tally: &mut T,
    path: impl FnOnce(&mut DynamicCollector, &mut Work) -> R,
) -> R {
    let mut dynamic = collector.to_dynamic();
    let mut ignored = Work::default();
    let result = path(&mut dynamic, tally.work().unwrap_or(&mut ignored));
    collector.update_from(dynamic);
    result
}

/// A ray that is ready for boxes, prepared without vector instructions; `None` when nothing can be
/// hit.
#[cold]
#[inline(never)]
fn safe(ray: &Ray, bounds: &Aabb, bound: ErrorBound) -> Option<SafeRay> {
    Some(SafeRay::new(&ray.validated()?, bounds, bound))
}

#[cold]
#[inline(never)]
fn trace_top_level_in_double(
    world: &FrameBvh,
    ray: &Ray,
    rules: Rules<QueryFilter<'_>>,
    safe: &SafeRay,
    collector: &mut DynamicCollector,
    work: &mut Work,
) {
    let mut visitor = TopLevelVisitor { world, ray, rules, collector };
    walk_wide(Scalar, world.top.tree(), DoublePrecisionRay(safe), &mut visitor, work);
}

struct TopLevelVisitor<'a, F, C> {
    world: &'a FrameBvh,
    ray: &'a Ray,
    rules: Rules<F>,
    collector: &'a mut C,
}

impl<I: Isa, F: Filter, C: HitCollector, T: Tally> WideVisitor<I, T> for TopLevelVisitor<'_, F, C> {
    #[inline(always)]
    fn wants_any(&self) -> bool {
        self.collector.wants_any()
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.collector.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, tally: &mut T) -> ControlFlow<()> {
        enter_instances(isa, self.world, link, self, (), tally)
    }
}

impl<'a, I: Isa, F: Filter, C: HitCollector, T: Tally> EntersInstances<'a, I, T> for TopLevelVisitor<'a, F, C> {
    type Set = ();

    #[inline(always)]
    fn mask(&self) -> u32 {
        self.rules.mask
    }

    #[inline(always)]
    fn seeing(&self, instance: u32, (): ()) -> Option<()> {
        self.rules.filter.sees(instance).then_some(())
    }

    #[inline(always)]
    fn enter(&mut self, isa: I, instance: Instance<'a>, (): (), tally: &mut T) -> ControlFlow<()> {
        match instance.mesh.precision {
            Precision::Watertight => self.enter_mesh::<I, T, true>(isa, instance, tally),
            Precision::Fast => self.enter_mesh::<I, T, false>(isa, instance, tally),
        }
    }

    #[inline(always)]
    fn enter_in_double(&mut self, instance: u32, (): (), tally: &mut T) -> ControlFlow<()> {
        let (world, ray, rules) = (self.world, self.ray, self.rules.to_dynamic(self.world));
        on_rare_path(self.collector, tally, |collector, work| {
            in_double::enter(world, ray, instance, rules, collector, work)
        })
    }
}

impl<F: Filter, C: HitCollector> TopLevelVisitor<'_, F, C> {
    /// Walks the tree of a mesh with the ray in the space of the instance.
    #[inline(always)]
    fn enter_mesh<I: Isa, T: Tally, const WATERTIGHT: bool>(
        &mut self,
        isa: I,
        instance: Instance<'_>,
        tally: &mut T,
    ) -> ControlFlow<()> {
        let (record, mesh) = (instance.record, instance.mesh);
        let quads = if record.identity {
            RayQuads::new(isa, self.ray)
        } else {
            RayQuads::moved(isa, self.ray, &record.object_from_world)
        };
        let local = quads.ray(isa);
        let tree = mesh.bvh.tree();
        let (lanes, triangles) = match RayLanes::new(isa, &quads, tree.around(), ErrorBound::BOX_TEST) {
            Some(lanes) => (lanes, WatertightLanes::<I, WATERTIGHT>::in_range(isa, &quads, &local)),
            None => match safe(&local, tree.around(), ErrorBound::TRIANGLES) {
                Some(safe) if safe.needs_double_precision() => {
                    let rules = self.rules.to_dynamic(self.world);
                    return on_rare_path(self.collector, tally, |collector, work| {
                        enter_mesh_in_double::<WATERTIGHT>(&local, &safe, instance, rules, collector, work)
                    });
                }
                Some(safe) => (RayLanes::of(isa, &quads, &safe), WatertightLanes::new(isa, &local)),
                None => return ControlFlow::Continue(()),
            },
        };
        let counted = Counted { instance, rules: self.rules };
        let mut visitor = BottomLevelVisitor {
            counted: &counted,
            triangles,
            collector: &mut *self.collector,
            done: ControlFlow::Continue(()),
        };
        walk_wide(isa, tree, lanes, &mut visitor, tally);
        visitor.done
    }
}

#[cold]
#[inline(never)]
fn enter_mesh_in_double<const WATERTIGHT: bool>(
    local: &Ray,
    safe: &SafeRay,
    instance: Instance<'_>,
    rules: Rules<QueryFilter<'_>>,
    collector: &mut DynamicCollector,
    work: &mut Work,
) -> ControlFlow<()> {
    let triangles = WatertightLanes::<Scalar, WATERTIGHT>::new(Scalar, local);
    let counted = &Counted { instance, rules };
    let mut visitor = BottomLevelVisitor { counted, triangles, collector, done: ControlFlow::Continue(()) };
    walk_wide(Scalar, instance.mesh.bvh.tree(), DoublePrecisionRay(safe), &mut visitor, work);
    visitor.done
}

/// Which hits on an instance count. Visitors refer to it, so that it takes no registers from the
/// walk.
struct Counted<'a, F> {
    instance: Instance<'a>,
    rules: Rules<F>,
}

/// A ray in the space of one instance, ready for triangles.
struct BottomLevelVisitor<'a, I: Isa, F, C, const WATERTIGHT: bool> {
    counted: &'a Counted<'a, F>,
    triangles: WatertightLanes<'a, I, WATERTIGHT>,
    collector: &'a mut C,
    done: ControlFlow<()>,
}

impl<I: Isa, F: Filter, C: HitCollector, T: Tally, const WATERTIGHT: bool> WideVisitor<I, T>
    for BottomLevelVisitor<'_, I, F, C, WATERTIGHT>
{
    #[inline(always)]
    fn wants_any(&self) -> bool {
        self.collector.wants_any()
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.collector.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, tally: &mut T) -> ControlFlow<()> {
        let Counted { instance, rules } = self.counted;
        for item in link.item_index()..link.item_index() + link.item_count() {
            let block = instance.mesh.bvh.block(item);
            tally.block(block.count);
            let hits = self.triangles.hits(isa, block, self.collector.t_max());
            let mut mask = hits.mask;
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize & 3;
                mask &= mask - 1;
                let (hit, primitive) = (hits.lane(lane), block.primitives[lane]);
                // Another lane may have come nearer meanwhile.
                if hit.t <= self.collector.t_max() && rules.count(&hit, primitive, instance) {
                    self.done = self.collector.collect(Hit::new(&hit, primitive, instance.index));
                    self.done?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}
