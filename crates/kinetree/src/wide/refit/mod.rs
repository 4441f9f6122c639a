//! New boxes for the same eight-way tree, whose triangles have moved.
//!
//! A tree is refitted into a spare one of the same topology, so that whoever still traces the old
//! one is not disturbed. What both have in common, a [`Plan`], is made at the first refit and
//! handed on: from then on only corners and planes are written, and nothing of the old tree is
//! read. The tree is cut into chunks, subtrees that stand together; each is chunk_bounds by itself, by any
//! thread, and then the few nodes above them are done by one. Whatever the spare had missed does
//! not matter, since every chunk is refitted every time.
//!
//! A sweep gives what the cost of rays follows from (`measure`): the areas of the boxes in its
//! nodes, weighed by what it takes to visit them, and the areas of the triangles' own boxes.
//!
//! Of a triangle that spatial splits had cut, every leaf that holds a part gets the whole.

mod plan;
mod sweep;

use std::ops::Range;
use std::sync::Arc;

pub(super) use plan::Plan;

use super::mesh_bvh::COSTS;
use super::node::LANES;
use super::{MeshBvh, TriangleBlock, WideNode, WideTarget};
use crate::geometry::{Aabb, Triangles};
use crate::simd::Level;
use crate::threads::Threads;
use plan::Chunk;
use sweep::Sweep;

/// Chunks in a piece of work, some tens of microseconds. Trees of fewer are refitted by one thread.
const GRAIN: usize = 4;

/// What a refit found out about a chunk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ChunkBounds {
    pub(super) bounds: Aabb,
    /// Half areas of all boxes in its nodes, each weighed by what it costs to visit.
    pub(super) cost: f64,
    /// Half areas of the boxes of its triangles, without padding.
    pub(super) triangle_boxes: f64,
}

/// A chunk and what is written to it.
struct Work<'a> {
    chunk: &'a Chunk,
    nodes: &'a mut [WideNode],
    blocks: &'a mut [TriangleBlock],
    chunk_bounds: ChunkBounds,
}

impl MeshBvh {
    /// The same tree for triangles that have moved, written into `spare`, whatever that held
    /// before. If it held a tree that was refitted from this one, or from one that this was
    /// refitted from, nothing but boxes and corners is written, and nothing large is allocated.
    ///
    /// The same boxes for every number of threads and every level.
    pub(crate) fn refit_into(&self, spare: &mut Self, triangles: &Triangles, threads: &Threads, level: Level) {
        let plan = match self.plan.get_or_init(|| Plan::of(self, triangles).into()) {
            plan if plan.fits(triangles) => plan.clone(),
            _ => Plan::of(self, triangles).into(),
        };
        if !spare.plan.get().is_some_and(|of| Arc::ptr_eq(of, &plan)) {
            spare.take_shape_of(self, plan.clone());
        }
        let mut work = share_out(&plan, &mut spare.tree.nodes, &mut spare.blocks);
        threads.for_each(&mut work, GRAIN, &|_, work| {
            work.chunk_bounds = level.run(Sweep {
                nodes: &mut *work.nodes,
                blocks: &mut *work.blocks,
                first_node: work.chunk.nodes.start as usize,
                first_block: work.chunk.blocks.start as usize,
                corners: plan.corners_of(&work.chunk.blocks),
                positions: triangles.positions(),
            });
        });
        spare.chunks.clear();
        spare.chunks.extend(work.iter().map(|work| work.chunk_bounds));
        spare.above_chunks(&plan, triangles);
    }

    /// The nodes above the chunks, in plain code: there are few.
    fn above_chunks(&mut self, plan: &Plan, triangles: &Triangles) {
        let (nodes, blocks) = (&mut self.tree.nodes, &mut self.blocks);
        self.tree.bounds = Aabb::EMPTY;
        for (chunk, chunk_bounds) in plan.chunks.iter().zip(&self.chunks) {
            match chunk.nodes.start {
                0 => self.tree.bounds = chunk_bounds.bounds,
                root => set_in_parent(nodes, root as usize, &chunk_bounds.bounds),
            }
        }
        let (mut cost, mut triangle_boxes) = (0.0, 0.0);
        for &at in plan.above.iter().rev() {
            let at = at as usize;
            for lane in 0..LANES {
                let Some(link) = nodes[at].link(lane) else { break };
                if let WideTarget::Items(items) = link.target() {
                    let mut bounds = Aabb::EMPTY;
                    for block in &mut blocks[items.start as usize..items.end as usize] {
                        block.move_to(|triangle| triangles.get(triangle));
                        bounds = bounds.union(&block.bounds());
                        triangle_boxes += block.triangle_box_areas();
                    }
                    nodes[at].set_box(lane, &bounds);
                }
            }
            cost += nodes[at].cost_of_lanes(COSTS.node, COSTS.item);
            let all = nodes[at].all_bounds();
            match at {
                0 => self.tree.bounds = all,
                _ => set_in_parent(nodes, at, &all),
            }
        }
        self.chunks.push(ChunkBounds { bounds: self.tree.bounds, cost, triangle_boxes });
    }
}

fn set_in_parent(nodes: &mut [WideNode], child: usize, bounds: &Aabb) {
    let parent = nodes[child].parent_lane as usize;
    nodes[parent / LANES].set_box(parent % LANES, bounds);
}

/// Divides nodes and blocks among the chunks. Those above the chunks are left out.
fn share_out<'a>(plan: &'a Plan, nodes: &'a mut [WideNode], blocks: &'a mut [TriangleBlock]) -> Vec<Work<'a>> {
    let (mut nodes, mut blocks) = (Rest { items: nodes, first: 0 }, Rest { items: blocks, first: 0 });
    let chunk_bounds = ChunkBounds { bounds: Aabb::EMPTY, cost: 0.0, triangle_boxes: 0.0 };
    let of = |chunk: &'a Chunk| Work {
        chunk,
        nodes: nodes.take(&chunk.nodes),
        blocks: blocks.take(&chunk.blocks),
        chunk_bounds,
    };
    plan.chunks.iter().map(of).collect()
}

/// The items of a slice from `first` on.
struct Rest<'a, T> {
    items: &'a mut [T],
    first: u32,
}

impl<'a, T> Rest<'a, T> {
    fn take(&mut self, range: &Range<u32>) -> &'a mut [T] {
        let (_, rest) = std::mem::take(&mut self.items).split_at_mut((range.start - self.first) as usize);
        let (taken, rest) = rest.split_at_mut((range.end - range.start) as usize);
        (self.items, self.first) = (rest, range.end);
        taken
    }
}

#[cfg(test)]
mod by_hand;
#[cfg(test)]
mod tests;
