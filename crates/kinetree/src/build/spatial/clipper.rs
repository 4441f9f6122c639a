//! The pieces that a reference is cut into.
//!
//! A piece is always clipped anew from the original triangle, against the box of the reference and the plane, and then widened as much as the box of
//! the whole triangle is. Take any point of the triangle: it lies in one of the closed pieces of space that the planes so far have made, and the
//! reference of that piece contains not only the point but all within the padding of it, unless even the box of the whole triangle does not. So the
//! argument for whole triangles (see [`SafeRay`](crate::geometry::SafeRay)) holds for each piece, and no ray slips between two of them.

use crate::build::reference::Reference;
use crate::geometry::{Aabb, Triangles, clipped_bounds};

/// Cuts references to triangles.
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

    /// The box that a tree keeps for what is left of a reference within a region; empty when nothing is.
    pub(super) fn within(&self, reference: &Reference, region: &Aabb) -> Aabb {
        let triangle = self.triangles.get(reference.id);
        let clipped = clipped_bounds(&triangle, &reference.bounds.intersection(region));
        if clipped.is_empty() {
            return Aabb::EMPTY;
        }
        clipped.widened(triangle.bounds().padding()).intersection(&reference.bounds)
    }

    /// What is left on either side of a plane. The plane belongs to both.
    pub(super) fn sides(&self, reference: &Reference, axis: usize, position: f32) -> [Aabb; 2] {
        let (mut below, mut above) = (reference.bounds, reference.bounds);
        below.max[axis] = position;
        above.min[axis] = position;
        [self.within(reference, &below), self.within(reference, &above)]
    }
}
