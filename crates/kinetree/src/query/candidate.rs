//! What a filter is asked about.

use super::without::Without;
use crate::geometry::TriangleHit;
use crate::traverse::FrameBvh;
use crate::wide::InstanceRecord;

/// A hit that counts if the filter says so.
#[doc(alias = "any-hit")]
#[derive(Debug, Clone, Copy)]
pub struct Candidate<'a> {
    hit: TriangleHit,
    primitive: u32,
    instance: u32,
    ray: u32,
    record: &'a InstanceRecord,
}

impl Candidate<'_> {
    /// In lengths of the ray's direction.
    pub fn t(&self) -> f32 {
        self.hit.t
    }

    /// Weight of the second vertex.
    pub fn u(&self) -> f32 {
        self.hit.u
    }

    /// Weight of the third vertex.
    pub fn v(&self) -> f32 {
        self.hit.v
    }

    /// The triangle, numbered as the caller did.
    pub fn primitive(&self) -> u32 {
        self.primitive
    }

    /// Whether the ray comes from the side from which the vertices run clockwise.
    pub fn is_back_face(&self) -> bool {
        self.hit.back
    }

    /// Number of the instance among those of the snapshot; see [`Snapshot::instance_at`](crate::Snapshot::instance_at).
    pub fn instance_index(&self) -> u32 {
        self.instance
    }

    /// Number of the ray in its batch; 0 for a ray that is asked about alone.
    pub fn ray_index(&self) -> u32 {
        self.ray
    }

    /// The caller's own number of the instance.
    pub fn user_id(&self) -> u32 {
        self.record.user_id
    }
}

/// Decides whether a hit counts. There are exactly two: walks are compiled for each, and the first leaves no trace.
pub(crate) trait Filter: Copy {
    /// Whether it may ever refuse.
    const ASKS: bool;

    /// Whether the ray sees an instance; else it is not even entered.
    fn sees(&self, instance: u32) -> bool;

    /// The rays of a packet that see an instance.
    fn seeing(&self, instance: u32, first_ray: usize, set: u64) -> u64;

    /// Whether it may refuse hits on an instance.
    fn asks_about(&self, record: &InstanceRecord) -> bool;

    /// The same, for a ray of a batch.
    fn for_ray(self, ray: u32) -> Self;

    fn accepts(&self, hit: &TriangleHit, primitive: u32, instance: u32, record: &InstanceRecord) -> bool;
}

/// Every hit counts.
#[derive(Clone, Copy)]
pub(crate) struct NoFilter;

impl Filter for NoFilter {
    const ASKS: bool = false;

    #[inline(always)]
    fn for_ray(self, _: u32) -> Self {
        self
    }

    #[inline(always)]
    fn sees(&self, _: u32) -> bool {
        true
    }

    #[inline(always)]
    fn seeing(&self, _: u32, _: usize, set: u64) -> u64 {
        set
    }

    #[inline(always)]
    fn asks_about(&self, _: &InstanceRecord) -> bool {
        false
    }

    #[inline(always)]
    fn accepts(&self, _: &TriangleHit, _: u32, _: u32, _: &InstanceRecord) -> bool {
        true
    }
}

/// A filter as callers hand it over. It may be called on any thread that shares the query.
pub(super) type DynFilter<'a> = dyn Fn(&Candidate<'_>) -> bool + Sync + 'a;

/// The caller decides: which instances are seen at all and, except about opaque ones, which hits
/// count.
#[derive(Clone, Copy)]
pub(crate) struct AskFilter<'a> {
    filter: Option<&'a DynFilter<'a>>,
    without: Without<'a>,
    world: &'a FrameBvh,
    ray: u32,
}

impl<'a> AskFilter<'a> {
    /// For a ray that is alone.
    pub(super) fn new(world: &'a FrameBvh, filter: Option<&'a DynFilter<'a>>, without: Without<'a>) -> Self {
        Self { filter, without, world, ray: 0 }
    }
}

impl Filter for AskFilter<'_> {
    const ASKS: bool = true;

    #[inline(always)]
    fn for_ray(self, ray: u32) -> Self {
        Self { ray, ..self }
    }

    fn sees(&self, instance: u32) -> bool {
        self.without.is_nothing() || self.without.is_seen(self.world, instance, self.ray)
    }

    fn seeing(&self, instance: u32, first_ray: usize, set: u64) -> u64 {
        if self.without.is_nothing() { set } else { self.without.seeing(self.world, instance, first_ray, set) }
    }

    #[inline]
    fn asks_about(&self, record: &InstanceRecord) -> bool {
        !record.opaque && self.filter.is_some()
    }

    fn accepts(&self, hit: &TriangleHit, primitive: u32, instance: u32, record: &InstanceRecord) -> bool {
        let asked =
            |filter: &DynFilter<'_>| filter(&Candidate { hit: *hit, primitive, instance, ray: self.ray, record });
        record.opaque || self.filter.is_none_or(asked)
    }
}
