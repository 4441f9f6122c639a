//! Four triangles, tested at once.

use crate::geometry::{Aabb, Triangle};
use crate::simd::Isa;

/// How many triangles a block has room for.
pub(crate) const BLOCK: usize = 4;

/// The corners of up to four triangles, in three cache lines. A lane that is not in use has corners that are no numbers, which no ray hits.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct TriangleBlock {
    /// `corners[corner][axis][lane]`.
    pub(crate) corners: [[[f32; BLOCK]; 3]; 3],
    /// Numbers as the caller gave them; those of unused lanes are the same as the first.
    pub(crate) primitives: [u32; BLOCK],
    /// See [`Triangle::extent`]; of unused lanes no numbers.
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

    /// The same as `new`, of triangles with these vertices.
    #[inline(always)]
    pub(super) fn gather<I: Isa>(isa: I, primitives: &[u32], indices: &[[u32; 3]], positions: &[[f32; 3]]) -> Self {
        let count = primitives.len();
        let mut numbers = [primitives[0]; BLOCK];
        numbers[..count].copy_from_slice(primitives);
        let mut vertices = [[0; 3]; BLOCK];
        for lane in 0..BLOCK {
            vertices[lane] = indices[numbers[lane] as usize];
        }
        let nothing = isa.splat4(0.0);
        let mut corners = [[nothing; 3]; 3];
        for corner in 0..3 {
            let [x, y, z, _] = isa.transpose4([
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

    /// Fetches the corners again.
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

    /// As rows of four: number `corner * 3 + axis` has a coordinate of that corner. There are more rows than that, so that any axis below four is inside.
    #[inline(always)]
    pub(crate) fn rows(&self) -> &[[f32; BLOCK]; 12] {
        bytemuck::cast_ref(self)
    }

    /// The longest edges of the boxes of the triangles.
    #[inline(always)]
    pub(crate) fn extents(&self) -> &[f32; BLOCK] {
        &self.extents
    }

    /// Writes the corners of all lanes, of which those in use count, and gives the box of each.
    #[inline(always)]
    pub(super) fn set_corners<I: Isa>(&mut self, isa: I, corners: [[I::F4; 3]; 3]) -> [[I::F4; 3]; 2] {
        let nothing = isa.splat4(f32::NAN);
        let (mut min, mut max) = (corners[0], corners[0]);
        let mut extents = isa.splat4(0.0);
        for axis in 0..3 {
            for corner in 0..3 {
                self.corners[corner][axis] = isa.store4(isa.blend_prefix(self.count, corners[corner][axis], nothing));
                min[axis] = isa.min4(min[axis], corners[corner][axis]);
                max[axis] = isa.max4(max[axis], corners[corner][axis]);
            }
            extents = isa.max4(isa.sub4(max[axis], min[axis]), extents);
        }
        self.extents = isa.store4(isa.blend_prefix(self.count, extents, nothing));
        [min, max]
    }

    /// A bit for each lane in use.
    #[inline(always)]
    pub(crate) fn lanes_in_use(&self) -> u8 {
        0b1111 >> ((BLOCK as u32 - self.count) & 3)
    }

    /// Numbers of the triangles.
    pub fn primitives(&self) -> &[u32] {
        &self.primitives[..self.count as usize]
    }

    /// The box that a tree keeps for one of these triangles, as
    /// [`Triangles::bounds_of`](crate::geometry::Triangles::bounds_of).
    #[inline]
    pub(crate) fn bounds_of(&self, lane: usize) -> Aabb {
        self.triangle(lane).bounds().padded()
    }

    /// The box that a tree keeps for these triangles.
    #[inline]
    pub(crate) fn bounds(&self) -> Aabb {
        (0..self.count as usize).fold(Aabb::EMPTY, |all, lane| all.union(&self.bounds_of(lane)))
    }

    /// The summed half areas of the boxes of its triangles, without padding.
    pub(super) fn triangle_box_areas(&self) -> f64 {
        (0..self.count as usize).map(|lane| f64::from(self.triangle(lane).bounds().half_area())).sum()
    }
}
