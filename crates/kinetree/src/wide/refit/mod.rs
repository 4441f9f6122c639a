//! Refitting: new boxes for the same eight-way tree, whose triangles have moved.
//!
//! A tree is refitted into a spare one of the same topology, so that queries of the old tree go on
//! undisturbed. The first refit makes a [`Plan`], which both trees share: from then on only corners
//! and planes are written, and nothing of the old tree is read. The tree is divided into chunks,
//! which are contiguous subtrees; chunks are refitted in parallel, then one thread refits the few
//! nodes above them. The spare may have missed any number of refits, since all chunks are refitted
//! every time.
//!
//! The pass over a chunk also sums up what the cost of rays is computed from (`measure`): the areas
//! of the boxes in its nodes, weighted by the cost of visiting them, and the areas of the
//! triangles' own boxes.
//!
//! If spatial splits cut a triangle, each of its leaves gets the box of the whole triangle.

mod plan;
mod sweep;

use std::ops::Range;
use std::sync::Arc;

pub(super) use plan::Plan;

use super::costs::Costs;
use super::node::LANES;
use super::{MeshBvh, TriangleBlock, WideNode, WideTarget};
use crate::geometry::{Aabb, Triangles};
use crate::simd::Level;
use crate::threads::Threads;
use plan::Chunk;
use sweep::Sweep;

/// Chunks per parallel task: some tens of microseconds. Smaller trees are refitted by one thread.
const GRAIN: usize = 4;

/// The results of refitting a chunk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ChunkBounds {
    pub(super) bounds: Aabb,
    /// The sum of the half areas of all boxes in its nodes, each times the cost of visiting its
    /// child.
    pub(super) cost: f64,
    /// The sum of the half areas of the boxes of its triangles, without padding.
    pub(super) triangle_boxes: f64,
}

/// The task of refitting a chunk.
struct ChunkTask<'a> {
    chunk: &'a Chunk,
    nodes: &'a mut [WideNode],
    blocks: &'a mut [TriangleBlock],
    chunk_bounds: ChunkBounds,
}

impl MeshBvh {
    /// Writes the same tree, for triangles that have moved, to `spare`, whatever its contents. If
    /// both trees share a plan because one was refitted from the other or both from a third, only
    /// boxes and corners are written, and nothing large is allocated.
    ///
    /// The boxes do not depend on the number of threads or the SIMD level.
    pub(crate) fn refit_into(&self, spare: &mut Self, triangles: &Triangles, threads: &Threads, level: Level) {
        let plan = match self.plan.get_or_init(|| Plan::of(self, triangles).into()) {
            plan if plan.fits(triangles) => plan.clone(),
            _ => Plan::of(self, triangles).into(),
        };
        if !spare.plan.get().is_some_and(|of| Arc::ptr_eq(of, &plan)) {
            spare.copy_topology_of(self, plan.clone());
        }
        let mut tasks = divide(&plan, &mut spare.tree.nodes, &mut spare.blocks);
        threads.for_each(&mut tasks, GRAIN, &|_, task| {
            task.chunk_bounds = level.run(Sweep {
                nodes: &mut *task.nodes,
                blocks: &mut *task.blocks,
                first_node: task.chunk.nodes.start as usize,
                first_block: task.chunk.blocks.start as usize,
                corners: plan.corners_of(&task.chunk.blocks),
                positions: triangles.positions(),
            });
        });
        spare.chunks.clear();
        spare.chunks.extend(tasks.iter().map(|task| task.chunk_bounds));
        spare.above_chunks(&plan, triangles);
    }

    /// Refits the nodes above the chunks, which are few.
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
            cost += nodes[at].cost_of_lanes(Costs::TRIANGLES.node, Costs::TRIANGLES.item);
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

/// Divides nodes and blocks among the chunks, except those above the chunks.
fn divide<'a>(plan: &'a Plan, nodes: &'a mut [WideNode], blocks: &'a mut [TriangleBlock]) -> Vec<ChunkTask<'a>> {
    let (mut nodes, mut blocks) = (Remaining { items: nodes, first: 0 }, Remaining { items: blocks, first: 0 });
    let chunk_bounds = ChunkBounds { bounds: Aabb::EMPTY, cost: 0.0, triangle_boxes: 0.0 };
    let of = |chunk: &'a Chunk| ChunkTask {
        chunk,
        nodes: nodes.take(&chunk.nodes),
        blocks: blocks.take(&chunk.blocks),
        chunk_bounds,
    };
    plan.chunks.iter().map(of).collect()
}

/// The items of a slice from `first` on.
struct Remaining<'a, T> {
    items: &'a mut [T],
    first: u32,
}

impl<'a, T> Remaining<'a, T> {
    fn take(&mut self, range: &Range<u32>) -> &'a mut [T] {
        let (_, rest) = std::mem::take(&mut self.items).split_at_mut((range.start - self.first) as usize);
        let (taken, rest) = rest.split_at_mut((range.end - range.start) as usize);
        (self.items, self.first) = (rest, range.end);
        taken
    }
}

#[cfg(test)]
mod naive;
#[cfg(test)]
mod tests;
