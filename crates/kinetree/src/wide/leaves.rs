//! The triangle blocks of a tree: the collapse lists their triangles, then all threads gather the
//! corners.

use std::ops::Range;

use super::TriangleBlock;
use super::block::BLOCK;
use super::collapse::Items;
use crate::geometry::Triangles;
use crate::memory::{ChunkWriter, vec_in_chunks};
use crate::simd::{Isa, Kernel, Level};
use crate::threads::Threads;
use crate::tree::Bvh;

/// Blocks per parallel task.
const CHUNK: usize = 1024;

/// The prefetch distances of vertex indices and of vertices, in blocks.
const INDICES_AHEAD: usize = 16;
const VERTICES_AHEAD: usize = 8;

pub(super) struct Leaves<'a> {
    /// In the order of the leaves of the binary tree.
    primitives: &'a [u32],
    /// The same without duplicates within a leaf, if the tree has duplicates.
    distinct: Option<Vec<u32>>,
    blocks: Vec<Span>,
}

/// The triangles of a block, as a range of the primitive list.
#[derive(Clone, Copy)]
struct Span {
    first: u32,
    count: u32,
}

impl<'a> Leaves<'a> {
    pub(super) fn of(binary: &'a Bvh) -> Self {
        let primitives = binary.primitives();
        let distinct = binary.has_duplicates().then(Vec::new);
        Self { primitives, distinct, blocks: Vec::with_capacity(primitives.len().div_ceil(BLOCK)) }
    }

    /// Gathers the corners of all blocks.
    pub(super) fn blocks(&self, triangles: &Triangles, threads: &Threads) -> Vec<TriangleBlock> {
        let primitives = self.distinct.as_deref().unwrap_or(self.primitives);
        let level = Level::current();
        let fill = |first: usize, blocks: &mut ChunkWriter<'_, TriangleBlock>| {
            let spans = &self.blocks[first..first + blocks.size()];
            level.run(Fill { blocks, spans, primitives, triangles });
        };
        vec_in_chunks(self.blocks.len(), CHUNK, threads, &fill).0
    }
}

impl Items for Leaves<'_> {
    fn add(&mut self, range: Range<u32>) -> Range<u32> {
        let range = match &mut self.distinct {
            Some(distinct) => {
                // Parts of the same triangle may be collapsed into one leaf.
                let mut leaf = self.primitives[range.start as usize..range.end as usize].to_vec();
                leaf.sort_unstable();
                leaf.dedup();
                let first = distinct.len() as u32;
                distinct.extend_from_slice(&leaf);
                first..distinct.len() as u32
            }
            None => range,
        };
        let before = self.blocks.len() as u32;
        let mut first = range.start;
        while first < range.end {
            let count = (range.end - first).min(BLOCK as u32);
            self.blocks.push(Span { first, count });
            first += count;
        }
        before..self.blocks.len() as u32
    }

    fn part(&self) -> Self {
        Self { primitives: self.primitives, distinct: self.distinct.is_some().then(Vec::new), blocks: Vec::new() }
    }

    fn append(&mut self, part: Self) {
        let moved = self.distinct.as_ref().map_or(0, |distinct| distinct.len() as u32);
        self.blocks.extend(part.blocks.iter().map(|block| Span { first: block.first + moved, ..*block }));
        if let (Some(distinct), Some(more)) = (&mut self.distinct, &part.distinct) {
            distinct.extend_from_slice(more);
        }
    }
}

struct Fill<'a, 'b> {
    blocks: &'a mut ChunkWriter<'b, TriangleBlock>,
    spans: &'a [Span],
    primitives: &'a [u32],
    triangles: &'a Triangles,
}

impl Kernel for Fill<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        let (indices, positions) = (self.triangles.indices(), self.triangles.positions());
        for at in 0..self.spans.len() {
            if let Some(ahead) = self.spans.get(at + INDICES_AHEAD) {
                for index in ahead.first..ahead.first + ahead.count {
                    isa.prefetch(indices, self.primitives[index as usize] as usize);
                }
            }
            if let Some(ahead) = self.spans.get(at + VERTICES_AHEAD) {
                for index in ahead.first..ahead.first + ahead.count {
                    for vertex in &indices[self.primitives[index as usize] as usize] {
                        isa.prefetch(positions, *vertex as usize);
                    }
                }
            }
            let span = self.spans[at];
            let four = &self.primitives[span.first as usize..][..span.count as usize];
            self.blocks.push(TriangleBlock::gather(isa, four, indices, positions));
        }
    }
}
