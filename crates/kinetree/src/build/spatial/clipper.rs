//! Splitting references: clips the triangle of a reference against the planes.
//!
//! The original triangle is always clipped anew, against the box of the reference and the plane,
//! and the result is padded as much as the box of the whole triangle. Any point of the triangle is
//! in one of the closed regions between the planes, and the reference for that region contains the
//! point with all of its padding, except for what lies outside the padded box of the whole
//! triangle. So the argument for whole triangles (see [`SafeRay`](crate::geometry::SafeRay)) holds
//! for each part, and no ray slips between two of them.

use crate::build::reference::Reference;
use crate::geometry::{Aabb, Triangles, clipped_bounds};

/// Splits references to triangles.
#[derive(Clone, Copy)]
pub(super) struct TriangleClipper<'a> {
    triangles: &'a Triangles,
}

impl<'a> TriangleClipper<'a> {
    pub(super) fn of(triangles: &'a Triangles) -> Self {
        Self { triangles }
    }

    pub(super) fn triangles(&self) -> &'a Triangles {
        self.triangles
    }

    /// The padded box of the part of a reference within a region; empty if there is none.
    pub(super) fn within(&self, reference: &Reference, region: &Aabb) -> Aabb {
        let triangle = self.triangles.get(reference.id);
        let clipped = clipped_bounds(&triangle, &reference.bounds.intersection(region));
        if clipped.is_empty() {
            return Aabb::EMPTY;
        }
        clipped.widened(triangle.bounds().padding()).intersection(&reference.bounds)
    }

    /// The boxes of the parts on either side of a plane. The plane belongs to both.
    pub(super) fn sides(&self, reference: &Reference, axis: usize, position: f32) -> [Aabb; 2] {
        let (mut below, mut above) = (reference.bounds, reference.bounds);
        below.max[axis] = position;
        above.min[axis] = position;
        [self.within(reference, &below), self.within(reference, &above)]
    }
}
