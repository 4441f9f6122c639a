//! What every engine is given, and what it gives back.

use glam::Vec3;

/// A ray as all engines read it: 28 bytes. It starts at `t = 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub(crate) struct Ray {
    /// Metres.
    pub(crate) origin: [f32; 3],
    /// Hits beyond this do not count; in lengths of the direction.
    pub(crate) t_max: f32,
    /// Of length one, but for rounding.
    pub(crate) direction: [f32; 3],
}

const _: () = assert!(size_of::<Ray>() == 28);

impl Ray {
    /// A ray without an end.
    pub(crate) fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin: origin.to_array(), t_max: f32::INFINITY, direction: direction.to_array() }
    }

    /// The point that is `t` lengths of the direction along.
    pub(crate) fn at(&self, t: f32) -> Vec3 {
        Vec3::from(self.origin) + Vec3::from(self.direction) * t
    }
}

/// The nearest hit, or none: what a renderer needs to go on with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Answer {
    /// In lengths of the ray's direction; infinite when nothing was hit.
    pub(crate) t: f32,
    /// Weight of the triangle's second vertex.
    pub(crate) u: f32,
    /// Weight of the triangle's third vertex.
    pub(crate) v: f32,
    /// The triangle, numbered as in the soup; [`Answer::NOTHING`] when nothing was hit.
    pub(crate) primitive: u32,
    /// The mesh that the engine was given; a soup is one mesh, number 0.
    pub(crate) mesh: u32,
}

impl Answer {
    /// No triangle.
    pub(crate) const NOTHING: u32 = u32::MAX;
    /// Nothing was hit.
    pub(crate) const MISS: Self =
        Self { t: f32::INFINITY, u: 0.0, v: 0.0, primitive: Self::NOTHING, mesh: Self::NOTHING };

    /// Whether something was hit.
    pub(crate) fn is_hit(&self) -> bool {
        self.primitive != Self::NOTHING
    }
}
