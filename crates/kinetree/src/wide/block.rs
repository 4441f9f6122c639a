//! Blocks of four triangles, which are tested together.

use crate::geometry::{Aabb, Triangle};
use crate::simd::Isa;

/// The number of triangles in a full block.
pub(crate) const BLOCK: usize = 4;

/// The corners of up to four triangles, in three cache lines. The corners of an unused lane are
/// NaN, which no ray hits.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct TriangleBlock {
    /// `corners[corner][axis][lane]`.
    pub(crate) corners: [[[f32; BLOCK]; 3]; 3],
    /// The caller's triangle indices; unused lanes repeat the first.
    pub(crate) primitives: [u32; BLOCK],
    /// See [`Triangle::extent`]; NaN in unused lanes.
    extents: [f32; BLOCK],
    /// Lanes in use come first.
    pub(crate) count: u32,
    spare: [u32; 3],
}

const _: () = assert!(size_of::<TriangleBlock>() == 192);

impl TriangleBlock {
    /// # Panics
    /// When there is no triangle, or more than four.
    pub(crate) fn new(primitives: &[u32], triangle_of: impl Fn(u32) -> Triangle) -> Self {
        assert!((1..=BLOCK).contains(&primitives.len()));
        let mut block = Self {
            corners: [[[f32::NAN; BLOCK]; 3]; 3],
            primitives: [primitives[0]; BLOCK],
            extents: [f32::NAN; BLOCK],
            count: primitives.len() as u32,
            spare: [0; 3],
        };
        block.primitives[..primitives.len()].copy_from_slice(primitives);
        block.move_to(triangle_of);
        block
    }

    /// As `new`, for indexed triangles.
    #[inline(always)]
    pub(super) fn gather<I: Isa>(isa: I, primitives: &[u32], indices: &[[u32; 3]], positions: &[[f32; 3]]) -> Self {
        let count = primitives.len();
        let mut numbers = [primitives[0]; BLOCK];
        numbers[..count].copy_from_slice(primitives);
        let mut vertices = [[0; 3]; BLOCK];
        for lane in 0..BLOCK {
            vertices[lane] = indices[numbers[lane] as usize];
        }
        let zero = isa.splat(0.0);
        let mut corners = [[zero; 3]; 3];
        for corner in 0..3 {
            let [x, y, z, _] = isa.transpose([
                isa.load3(&positions[vertices[0][corner] as usize]),
                isa.load3(&positions[vertices[1][corner] as usize]),
                isa.load3(&positions[vertices[2][corner] as usize]),
                isa.load3(&positions[vertices[3][corner] as usize]),
            ]);
            corners[corner] = [x, y, z];
        }
        let mut block = Self {
            corners: [[[0.0; BLOCK]; 3]; 3],
            primitives: numbers,
            extents: [0.0; BLOCK],
            count: count as u32,
            spare: [0; 3],
        };
        block.set_corners(isa, corners);
        block
    }

    /// Updates the corners.
    #[inline]
    pub(crate) fn move_to(&mut self, triangle_of: impl Fn(u32) -> Triangle) {
        for lane in 0..self.count as usize {
            let triangle = triangle_of(self.primitives[lane]);
            self.extents[lane] = triangle.extent();
            for corner in 0..3 {
                for axis in 0..3 {
                    self.corners[corner][axis][lane] = triangle.corners[corner][axis];
                }
            }
        }
    }

    #[inline]
    pub(crate) fn triangle(&self, lane: usize) -> Triangle {
        Triangle { corners: [0, 1, 2].map(|corner| [0, 1, 2].map(|axis| self.corners[corner][axis][lane])) }
    }

    /// The block as rows of four floats: row `corner * 3 + axis` has that coordinate of that
    /// corner. The rows after the ninth make an index with any axis below four valid.
    #[inline(always)]
    pub(crate) fn rows(&self) -> &[[f32; BLOCK]; 12] {
        bytemuck::cast_ref(self)
    }

    /// The longest edges of the boxes of the four triangles.
    #[inline(always)]
    pub(crate) fn extents(&self) -> &[f32; BLOCK] {
        &self.extents
    }

    /// Writes the corners of the lanes in use, and returns the lower and upper corners of the boxes
    /// of all lanes.
    #[inline(always)]
    pub(super) fn set_corners<I: Isa>(&mut self, isa: I, corners: [[I::F4; 3]; 3]) -> [[I::F4; 3]; 2] {
        let nan = isa.splat(f32::NAN);
        let (mut min, mut max) = (corners[0], corners[0]);
        let mut extents = isa.splat(0.0);
        for axis in 0..3 {
            for corner in 0..3 {
                self.corners[corner][axis] = isa.store(isa.blend_prefix(self.count, corners[corner][axis], nan));
                min[axis] = isa.min(min[axis], corners[corner][axis]);
                max[axis] = isa.max(max[axis], corners[corner][axis]);
            }
            extents = isa.max(isa.sub(max[axis], min[axis]), extents);
        }
        self.extents = isa.store(isa.blend_prefix(self.count, extents, nan));
        [min, max]
    }

    /// A bit for each lane in use.
    #[inline(always)]
    pub(crate) fn lanes_in_use(&self) -> u32 {
        0b1111 >> ((BLOCK as u32 - self.count) & 3)
    }

    /// The caller's triangle indices.
    pub fn primitives(&self) -> &[u32] {
        &self.primitives[..self.count as usize]
    }

    /// The padded box of the triangle in a lane, as
    /// [`Triangles::bounds_of`](crate::geometry::Triangles::bounds_of).
    #[inline]
    pub(crate) fn bounds_of(&self, lane: usize) -> Aabb {
        self.triangle(lane).bounds().padded()
    }

    /// The padded box of the triangles in the block.
    #[inline]
    pub(crate) fn bounds(&self) -> Aabb {
        (0..self.count as usize).fold(Aabb::EMPTY, |all, lane| all.union(&self.bounds_of(lane)))
    }

    /// The summed half areas of the boxes of its triangles, without padding.
    pub(super) fn triangle_box_areas(&self) -> f64 {
        (0..self.count as usize).map(|lane| f64::from(self.triangle(lane).bounds().half_area())).sum()
    }
}
