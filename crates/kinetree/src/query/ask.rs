//! One way through both levels, whatever is asked: instances first, then the triangles of each.

use std::ops::ControlFlow;

use super::{Cull, Filter, Hit};
use crate::geometry::{Ray, SafeRay, Sheared, TriangleHit};
use crate::simd::{Isa, Kernel, Scalar};
use crate::traverse::{Carefully, Posed, RayLanes, ShearedLanes, Tally, TwoLevel, WideVisitor, walk_wide};
use crate::wide::{InstanceRecord, WideLink};

/// What a question does with hits.
pub(crate) trait Gather {
    /// Whether it helps to look at nearer triangles first.
    const ORDERED: bool;

    /// Hits beyond this do not matter (any more).
    fn t_max(&self) -> f32;

    /// A hit that counts. `Break` when no other is needed.
    fn take(&mut self, hit: Hit) -> ControlFlow<()>;
}

/// Which hits count.
#[derive(Clone, Copy)]
pub(crate) struct Rules<F> {
    pub(crate) mask: u32,
    pub(crate) cull: Cull,
    pub(crate) filter: F,
}

/// Brings the hits of a sane ray to `gather`, each at least once, in no particular order.
#[inline]
pub(crate) fn ask<F: Filter, G: Gather, T: Tally>(
    world: &TwoLevel,
    ray: &Ray,
    rules: Rules<F>,
    gather: &mut G,
    tally: &mut T,
) {
    world.level.run(Ask { world, ray, rules, gather, tally });
}

struct Ask<'a, F, G, T> {
    world: &'a TwoLevel,
    ray: &'a Ray,
    rules: Rules<F>,
    gather: &'a mut G,
    tally: &'a mut T,
}

impl<F: Filter, G: Gather, T: Tally> Kernel for Ask<'_, F, G, T> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        let mut visitor = InWorld { world: self.world, ray: self.ray, rules: self.rules, gather: self.gather };
        if self.world.top.instances().len() == 1 {
            // The boxes in the root of its mesh say as much as its own.
            let _ = visitor.leaf(isa, WideLink::units(0..1), self.tally);
            return;
        }
        let safe = SafeRay::over_instances(self.ray, &self.world.top.bounds());
        if safe.needs_care() {
            return carefully(visitor, &safe, self.tally);
        }
        walk_wide(isa, self.world.top.tree(), RayLanes::new(isa, &safe), &mut visitor, self.tally);
    }
}

#[cold]
#[inline(never)]
fn carefully<F: Filter, G: Gather, T: Tally>(mut visitor: InWorld<'_, F, G>, safe: &SafeRay, tally: &mut T) {
    walk_wide(Scalar, visitor.world.top.tree(), Carefully(safe), &mut visitor, tally);
}

struct InWorld<'a, F, G> {
    world: &'a TwoLevel,
    ray: &'a Ray,
    rules: Rules<F>,
    gather: &'a mut G,
}

impl<I: Isa, F: Filter, G: Gather, T: Tally> WideVisitor<I, T> for InWorld<'_, F, G> {
    const ORDERED: bool = G::ORDERED;

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.gather.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, tally: &mut T) -> ControlFlow<()> {
        let units = link.index()..link.index() + link.unit_count();
        for &instance in &self.world.top.instances()[units] {
            let Some(ray) = RayInMesh::enter(self.world, self.ray, instance, self.rules) else { continue };
            tally.instance();
            let safe = SafeRay::new(&ray.local, &ray.mesh.bvh.bounds());
            if safe.needs_care() {
                ray.carefully(&safe, self.gather, tally)?;
                continue;
            }
            let lanes = ShearedLanes::new(isa, &ray.sheared, ray.local.t_min);
            let mut visitor = InMesh { ray: &ray, lanes, gather: &mut *self.gather, done: ControlFlow::Continue(()) };
            walk_wide(isa, ray.mesh.bvh.tree(), RayLanes::new(isa, &safe), &mut visitor, tally);
            visitor.done?;
        }
        ControlFlow::Continue(())
    }
}

struct InMesh<'a, I: Isa, F, G> {
    ray: &'a RayInMesh<'a, F>,
    lanes: ShearedLanes<'a, I>,
    gather: &'a mut G,
    done: ControlFlow<()>,
}

impl<I: Isa, F: Filter, G: Gather, T: Tally> WideVisitor<I, T> for InMesh<'_, I, F, G> {
    const ORDERED: bool = G::ORDERED;

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.gather.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, tally: &mut T) -> ControlFlow<()> {
        for unit in link.index()..link.index() + link.unit_count() {
            let block = self.ray.mesh.bvh.block(unit);
            tally.block(block.count);
            let hits = self.lanes.hits(isa, block, self.ray.local.t_min, self.gather.t_max());
            let mut mask = hits.mask;
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize & 3;
                mask &= mask - 1;
                let (hit, primitive) = (hits.lane(lane), block.primitives[lane]);
                // Another lane may have come nearer meanwhile.
                if hit.t.is_finite() && hit.t <= self.gather.t_max() && self.ray.counts(&hit, primitive) {
                    self.done = self.gather.take(Hit::new(&hit, primitive, self.ray.instance));
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
    sheared: Sheared,
    mesh: &'a Posed,
    instance: u32,
    record: &'a InstanceRecord,
    rules: Rules<F>,
}

impl<'a, F: Filter> RayInMesh<'a, F> {
    /// `None` when the ray cannot hit anything there.
    #[inline(always)]
    pub(crate) fn enter(world: &'a TwoLevel, ray: &Ray, instance: u32, rules: Rules<F>) -> Option<Self> {
        let record = &world.instances[instance as usize];
        if record.mask & rules.mask == 0 {
            return None;
        }
        let local = record.enter(ray)?;
        let mesh = &*world.meshes[record.mesh as usize];
        Some(Self { local, sheared: Sheared::new(&local), mesh, instance, record, rules })
    }

    pub(crate) fn mesh(&self) -> &'a Posed {
        self.mesh
    }

    /// The hit of one triangle, if it counts.
    #[inline]
    pub(crate) fn hit(&self, primitive: u32, t_max: f32) -> Option<Hit> {
        let hit = self.sheared.hit(&self.mesh.triangles.get(primitive), self.local.t_min, t_max)?;
        self.counts(&hit, primitive).then(|| Hit::new(&hit, primitive, self.instance))
    }

    #[inline(always)]
    fn counts(&self, hit: &TriangleHit, primitive: u32) -> bool {
        self.rules.cull.keeps(hit) && self.rules.filter.accepts(hit, primitive, self.instance, self.record)
    }

    #[cold]
    #[inline(never)]
    fn carefully<G: Gather, T: Tally>(&self, safe: &SafeRay, gather: &mut G, tally: &mut T) -> ControlFlow<()> {
        let lanes = ShearedLanes::new(Scalar, &self.sheared, self.local.t_min);
        let mut visitor = InMesh { ray: self, lanes, gather, done: ControlFlow::Continue(()) };
        walk_wide(Scalar, self.mesh.bvh.tree(), Carefully(safe), &mut visitor, tally);
        visitor.done
    }
}

impl Cull {
    #[inline(always)]
    fn keeps(self, hit: &TriangleHit) -> bool {
        match self {
            Self::None => true,
            Self::Back => !hit.back,
            Self::Front => hit.back,
        }
    }
}
