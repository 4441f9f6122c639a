//! The way through both levels, for one ray and for a packet alike: the instances in a leaf of the
//! top level, each of which leads to the tree of its mesh.

use std::ops::ControlFlow;

use super::Cull;
use super::candidate::{Filter, QueryFilter};
use crate::geometry::TriangleHit;
use crate::simd::Isa;
use crate::traverse::{FrameBvh, MeshFrame, Tally};
use crate::wide::{InstanceRecord, WideLink};

/// Which hits count.
#[derive(Clone, Copy)]
pub(crate) struct Rules<F> {
    pub(crate) mask: u32,
    pub(crate) cull: Cull,
    pub(crate) filter: F,
}

/// An instance of a frame, and what it leads to.
#[derive(Clone, Copy)]
pub(crate) struct Instance<'a> {
    pub(crate) index: u32,
    pub(crate) record: &'a InstanceRecord,
    pub(crate) mesh: &'a MeshFrame,
}

impl<'a> Instance<'a> {
    #[inline(always)]
    pub(crate) fn of(world: &'a FrameBvh, index: u32) -> Self {
        let record = &world.instances[index as usize];
        Self { index, record, mesh: &world.meshes[record.mesh as usize] }
    }
}

/// One ray, or a packet of rays, that enters instances.
pub(super) trait EntersInstances<'a, I: Isa, T: Tally> {
    /// Which rays take part: `()` for one ray, a set of bits for a packet.
    type Set: Copy;

    /// The mask of the query.
    fn mask(&self) -> u32;

    /// Those rays of the set that see an instance; `None` if none does.
    fn seeing(&self, instance: u32, set: Self::Set) -> Option<Self::Set>;

    /// Walks the tree of an instance. `Break` when no other is needed.
    fn enter(&mut self, isa: I, instance: Instance<'a>, set: Self::Set, tally: &mut T) -> ControlFlow<()>;

    /// As `enter`, for an instance that rays enter in double precision.
    fn enter_in_double(&mut self, instance: u32, set: Self::Set, tally: &mut T) -> ControlFlow<()>;
}

/// Enters the instances of a leaf of the top level.
#[inline(always)]
pub(super) fn enter_instances<'a, I: Isa, T: Tally, R: EntersInstances<'a, I, T>>(
    isa: I,
    world: &'a FrameBvh,
    leaf: WideLink,
    rays: &mut R,
    set: R::Set,
    tally: &mut T,
) -> ControlFlow<()> {
    let items = leaf.item_index()..leaf.item_index() + leaf.item_count();
    for &index in &world.top.instances()[items] {
        let record = &world.instances[index as usize];
        if record.mask & rays.mask() == 0 {
            continue;
        }
        let Some(set) = rays.seeing(index, set) else { continue };
        tally.instance();
        if record.in_double {
            rays.enter_in_double(index, set, tally)?;
        } else {
            let mesh = &*world.meshes[record.mesh as usize];
            rays.enter(isa, Instance { index, record, mesh }, set, tally)?;
        }
    }
    ControlFlow::Continue(())
}

impl<F: Filter> Rules<F> {
    #[inline(always)]
    pub(super) fn count(&self, hit: &TriangleHit, primitive: u32, instance: &Instance<'_>) -> bool {
        self.cull.keeps(hit) && self.filter.accepts(hit, primitive, instance)
    }

    /// The same rules in the form that the rare paths are compiled for.
    #[inline(always)]
    pub(super) fn to_dynamic<'a>(self, world: &'a FrameBvh) -> Rules<QueryFilter<'a>>
    where
        F: 'a,
    {
        Rules { mask: self.mask, cull: self.cull, filter: self.filter.to_dynamic(world) }
    }
}

impl<'a> Rules<QueryFilter<'a>> {
    /// The same rules for another ray of the batch.
    #[inline(always)]
    pub(super) fn for_ray(self, ray: usize) -> Self {
        Self { filter: self.filter.for_ray(ray as u32), ..self }
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
