//! What a filter is asked about.

use crate::geometry::TriangleHit;
use crate::wide::InstanceRecord;

/// A hit that counts if the filter says so.
#[doc(alias = "any-hit")]
#[derive(Debug, Clone, Copy)]
pub struct Candidate<'a> {
    hit: TriangleHit,
    primitive: u32,
    instance: u32,
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

    /// The caller's own number of the instance.
    pub fn user_id(&self) -> u32 {
        self.record.user_id
    }
}

/// Decides whether a hit counts. There are exactly two: walks are compiled for each, and the first leaves no trace.
pub(crate) trait Filter: Copy {
    fn accepts(&self, hit: &TriangleHit, primitive: u32, instance: u32, record: &InstanceRecord) -> bool;
}

/// Every hit counts.
#[derive(Clone, Copy)]
pub(crate) struct NoFilter;

impl Filter for NoFilter {
    #[inline(always)]
    fn accepts(&self, _: &TriangleHit, _: u32, _: u32, _: &InstanceRecord) -> bool {
        true
    }
}

/// The caller decides, except about opaque instances.
#[derive(Clone, Copy)]
pub(crate) struct AskFilter<'a>(pub(crate) &'a dyn Fn(&Candidate<'_>) -> bool);

impl Filter for AskFilter<'_> {
    fn accepts(&self, hit: &TriangleHit, primitive: u32, instance: u32, record: &InstanceRecord) -> bool {
        record.opaque || (self.0)(&Candidate { hit: *hit, primitive, instance, record })
    }
}
