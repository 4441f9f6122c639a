//! Many triangles that share vertices.

use std::fmt;
use std::sync::Arc;

use super::{Aabb, Triangle};
use crate::digest::Digest;

/// Positions, and which three of them make a triangle. Every index is in range.
#[derive(Clone, Default)]
pub struct Triangles {
    positions: Vec<[f32; 3]>,
    indices: Arc<[[u32; 3]]>,
}

/// In short: how many there are.
impl fmt::Debug for Triangles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (vertices, triangles) = (self.positions.len(), self.len());
        f.debug_struct("Triangles").field("vertices", &vertices).field("triangles", &triangles).finish_non_exhaustive()
    }
}

impl Triangles {
    /// `None` when an index is out of range.
    pub fn new(positions: Vec<[f32; 3]>, indices: Arc<[[u32; 3]]>) -> Option<Self> {
        let count = positions.len();
        let in_range = indices.iter().flatten().all(|&index| (index as usize) < count);
        in_range.then_some(Self { positions, indices })
    }

    /// How many triangles there are.
    #[inline]
    pub fn len(&self) -> usize {
        self.indices.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.indices.is_empty()
    }

    /// The corners of a triangle.
    #[inline]
    pub fn get(&self, triangle: u32) -> Triangle {
        Triangle { corners: self.indices[triangle as usize].map(|vertex| self.positions[vertex as usize]) }
    }

    /// The box that trees store for a triangle: padded by a few roundings of its size.
    #[inline]
    pub fn bounds_of(&self, triangle: u32) -> Aabb {
        self.get(triangle).bounds().padded()
    }

    /// A hash of positions and triangles to the bit. Not cryptographic.
    pub fn fingerprint(&self) -> u64 {
        fingerprint(&self.positions, &self.indices)
    }

    /// Metres, object space.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Vertex numbers, three per triangle.
    pub fn indices(&self) -> &[[u32; 3]] {
        &self.indices
    }

    /// The positions, to be overwritten.
    pub(crate) fn positions_mut(&mut self) -> &mut [[f32; 3]] {
        &mut self.positions
    }

    /// Exchanges the positions.
    ///
    /// # Panics
    /// When there are not as many.
    pub(crate) fn swap_positions(&mut self, positions: &mut Vec<[f32; 3]>) {
        assert_eq!(self.positions.len(), positions.len());
        std::mem::swap(&mut self.positions, positions);
    }

    /// Bytes held; indices are shared between the buffers of a mesh and count once there.
    pub(crate) fn heap_bytes(&self) -> usize {
        self.positions.capacity() * size_of::<[f32; 3]>()
    }

    pub(crate) fn shared_indices(&self) -> &Arc<[[u32; 3]]> {
        &self.indices
    }
}

/// See [`Triangles::fingerprint`].
pub(crate) fn fingerprint(positions: &[[f32; 3]], indices: &[[u32; 3]]) -> u64 {
    let mut digest = Digest::new();
    digest.word(positions.len() as u64);
    digest.word(indices.len() as u64);
    positions.iter().for_each(|position| digest.triple(position.map(f32::to_bits)));
    indices.iter().for_each(|triangle| digest.triple(*triangle));
    digest.finish()
}
