//! Where a ray hits a triangle.

use crate::traverse::FrameStamp;

/// A hit, as plain data. The snapshot that gave it tells the rest: which instance, which mesh,
/// where in the world.
///
/// It carries the stamp of its frame: only snapshots of that frame resolve it, others recognise it
/// as foreign (see [`Snapshot::try_instance`](crate::Snapshot::try_instance)). Comparing hits, with
/// `==` or [`Hit::agrees_with`], leaves the stamp out.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Hit {
    /// In lengths of the ray's direction.
    pub t: f32,
    /// Weight of the triangle's second vertex.
    pub u: f32,
    /// Weight of the triangle's third vertex.
    pub v: f32,
    /// The triangle, numbered as the caller did.
    pub primitive: u32,
    /// Instance records on the way, outermost first.
    path: [u32; 2],
    flags: u32,
    /// Of the frame.
    stamp: FrameStamp,
}

// A stamp is never zero, which leaves room for `None`.
const _: () = assert!(size_of::<Hit>() == 32 && size_of::<Option<Hit>>() == 32);

/// There is no further instance on the path.
const NO_INSTANCE: u32 = u32::MAX;
const BACK_FACE: u32 = 1;

impl PartialEq for Hit {
    /// All but the stamp.
    fn eq(&self, other: &Self) -> bool {
        let numbers = |hit: &Self| (hit.primitive, hit.path, hit.flags);
        (self.t, self.u, self.v) == (other.t, other.u, other.v) && numbers(self) == numbers(other)
    }
}

impl Hit {
    /// Without the stamp, which is written once, when the query is answered.
    #[inline(always)]
    pub(crate) fn new(hit: &crate::geometry::TriangleHit, primitive: u32, instance: u32) -> Self {
        let flags = if hit.back { BACK_FACE } else { 0 };
        let (path, stamp) = ([instance, NO_INSTANCE], FrameStamp::UNKNOWN);
        Self { t: hit.t, u: hit.u, v: hit.v, primitive, path, flags, stamp }
    }

    #[inline(always)]
    pub(crate) fn stamped(self, stamp: FrameStamp) -> Self {
        Self { stamp, ..self }
    }

    /// The stamp of the frame that it is a hit of.
    #[inline(always)]
    pub(crate) fn stamp(&self) -> FrameStamp {
        self.stamp
    }

    /// The ray came from the side from which the vertices run clockwise. A mirrored instance keeps
    /// its sides: outside stays outside.
    pub fn is_back_face(&self) -> bool {
        self.flags & BACK_FACE != 0
    }

    /// Number of the instance among those of the snapshot.
    pub fn instance_index(&self) -> u32 {
        self.path[0]
    }

    /// The order of hits: by distance, then by instance, then by primitive. Of two at the same
    /// distance, the smaller wins everywhere.
    #[inline(always)]
    pub(crate) fn key(&self) -> (f32, u32, u32) {
        (self.t, self.path[0], self.primitive)
    }

    /// Whether two ways of asking found the same: the same distance to the bit, and the same
    /// instance and primitive.
    pub fn agrees_with(&self, other: &Self) -> bool {
        self.key() == other.key() && self.is_back_face() == other.is_back_face()
    }
}
