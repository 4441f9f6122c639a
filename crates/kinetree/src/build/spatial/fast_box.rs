//! A box in vector registers, for the inner loops of the search.

use glam::Vec3A;

use crate::geometry::Aabb;

/// An [`Aabb`] with room for a fourth lane, so that extending it is two instructions.
#[derive(Debug, Clone, Copy)]
pub(super) struct FastBox {
    pub(super) min: Vec3A,
    pub(super) max: Vec3A,
}

impl FastBox {
    pub(super) const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    #[inline(always)]
    pub(super) fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    #[inline(always)]
    pub(super) fn extend(&mut self, point: Vec3A) {
        self.min = self.min.min(point);
        self.max = self.max.max(point);
    }

    #[inline(always)]
    pub(super) fn intersection(&self, other: &Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        let extent = (self.max - self.min).max(Vec3A::ZERO);
        extent.x * extent.y + extent.y * extent.z + extent.z * extent.x
    }
}

impl From<&Aabb> for FastBox {
    #[inline(always)]
    fn from(bounds: &Aabb) -> Self {
        Self { min: bounds.min.into(), max: bounds.max.into() }
    }
}
