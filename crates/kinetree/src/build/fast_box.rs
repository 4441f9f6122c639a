//! A box in vector registers, for the inner loops of builders.

use glam::Vec3A;

use super::reference::Reference;
use crate::geometry::Aabb;

/// An [`Aabb`] padded to four lanes per corner, so that extending it is two instructions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FastBox {
    pub(crate) min: Vec3A,
    pub(crate) max: Vec3A,
}

impl FastBox {
    pub(crate) const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    #[inline(always)]
    pub(crate) fn of(reference: &Reference) -> Self {
        Self::from(&reference.bounds)
    }

    #[inline(always)]
    pub(crate) fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    #[inline(always)]
    pub(crate) fn extend(&mut self, point: Vec3A) {
        self.min = self.min.min(point);
        self.max = self.max.max(point);
    }

    #[inline(always)]
    pub(crate) fn intersection(&self, other: &Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    #[inline(always)]
    pub(crate) fn half_area(&self) -> f32 {
        let extent = (self.max - self.min).max(Vec3A::ZERO);
        extent.x * extent.y + extent.y * extent.z + extent.z * extent.x
    }

    /// Half the area of the intersection.
    #[inline(always)]
    pub(crate) fn common_area(&self, other: &Self) -> f32 {
        let common = self.intersection(other);
        if common.is_empty() { 0.0 } else { common.half_area() }
    }
}

impl From<FastBox> for Aabb {
    #[inline(always)]
    fn from(bounds: FastBox) -> Self {
        Self::new(bounds.min.into(), bounds.max.into())
    }
}

impl From<&Aabb> for FastBox {
    #[inline(always)]
    fn from(bounds: &Aabb) -> Self {
        Self { min: bounds.min.into(), max: bounds.max.into() }
    }
}
