//! Rays.

use glam::{Vec3, Vec3A};

/// A ray with bounds. Its direction has any length but zero; `t` counts lengths of the direction.
///
/// A negative `t_min` counts as 0. A ray with a non-finite origin or direction, a zero direction or
/// a NaN bound hits nothing.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Ray {
    /// Metres.
    pub origin: [f32; 3],
    /// Hits nearer than this do not count.
    pub t_min: f32,
    /// Of any length but zero.
    pub direction: [f32; 3],
    /// Hits beyond this do not count.
    pub t_max: f32,
}

const _: () = assert!(size_of::<Ray>() == 32);

impl Ray {
    /// A ray from `t` 0 to infinity.
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

    /// The inverse of [`Ray::quads`].
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

    /// The ray with `t_min` at least 0, as kernels require it; `None` if it can hit nothing.
    #[inline(always)]
    pub(crate) fn validated(&self) -> Option<Self> {
        let (origin, direction) = (Vec3A::from(self.origin), Vec3A::from(self.direction));
        let finite = origin.is_finite() && direction.is_finite();
        // A negative zero becomes a positive one: then the order of the bits is that of the values.
        let t_min = if self.t_min <= 0.0 { 0.0 } else { self.t_min };
        let forward = direction.cmpne(Vec3A::ZERO).any();
        (finite && forward && t_min <= self.t_max).then_some(Self { t_min, t_max: self.t_max + 0.0, ..*self })
    }
}
