//! The blocks of a tree that is being collapsed: first which triangles they hold, then, on all threads, their corners.

use std::ops::Range;

use super::TriangleBlock;
use super::block::BLOCK;
use super::collapse::Items;
use crate::geometry::Triangles;
use crate::memory::{ChunkWriter, vec_in_chunks};
use crate::simd::{Isa, Kernel, Level};
use crate::threads::Threads;
use crate::tree::Bvh;

/// Blocks that are written by one thread.
const CHUNK: usize = 1024;

/// How far ahead memory is asked for, in blocks: vertex numbers, then the vertices.
const NUMBERS_AHEAD: usize = 16;
const VERTICES_AHEAD: usize = 8;

pub(super) struct Leaves<'a> {
    /// In the order of the leaves of the binary tree.
    primitives: &'a [u32],
    /// The same without what stands in a leaf twice, if there may be any.
    distinct: Option<Vec<u32>>,
    blocks: Vec<Span>,
}

/// Where the triangles of a block stand in the list of primitives.
#[derive(Clone, Copy)]
struct Span {
    first: u32,
    count: u32,
}

impl<'a> Leaves<'a> {
    pub(super) fn of(binary: &'a Bvh) -> Self {
        let primitives = binary.primitives();
        Self { primitives, distinct: binary.has_duplicates().then(Vec::new), blocks: Vec::new() }
    }

    /// All blocks.
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
    fn add(&mut self, places: Range<u32>) -> Range<u32> {
        let places = match &mut self.distinct {
            Some(distinct) => {
                // Pieces of the same triangle may meet again in a leaf.
                let mut leaf = self.primitives[places.start as usize..places.end as usize].to_vec();
                leaf.sort_unstable();
                leaf.dedup();
                let first = distinct.len() as u32;
                distinct.extend_from_slice(&leaf);
                first..distinct.len() as u32
            }
            None => places,
        };
        let before = self.blocks.len() as u32;
        let starts = places.clone().step_by(BLOCK);
        self.blocks.extend(starts.map(|first| Span { first, count: (places.end - first).min(BLOCK as u32) }));
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
            if let Some(ahead) = self.spans.get(at + NUMBERS_AHEAD) {
                for place in ahead.first..ahead.first + ahead.count {
                    isa.prefetch(indices, self.primitives[place as usize] as usize);
                }
            }
            if let Some(ahead) = self.spans.get(at + VERTICES_AHEAD) {
                for place in ahead.first..ahead.first + ahead.count {
                    for vertex in &indices[self.primitives[place as usize] as usize] {
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
