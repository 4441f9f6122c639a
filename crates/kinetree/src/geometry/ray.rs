//! Rays.

use glam::{Vec3, Vec3A};

/// A half-open line with bounds. Its direction has any length but zero; `t` counts in lengths of the direction.
///
/// A negative `t_min` counts as 0. A ray with a non-finite origin or direction, a zero direction or a NaN bound hits nothing.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Ray {
    /// Where it starts, metres.
    pub origin: [f32; 3],
    /// Hits nearer than this do not count.
    pub t_min: f32,
    /// Where it goes; need not have length one.
    pub direction: [f32; 3],
    /// Hits beyond this do not count.
    pub t_max: f32,
}

const _: () = assert!(size_of::<Ray>() == 32);

impl Ray {
    /// A ray without an end.
    pub const fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        Self { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
    }

    /// The same ray with bounds, both inclusive, in lengths of the direction.
    #[must_use]
    pub const fn with_range(self, t_min: f32, t_max: f32) -> Self {
        Self { t_min, t_max, ..self }
    }

    /// The origin with `t_min`, and the direction with `t_max`.
    #[inline(always)]
    pub(crate) fn quads(&self) -> &[[f32; 4]; 2] {
        bytemuck::cast_ref(self)
    }

    /// The way back from [`Ray::quads`].
    #[inline(always)]
    pub(crate) fn of_quads(quads: [[f32; 4]; 2]) -> Self {
        bytemuck::cast(quads)
    }

    /// The point that is `t` lengths of the direction along.
    #[must_use]
    pub fn at(&self, t: f32) -> [f32; 3] {
        (Vec3::from(self.origin) + Vec3::from(self.direction) * t).into()
    }

    /// Whether its bounds are as [`Ray::validated`] leaves them.
    #[inline(always)]
    pub(crate) fn has_valid_range(&self) -> bool {
        (self.t_min.to_bits() | self.t_max.to_bits()) >> 31 == 0 && self.t_min <= self.t_max
    }

    /// The ray as queries take it: `t_min` at least 0; `None` when nothing can be hit.
    #[inline(always)]
    pub(crate) fn validated(&self) -> Option<Self> {
        let (origin, direction) = (Vec3A::from(self.origin), Vec3A::from(self.direction));
        let finite = origin.is_finite() && direction.is_finite();
        // A negative zero becomes a positive one, whose bits order like its value.
        let t_min = if self.t_min <= 0.0 { 0.0 } else { self.t_min };
        let forward = direction.cmpne(Vec3A::ZERO).any();
        (finite && forward && t_min <= self.t_max).then_some(Self { t_min, t_max: self.t_max + 0.0, ..*self })
    }
}
