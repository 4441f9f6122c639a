//! One way through both levels, whatever is asked: instances first, then the triangles of each.

use std::marker::PhantomData;
use std::mem::replace;
use std::ops::ControlFlow;

use super::{Cull, Filter, Hit, in_double};
use crate::geometry::slab::ErrorBound;
use crate::geometry::{Aabb, Precision, Ray, SafeRay, TriangleHit};
use crate::simd::{Isa, Kernel, Scalar};
use crate::traverse::{
    DoublePrecisionRay, FrameBvh, FrameStamp, MeshFrame, RayLanes, RayQuads, Tally, WatertightLanes, WideVisitor,
    walk_wide,
};
use crate::wide::{InstanceRecord, WideLink};

/// What a question does with hits.
pub(crate) trait HitCollector {
    /// Whether any hit will do.
    const ANY: bool;

    /// What has been asked for; that of nothing when nothing can be hit.
    type Answer: Default;

    /// Nothing yet, of a ray that ends there.
    fn within(t_max: f32) -> Self;

    /// What has been gathered, in the frame of this stamp.
    fn answer(self, stamp: FrameStamp) -> Self::Answer;

    /// Hits beyond this do not matter (any more).
    fn t_max(&self) -> f32;

    /// A hit that counts. `Break` when no other is needed.
    fn collect(&mut self, hit: Hit) -> ControlFlow<()>;
}

/// Which hits count.
#[derive(Clone, Copy)]
pub(crate) struct Rules<F> {
    pub(crate) mask: u32,
    pub(crate) cull: Cull,
    pub(crate) filter: F,
}

/// What is gathered of the hits of a ray, each of which is brought at least once, in no particular order.
#[inline(always)]
pub(super) fn trace_ray<F: Filter, G: HitCollector, T: Tally>(
    world: &FrameBvh,
    ray: &Ray,
    rules: Rules<F>,
    tally: &mut T,
) -> G::Answer {
    world.level.run(TraceRay::<F, G, T> { world, ray, rules, tally, collector: PhantomData })
}

struct TraceRay<'a, F, G, T> {
    world: &'a FrameBvh,
    ray: &'a Ray,
    rules: Rules<F>,
    tally: &'a mut T,
    collector: PhantomData<G>,
}

impl<F: Filter, G: HitCollector, T: Tally> Kernel for TraceRay<'_, F, G, T> {
    type Output = G::Answer;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> G::Answer {
        // The ray is read where it stands; only one whose bounds have to be mended first is copied.
        let mended;
        let ray = if self.ray.has_valid_range() {
            self.ray
        } else {
            let Some(valid) = self.ray.validated() else { return G::Answer::default() };
            mended = valid;
            &mended
        };
        let mut collector = G::within(ray.t_max);
        let visitor = TopLevelVisitor { world: self.world, ray, rules: self.rules, collector: &mut collector };
        through_world(isa, visitor, self.tally);
        collector.answer(self.world.stamp)
    }
}

/// Goes through the top level.
#[inline(always)]
fn through_world<I: Isa, F: Filter, G: HitCollector, T: Tally>(
    isa: I,
    mut visitor: TopLevelVisitor<'_, F, G>,
    tally: &mut T,
) {
    let (top, ray) = (&visitor.world.top, visitor.ray);
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
                return with_spilled_state(visitor.collector, |collector| {
                    in_double_precision(TopLevelVisitor { collector, ..visitor }, &safe, tally)
                });
            }
            Some(safe) => RayLanes::of(isa, &quads, &safe),
            None => return,
        },
    };
    walk_wide(isa, tree, lanes, &mut visitor, tally);
}

/// Does something rare to what is gathered, while it stands elsewhere: otherwise it could not stay in registers.
#[inline(always)]
fn with_spilled_state<G: HitCollector, R>(collector: &mut G, work: impl FnOnce(&mut G) -> R) -> R {
    let mut elsewhere = replace(collector, G::within(0.0));
    let out = work(&mut elsewhere);
    *collector = elsewhere;
    out
}

/// The long way to a ray that is ready for boxes; `None` when nothing can be hit.
#[cold]
#[inline(never)]
fn safe(ray: &Ray, bounds: &Aabb, bound: ErrorBound) -> Option<SafeRay> {
    Some(SafeRay::new(&ray.validated()?, bounds, bound))
}

#[cold]
#[inline(never)]
fn in_double_precision<F: Filter, G: HitCollector, T: Tally>(
    mut visitor: TopLevelVisitor<'_, F, G>,
    safe: &SafeRay,
    tally: &mut T,
) {
    walk_wide(Scalar, visitor.world.top.tree(), DoublePrecisionRay(safe), &mut visitor, tally);
}

struct TopLevelVisitor<'a, F, G> {
    world: &'a FrameBvh,
    ray: &'a Ray,
    rules: Rules<F>,
    collector: &'a mut G,
}

impl<I: Isa, F: Filter, G: HitCollector, T: Tally> WideVisitor<I, T> for TopLevelVisitor<'_, F, G> {
    const ANY: bool = G::ANY;

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.collector.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, tally: &mut T) -> ControlFlow<()> {
        let items = link.item_index()..link.item_index() + link.item_count();
        for &instance in &self.world.top.instances()[items] {
            let record = &self.world.instances[instance as usize];
            if record.mask & self.rules.mask == 0 || !self.rules.filter.sees(instance) {
                continue;
            }
            tally.instance();
            if record.in_double {
                let (world, ray, rules) = (self.world, self.ray, self.rules);
                with_spilled_state(self.collector, |collector| {
                    in_double::enter(world, ray, instance, rules, collector, tally)
                })?;
                continue;
            }
            match self.world.meshes[record.mesh as usize].precision {
                Precision::Watertight => self.enter::<I, T, true>(isa, instance, record, tally)?,
                Precision::Fast => self.enter::<I, T, false>(isa, instance, record, tally)?,
            }
        }
        ControlFlow::Continue(())
    }
}

impl<F: Filter, G: HitCollector> TopLevelVisitor<'_, F, G> {
    /// Goes through the tree of the mesh that stands there.
    #[inline(always)]
    fn enter<I: Isa, T: Tally, const WATERTIGHT: bool>(
        &mut self,
        isa: I,
        instance: u32,
        record: &InstanceRecord,
        tally: &mut T,
    ) -> ControlFlow<()> {
        let quads = if record.identity {
            RayQuads::new(isa, self.ray)
        } else {
            RayQuads::moved(isa, self.ray, &record.object_from_world)
        };
        let mesh = &*self.world.meshes[record.mesh as usize];
        let ray = RayInMesh { local: quads.ray(isa), mesh, instance, record, rules: self.rules };
        let tree = mesh.bvh.tree();
        let (lanes, watertight) = match RayLanes::new(isa, &quads, tree.around(), ErrorBound::BOX_TEST) {
            Some(lanes) => (lanes, WatertightLanes::<I, WATERTIGHT>::in_range(isa, &quads, &ray.local)),
            None => match safe(&ray.local, tree.around(), ErrorBound::TRIANGLES) {
                Some(safe) if safe.needs_double_precision() => {
                    return with_spilled_state(self.collector, |collector| {
                        ray.in_double_precision::<G, T, WATERTIGHT>(&safe, collector, tally)
                    });
                }
                Some(safe) => (RayLanes::of(isa, &quads, &safe), WatertightLanes::new(isa, &ray.local)),
                None => return ControlFlow::Continue(()),
            },
        };
        let mut visitor = BottomLevelVisitor {
            ray: &ray,
            lanes: watertight,
            collector: &mut *self.collector,
            done: ControlFlow::Continue(()),
        };
        walk_wide(isa, tree, lanes, &mut visitor, tally);
        visitor.done
    }
}

struct BottomLevelVisitor<'a, I: Isa, F, G, const WATERTIGHT: bool> {
    ray: &'a RayInMesh<'a, F>,
    lanes: WatertightLanes<'a, I, WATERTIGHT>,
    collector: &'a mut G,
    done: ControlFlow<()>,
}

impl<I: Isa, F: Filter, G: HitCollector, T: Tally, const WATERTIGHT: bool> WideVisitor<I, T>
    for BottomLevelVisitor<'_, I, F, G, WATERTIGHT>
{
    const ANY: bool = G::ANY;

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.collector.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, tally: &mut T) -> ControlFlow<()> {
        for item in link.item_index()..link.item_index() + link.item_count() {
            let block = self.ray.mesh.bvh.block(item);
            tally.block(block.count);
            let hits = self.lanes.hits(isa, block, self.collector.t_max());
            let mut mask = hits.mask;
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize & 3;
                mask &= mask - 1;
                let (hit, primitive) = (hits.lane(lane), block.primitives[lane]);
                // Another lane may have come nearer meanwhile.
                if hit.t.is_finite() && hit.t <= self.collector.t_max() && self.ray.counts(&hit, primitive) {
                    self.done = self.collector.collect(Hit::new(&hit, primitive, self.ray.instance));
                    self.done?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}

/// A ray in the space of one instance, ready for triangles.
pub(crate) struct RayInMesh<'a, F> {
    local: Ray,
    mesh: &'a MeshFrame,
    instance: u32,
    record: &'a InstanceRecord,
    rules: Rules<F>,
}

impl<F: Filter> RayInMesh<'_, F> {
    #[inline(always)]
    fn counts(&self, hit: &TriangleHit, primitive: u32) -> bool {
        self.rules.count(hit, primitive, self.instance, self.record)
    }

    #[cold]
    #[inline(never)]
    fn in_double_precision<G: HitCollector, T: Tally, const WATERTIGHT: bool>(
        &self,
        safe: &SafeRay,
        collector: &mut G,
        tally: &mut T,
    ) -> ControlFlow<()> {
        let lanes = WatertightLanes::<Scalar, WATERTIGHT>::new(Scalar, &self.local);
        let mut visitor = BottomLevelVisitor { ray: self, lanes, collector, done: ControlFlow::Continue(()) };
        walk_wide(Scalar, self.mesh.bvh.tree(), DoublePrecisionRay(safe), &mut visitor, tally);
        visitor.done
    }
}

impl<F: Filter> Rules<F> {
    #[inline(always)]
    pub(super) fn count(&self, hit: &TriangleHit, primitive: u32, instance: u32, record: &InstanceRecord) -> bool {
        self.cull.keeps(hit) && self.filter.accepts(hit, primitive, instance, record)
    }
}

impl Cull {
    #[inline(always)]
    pub(super) fn keeps(self, hit: &TriangleHit) -> bool {
        match self {
            Self::None => true,
            Self::Back => !hit.back,
            Self::Front => hit.back,
        }
    }
}
