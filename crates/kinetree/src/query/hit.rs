//! Where a ray met something.

/// A hit, as plain data. The snapshot that gave it tells the rest: which instance, which mesh, where in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
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
}

const _: () = assert!(size_of::<Hit>() <= 32);

/// The path ends before.
const NO_INSTANCE: u32 = u32::MAX;
const BACK_FACE: u32 = 1;

impl Hit {
    #[inline(always)]
    pub(crate) fn new(hit: &crate::geometry::TriangleHit, primitive: u32, instance: u32) -> Self {
        let flags = if hit.back { BACK_FACE } else { 0 };
        Self { t: hit.t, u: hit.u, v: hit.v, primitive, path: [instance, NO_INSTANCE], flags }
    }

    /// The ray came from the side from which the vertices run clockwise. A mirrored instance keeps its sides: outside stays outside.
    pub fn is_back_face(&self) -> bool {
        self.flags & BACK_FACE != 0
    }

    /// Number of the instance among those of the snapshot.
    pub fn instance_index(&self) -> u32 {
        self.path[0]
    }

    /// The order of hits: by distance, then by instance, then by primitive. Of two at the same distance, the smaller wins everywhere.
    #[inline(always)]
    pub(crate) fn key(&self) -> (f32, u32, u32) {
        (self.t, self.path[0], self.primitive)
    }

    /// Whether two ways of asking found the same: the same distance to the bit, and the same instance and primitive.
    pub fn agrees_with(&self, other: &Self) -> bool {
        self.key() == other.key() && self.is_back_face() == other.is_back_face()
    }
}
