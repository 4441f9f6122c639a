//! What a filter decides about.

use super::two_level::Instance;
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

    /// Number of the instance among those of the snapshot; see
    /// [`Snapshot::instance_at`](crate::Snapshot::instance_at).
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

/// Decides whether a hit counts. There are exactly two: walks are compiled for each, and the first
/// costs nothing.
pub(crate) trait Filter: Copy {
    /// Whether the ray sees an instance; else it is not even entered.
    fn sees(&self, instance: u32) -> bool;

    /// Whether a hit on an instance counts.
    fn accepts(&self, hit: &TriangleHit, primitive: u32, instance: &Instance<'_>) -> bool;

    /// The same decisions in the form that the rare paths are compiled for.
    fn to_dynamic<'a>(self, world: &'a FrameBvh) -> QueryFilter<'a>
    where
        Self: 'a;
}

/// Every hit counts.
#[derive(Clone, Copy)]
pub(crate) struct NoFilter;

impl Filter for NoFilter {
    #[inline(always)]
    fn sees(&self, _: u32) -> bool {
        true
    }

    #[inline(always)]
    fn accepts(&self, _: &TriangleHit, _: u32, _: &Instance<'_>) -> bool {
        true
    }

    fn to_dynamic<'a>(self, world: &'a FrameBvh) -> QueryFilter<'a>
    where
        Self: 'a,
    {
        QueryFilter::new(world, None, Without::default())
    }
}

/// A filter as callers hand it over. It may be called on any thread that shares the query.
pub(super) type DynFilter<'a> = dyn Fn(&Candidate<'_>) -> bool + Sync + 'a;

/// What a query says about instances and hits: which instances are seen at all and, except on
/// opaque ones, which hits count.
#[derive(Clone, Copy)]
pub(crate) struct QueryFilter<'a> {
    filter: Option<&'a DynFilter<'a>>,
    without: Without<'a>,
    world: &'a FrameBvh,
    /// Index of the ray in its batch.
    ray: u32,
}

impl<'a> QueryFilter<'a> {
    /// For the first ray of a batch.
    pub(super) fn new(world: &'a FrameBvh, filter: Option<&'a DynFilter<'a>>, without: Without<'a>) -> Self {
        Self { filter, without, world, ray: 0 }
    }

    /// For another ray of the batch.
    #[inline(always)]
    pub(super) fn for_ray(self, ray: u32) -> Self {
        Self { ray, ..self }
    }

    /// The rays of a packet that see an instance; `first_ray` is the index of its first ray in the
    /// batch.
    #[inline(always)]
    pub(super) fn seeing(&self, instance: u32, first_ray: usize, set: u64) -> u64 {
        if self.without.is_nothing() { set } else { self.without.seeing(self.world, instance, first_ray, set) }
    }

    /// Whether it may refuse hits on an instance.
    #[inline(always)]
    pub(super) fn may_refuse(&self, record: &InstanceRecord) -> bool {
        self.filter.is_some() && !record.opaque
    }
}

impl Filter for QueryFilter<'_> {
    #[inline(always)]
    fn sees(&self, instance: u32) -> bool {
        self.without.is_nothing() || self.without.is_seen(self.world, instance, self.ray)
    }

    #[inline(always)]
    fn accepts(&self, hit: &TriangleHit, primitive: u32, instance: &Instance<'_>) -> bool {
        let Instance { record, index, .. } = *instance;
        let asked = |filter: &DynFilter<'_>| {
            filter(&Candidate { hit: *hit, primitive, instance: index, ray: self.ray, record })
        };
        record.opaque || self.filter.is_none_or(asked)
    }

    #[inline(always)]
    fn to_dynamic<'a>(self, _: &'a FrameBvh) -> QueryFilter<'a>
    where
        Self: 'a,
    {
        self
    }
}
