//! One way through both levels, whatever is asked: instances first, then the triangles of each.

use std::ops::{ControlFlow, Range};

use super::{Cull, Filter, Hit};
use crate::geometry::{Aabb, Ray, SafeRay, Sheared, TriangleHit};
use crate::traverse::{Posed, Tally, TwoLevel, Visitor, walk};
use crate::wide::InstanceRecord;

/// What a question does with hits.
pub(crate) trait Gather {
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
pub(crate) fn ask<T: Tally>(
    world: &TwoLevel,
    ray: &Ray,
    rules: Rules<impl Filter>,
    gather: &mut impl Gather,
    tally: &mut T,
) {
    let safe = SafeRay::over_instances(ray, &world.top.bounds());
    walk(&world.top, &mut InWorld { world, ray, safe, rules, gather }, tally);
}

struct InWorld<'a, F, G> {
    world: &'a TwoLevel,
    ray: &'a Ray,
    safe: SafeRay,
    rules: Rules<F>,
    gather: &'a mut G,
}

impl<F: Filter, G: Gather, T: Tally> Visitor<T> for InWorld<'_, F, G> {
    fn enter(&mut self, bounds: &Aabb) -> Option<f32> {
        self.safe.enter(bounds, self.gather.t_max())
    }

    fn limit(&self) -> f32 {
        self.gather.t_max()
    }

    fn leaf(&mut self, places: Range<u32>, tally: &mut T) -> ControlFlow<()> {
        for &instance in &self.world.top.primitives()[places.start as usize..places.end as usize] {
            let Some(ray) = RayInMesh::enter(self.world, self.ray, instance, self.rules) else { continue };
            tally.instance();
            let safe = SafeRay::new(&ray.local, &ray.mesh.bvh.bounds());
            let mut visitor = InMesh { ray, safe, gather: self.gather, done: ControlFlow::Continue(()) };
            walk(&visitor.ray.mesh.bvh, &mut visitor, tally);
            visitor.done?;
        }
        ControlFlow::Continue(())
    }
}

struct InMesh<'a, F, G> {
    ray: RayInMesh<'a, F>,
    safe: SafeRay,
    gather: &'a mut G,
    done: ControlFlow<()>,
}

impl<F: Filter, G: Gather, T: Tally> Visitor<T> for InMesh<'_, F, G> {
    fn enter(&mut self, bounds: &Aabb) -> Option<f32> {
        self.safe.enter(bounds, self.gather.t_max())
    }

    fn limit(&self) -> f32 {
        self.gather.t_max()
    }

    fn leaf(&mut self, places: Range<u32>, tally: &mut T) -> ControlFlow<()> {
        for &primitive in &self.ray.mesh.bvh.primitives()[places.start as usize..places.end as usize] {
            tally.triangle();
            if let Some(hit) = self.ray.hit(primitive, self.gather.t_max()) {
                self.done = self.gather.take(hit);
                self.done?;
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
        let counts =
            self.rules.cull.keeps(&hit) && self.rules.filter.accepts(&hit, primitive, self.instance, self.record);
        counts.then(|| Hit::new(&hit, primitive, self.instance))
    }
}

impl Cull {
    #[inline]
    fn keeps(self, hit: &TriangleHit) -> bool {
        match self {
            Self::None => true,
            Self::Back => !hit.back,
            Self::Front => hit.back,
        }
    }
}
