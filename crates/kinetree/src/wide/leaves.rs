//! The blocks of a tree that is being collapsed: first which triangles they hold, then, on all threads, their corners.

use std::ops::Range;

use super::TriangleBlock;
use super::block::BLOCK;
use crate::arena::{Piece, with_room, written};
use crate::geometry::Triangles;
use crate::simd::{Isa, Kernel, Level};
use crate::threads::Threads;
use crate::tree::Bvh;

/// Blocks that are written by one thread.
const PIECE: usize = 1024;

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
        let distinct = binary.has_duplicates().then(|| with_room(primitives.len()));
        Self { primitives, distinct, blocks: with_room(primitives.len() / 2 + 1) }
    }

    /// One leaf more: the numbers of its blocks.
    pub(super) fn add(&mut self, places: Range<u32>) -> Range<u32> {
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

    /// All blocks.
    pub(super) fn blocks(&self, triangles: &Triangles, threads: &Threads) -> Vec<TriangleBlock> {
        let primitives = self.distinct.as_deref().unwrap_or(self.primitives);
        let level = Level::current();
        let fill = |first: usize, blocks: &mut Piece<'_, TriangleBlock>| {
            let spans = &self.blocks[first..first + blocks.size()];
            level.run(Fill { blocks, spans, primitives, triangles });
        };
        written(self.blocks.len(), PIECE, threads, &fill).0
    }
}

struct Fill<'a, 'b> {
    blocks: &'a mut Piece<'b, TriangleBlock>,
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
