//! Axis-aligned boxes.

use glam::Vec3;

use super::UNIT_ROUNDOFF;

/// An axis-aligned box, closed on all sides. A box with `min > max` on an axis is empty.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Aabb {
    /// Least corner, metres.
    pub min: [f32; 3],
    /// Greatest corner, metres.
    pub max: [f32; 3],
}

impl Default for Aabb {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Aabb {
    /// Contains nothing, and is the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// The box between two corners.
    pub const fn new(min: [f32; 3], max: [f32; 3]) -> Self {
        Self { min, max }
    }

    /// The smallest box around points; empty without any.
    pub fn from_points(points: impl IntoIterator<Item = [f32; 3]>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| bounds.extended(point))
    }

    /// Whether no point lies inside.
    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.min[axis] > self.max[axis])
    }

    /// Whether the box contains a point. An inverted box, and one with a NaN, does not.
    #[inline]
    pub(crate) fn has_point(&self) -> bool {
        (0..3).all(|axis| self.min[axis] <= self.max[axis])
    }

    /// The smallest box around both.
    #[inline]
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: Vec3::from(self.min).min(Vec3::from(other.min)).into(),
            max: Vec3::from(self.max).max(Vec3::from(other.max)).into(),
        }
    }

    /// The smallest box around this one and a point.
    #[inline]
    #[must_use]
    pub fn extended(&self, point: [f32; 3]) -> Self {
        self.union(&Self { min: point, max: point })
    }

    /// The six numbers as two overlapping quads, for vector loads.
    #[inline(always)]
    pub(crate) fn quads(&self) -> [&[f32; 4]; 2] {
        let all: &[f32; 6] = bytemuck::cast_ref(self);
        [all.first_chunk().expect("six numbers"), all.last_chunk().expect("six numbers")]
    }

    /// The intersection, which may be empty.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        Self {
            min: Vec3::from(self.min).max(Vec3::from(other.min)).into(),
            max: Vec3::from(self.max).min(Vec3::from(other.max)).into(),
        }
    }

    /// Whether the two share a point; touching counts.
    pub fn overlaps(&self, other: &Self) -> bool {
        !self.intersection(other).is_empty()
    }

    /// The centre. Meaningless for an empty box.
    #[inline]
    pub fn center(&self) -> [f32; 3] {
        (Vec3::from(self.min) * 0.5 + Vec3::from(self.max) * 0.5).into()
    }

    /// The lengths of the edges, metres; zero for an empty box.
    #[inline]
    pub fn extent(&self) -> [f32; 3] {
        (Vec3::from(self.max) - Vec3::from(self.min)).max(Vec3::ZERO).into()
    }

    /// Half of the surface area, square metres; zero for an empty box. The probability of a hit is
    /// proportional to it.
    #[inline]
    pub fn half_area(&self) -> f32 {
        let [x, y, z] = self.extent();
        x * y + y * z + z * x
    }

    /// Whether the other box lies within this one. Every box contains the empty box.
    pub fn contains(&self, other: &Self) -> bool {
        other.is_empty() || (0..3).all(|axis| self.min[axis] <= other.min[axis] && other.max[axis] <= self.max[axis])
    }

    /// Whether a point lies inside or on the surface.
    pub fn contains_point(&self, point: [f32; 3]) -> bool {
        (0..3).all(|axis| self.min[axis] <= point[axis] && point[axis] <= self.max[axis])
    }

    /// The axis of the longest edge: 0, 1 or 2.
    pub fn largest_axis(&self) -> usize {
        let [x, y, z] = self.extent();
        if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        }
    }

    /// Whether both corners are finite numbers.
    pub fn is_finite(&self) -> bool {
        super::is_finite(self.min) && super::is_finite(self.max)
    }

    /// How far the box of a primitive is padded, relative to its longest edge: eight roundings. The
    /// error bound of box tests covers the rest (decision 18).
    pub(crate) const PADDING: f32 = 8.0 * UNIT_ROUNDOFF;

    /// The box that a tree keeps for a primitive: widened by some roundings of the primitive's own
    /// size. Exact hits need less (decision 18); trees in files have boxes like these.
    pub(crate) fn padded(&self) -> Self {
        self.widened(self.padding())
    }

    /// By how much a box of a primitive of this size is widened, metres.
    pub(crate) fn padding(&self) -> f32 {
        let [x, y, z] = self.extent();
        Self::PADDING * x.max(y).max(z)
    }

    /// The box moved outwards by `pad` on all sides.
    pub(crate) fn widened(&self, pad: f32) -> Self {
        Self { min: (Vec3::from(self.min) - pad).into(), max: (Vec3::from(self.max) + pad).into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_empty_box_is_neutral_and_without_area() {
        let unit = Aabb::new([0.0; 3], [1.0; 3]);
        assert_eq!(unit.union(&Aabb::EMPTY), unit);
        assert!(Aabb::EMPTY.is_empty() && !unit.is_empty());
        assert_eq!(Aabb::EMPTY.half_area(), 0.0);
        assert!(unit.contains(&Aabb::EMPTY) && !Aabb::EMPTY.contains(&unit));
    }

    #[test]
    fn areas_centres_and_axes_are_those_of_a_brick() {
        let brick = Aabb::new([-1.0, 0.0, 2.0], [1.0, 3.0, 6.0]);
        assert_eq!(brick.half_area(), 2.0 * 3.0 + 3.0 * 4.0 + 4.0 * 2.0);
        assert_eq!(brick.center(), [0.0, 1.5, 4.0]);
        assert_eq!(brick.largest_axis(), 2);
    }

    #[test]
    fn the_middle_of_a_huge_box_is_finite() {
        assert_eq!(Aabb::new([-f32::MAX; 3], [f32::MAX; 3]).center(), [0.0; 3]);
    }
}
