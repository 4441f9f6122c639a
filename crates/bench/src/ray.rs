//! Rays and answers in the form that all engines read and write.

use glam::Vec3;

/// A ray of 28 bytes that starts at `t = 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub(crate) struct Ray {
    /// Metres, world space.
    pub(crate) origin: [f32; 3],
    /// The end of the ray, in lengths of the direction.
    pub(crate) t_max: f32,
    /// Of length one, up to rounding.
    pub(crate) direction: [f32; 3],
}

const _: () = assert!(size_of::<Ray>() == 28);

impl Ray {
    /// A ray of infinite length.
    pub(crate) fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin: origin.to_array(), t_max: f32::INFINITY, direction: direction.to_array() }
    }

    /// The point at distance `t`, in lengths of the direction.
    pub(crate) fn at(&self, t: f32) -> Vec3 {
        Vec3::from(self.origin) + Vec3::from(self.direction) * t
    }
}

/// The nearest hit, or a miss.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Answer {
    /// The distance in lengths of the ray's direction; infinite for a miss.
    pub(crate) t: f32,
    /// Weight of the triangle's second vertex.
    pub(crate) u: f32,
    /// Weight of the triangle's third vertex.
    pub(crate) v: f32,
    /// The triangle, numbered as in the soup; [`Answer::NOTHING`] for a miss.
    pub(crate) primitive: u32,
    /// The mesh as the engine numbers it; a soup is one mesh, number 0.
    pub(crate) mesh: u32,
}

impl Answer {
    /// The triangle and mesh of a miss.
    pub(crate) const NOTHING: u32 = u32::MAX;
    /// No hit.
    pub(crate) const MISS: Self =
        Self { t: f32::INFINITY, u: 0.0, v: 0.0, primitive: Self::NOTHING, mesh: Self::NOTHING };

    /// Whether this is a hit.
    pub(crate) fn is_hit(&self) -> bool {
        self.primitive != Self::NOTHING
    }
}
