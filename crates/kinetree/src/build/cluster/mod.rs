//! Bottom-up construction by clustering neighbours along a space-filling curve.
//!
//! Primitives are sorted along a Morton curve. Each branch of the radix tree over the codes is
//! merged down to a few clusters: each cluster searches a few neighbours left and right for the one
//! with the smallest joint box, and mutual choices merge. Then merging goes on with the clusters of
//! the sibling branch. So all merging takes place among a few dozen clusters, in the first-level
//! cache.
//!
//! Meister and Bittner 2018, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy
//! Construction"; in branches after Benthin, Meister, Barczak, Mehalwal, Tsakok and Kensler 2024,
//! "H-PLOC: Hierarchical Parallel Locally-Ordered Clustering".

mod chunk;
mod emit;
mod active_clusters;
mod pair;
#[cfg(test)]
mod tests;
mod top;

use chunk::{Chunk, Task, fork};
use top::ChunkJoiner;

use super::BuildOptions;
use super::grow::unfinished;
use super::morton::Curve;
use super::radix_sort::sort;
use super::reference::GRAIN;
use crate::geometry::Aabb;
use crate::memory::{ChunkWriter, vec_in_chunks};
use crate::simd::Level;
use crate::threads::Threads;
use crate::tree::Bvh;
use crate::wide::Costs;

/// The largest number of bits of a Morton code: more would need another sorting pass and do not
/// improve trees.
const CODE_BITS: u32 = 44;

/// The largest branch that becomes a leaf without a comparison of costs: a full block of triangles.
const FULL_LEAF: u32 = Costs::TRIANGLES.item_size as u32;

/// Up to this many primitives, codes are computed bit by bit, because filling the tables would take
/// longer.
const BIT_BY_BIT_LIMIT: usize = 64;

/// Boxes and codes per parallel task.
const CHUNK: usize = 4096;

/// Builds a tree over primitives 0 to `count - 1`, whose boxes `bounds_of` returns. Primitives with
/// an empty box are left out. The tree depends neither on the number of threads nor on the
/// processor.
///
/// # Panics
/// When there are more primitives than 2^27.
pub fn build_clustered(count: usize, bounds_of: impl Fn(u32) -> Aabb + Sync, options: &BuildOptions) -> Bvh {
    clustered_at(Level::current(), count, bounds_of, options, 1)
}

/// As [`build_clustered`], in less time, with costs that are a few per cent higher: whole branches
/// of up to [`FULL_LEAF`] primitives become leaves at once, where a node visit costs as much as the
/// tests in it.
pub(crate) fn clustered_from_branches(
    count: usize,
    bounds_of: impl Fn(u32) -> Aabb + Sync,
    options: &BuildOptions,
) -> Bvh {
    let first_leaf = (options.node_cost.max(1.0) as u32).min(options.leaf_limit() as u32).min(FULL_LEAF);
    clustered_at(Level::current(), count, bounds_of, options, first_leaf)
}

fn clustered_at(
    level: Level,
    count: usize,
    bounds_of: impl Fn(u32) -> Aabb + Sync,
    options: &BuildOptions,
    first_leaf: u32,
) -> Bvh {
    assert!(count <= pair::MAX_PRIMITIVES, "{count} primitives are more than a tree can have");
    let threads = &options.threads;
    let (boxes, summary) = BoxSummary::of(count, &bounds_of, threads);
    if summary.primitives == 0 {
        return Bvh::default();
    }
    let primitive_bits = count.next_power_of_two().ilog2();
    let mut keys = summary.keys(&boxes, primitive_bits, threads);
    sort(&mut keys, primitive_bits, primitive_bits + CODE_BITS.min(64 - primitive_bits), threads);

    let task = Task {
        boxes: &boxes,
        primitive_mask: (1 << primitive_bits) - 1,
        leaf_limit: options.leaf_limit() as u32,
        first_leaf,
        node_cost: options.node_cost,
        level,
    };
    let mut top = ChunkJoiner::new(level);
    let mut chunks = Vec::new();
    split(&mut keys, &mut chunks, &mut top);
    threads.begin_stage(0.8, summary.primitives);
    threads.for_each(&mut chunks, 1, &|_, chunk| {
        if !threads.is_cancelled() {
            chunk.cluster(&task);
            threads.advance(chunk.keys.len());
        }
    });
    if threads.is_cancelled() {
        return unfinished(summary.centers, 0);
    }
    // Freed before the tree is allocated.
    drop(boxes);
    top.tree(&mut chunks, threads)
}

/// Divides the curve into branches of at most [`GRAIN`] keys, and records in which order the top of
/// the tree joins them.
fn split<'a>(keys: &'a mut [u64], chunks: &mut Vec<Chunk<'a>>, top: &mut ChunkJoiner) {
    if keys.len() <= GRAIN {
        chunks.push(Chunk { keys, pairs: Vec::new(), clusters: Vec::new() });
        top.then_chunk();
        return;
    }
    let (left, right) = keys.split_at_mut(fork(keys));
    split(left, chunks, top);
    split(right, chunks, top);
    top.then_join();
}

/// What the curve needs to know about all boxes.
struct BoxSummary {
    centers: Aabb,
    /// The number of primitives whose box is not empty.
    primitives: usize,
}

impl BoxSummary {
    /// All boxes, with those that contain no point replaced by the empty one, and their summary.
    fn of(count: usize, bounds_of: &(impl Fn(u32) -> Aabb + Sync), threads: &Threads) -> (Vec<Aabb>, Self) {
        let (boxes, parts) = vec_in_chunks(count, CHUNK, threads, &|first, chunk| {
            let mut part = Self { centers: Aabb::EMPTY, primitives: 0 };
            for id in first..first + chunk.size() {
                let bounds = bounds_of(id as u32);
                let is_there = bounds.has_point();
                if is_there {
                    part.centers = part.centers.extended(bounds.center());
                    part.primitives += 1;
                }
                chunk.push(if is_there { bounds } else { Aabb::EMPTY });
            }
            part
        });
        let both =
            |a: Self, b: Self| Self { centers: a.centers.union(&b.centers), primitives: a.primitives + b.primitives };
        (boxes, parts.into_iter().fold(Self { centers: Aabb::EMPTY, primitives: 0 }, both))
    }

    /// For each primitive, its Morton code followed by its index.
    fn keys(&self, boxes: &[Aabb], primitive_bits: u32, threads: &Threads) -> Vec<u64> {
        let curve = Curve::through(&self.centers, CODE_BITS.min(64 - primitive_bits));
        if boxes.len() <= BIT_BY_BIT_LIMIT {
            return self.keys_along(boxes, primitive_bits, threads, |point| curve.code(point));
        }
        let curve = curve.tabled();
        self.keys_along(boxes, primitive_bits, threads, |point| curve.code(point))
    }

    fn keys_along(
        &self,
        boxes: &[Aabb],
        primitive_bits: u32,
        threads: &Threads,
        code: impl Fn([f32; 3]) -> u64 + Sync,
    ) -> Vec<u64> {
        let key = |id: usize| code(boxes[id].center()) << primitive_bits | id as u64;
        if self.primitives < boxes.len() {
            return (0..boxes.len()).filter(|&id| boxes[id].has_point()).map(key).collect();
        }
        let write = |first: usize, chunk: &mut ChunkWriter<'_, u64>| {
            (first..first + chunk.size()).for_each(|id| chunk.push(key(id)));
        };
        vec_in_chunks(boxes.len(), CHUNK, threads, &write).0
    }
}
