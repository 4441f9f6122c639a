//! The minimum cost of every subtree of a binary tree after collapsing, by dynamic programming.
//!
//! For every binary node and every k up to seven: the minimum cost of its subtree as a forest of at
//! most k wide nodes or leaves. For k = 1 that is a leaf, or a wide node whose eight slots are
//! distributed to the two children in the best way; for larger k, the k slots are distributed
//! likewise. Forming leaves is part of the recursion.
//!
//! Only the joint cost of two siblings is stored, for each number of slots that they share: 32
//! bytes per pair.
//!
//! Wald, Benthin and Boulos 2008, "Getting Rid of Packets" (collapsing); the recursion after
//! Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed
//! Wide BVHs".

use std::ops::Range;

use super::costs::Costs;
use super::node::LANES;
use crate::geometry::fast_min;
use crate::memory::{ChunkWriter, vec_in_chunks};
use crate::simd::{Isa, Kernel, Level};
use crate::threads::Threads;
use crate::tree::{Bvh, Node, Target};

/// Pairs per parallel task, and between checks for cancellation.
const CHUNK: usize = 4096;

/// The number of pairs to prefetch below a node.
const PREFETCH_BATCH: usize = 8;

/// The minimum costs of two siblings.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Pair {
    /// The minimum joint cost if they share 2, 3, .. 8 slots.
    shared: [f32; LANES - 1],
    primitives: PrimitiveRange,
}

const _: () = assert!(size_of::<Pair>() == 32);

impl Pair {
    const UNKNOWN: Self = Self { shared: [f32::INFINITY; LANES - 1], primitives: PrimitiveRange::UNKNOWN };
}

/// The primitives below two siblings, if they are few and contiguous: the index of the first, and
/// in the lowest four bits their number minus one.
#[derive(Clone, Copy, PartialEq)]
#[repr(transparent)]
struct PrimitiveRange(u32);

impl PrimitiveRange {
    const COUNT_BITS: u32 = 4;
    const MAX_COUNT: u32 = 1 << Self::COUNT_BITS;
    /// The value for a single primitive, which no pair has, marks a pair that is not computed yet.
    const UNKNOWN: Self = Self(0);
    const TOO_MANY: Self = Self(u32::MAX);

    #[inline(always)]
    fn of(range: Option<(u32, u32)>) -> Self {
        match range {
            Some((first, count)) if count <= Self::MAX_COUNT => Self(first << Self::COUNT_BITS | (count - 1)),
            _ => Self::TOO_MANY,
        }
    }

    /// The index of the first, and their number.
    #[inline(always)]
    fn range(self) -> Option<(u32, u32)> {
        (self != Self::TOO_MANY).then_some((self.0 >> Self::COUNT_BITS, (self.0 & (Self::MAX_COUNT - 1)) + 1))
    }
}

/// The minimum costs of a subtree.
pub(super) struct Subtree {
    /// With at most 1, 2, .. 7 roots. The eighth entry repeats the seventh.
    pub(super) roots: [f32; LANES],
    /// The index of the first and the number of its primitives, if they are few and contiguous.
    range: Option<(u32, u32)>,
    /// Whether the minimum for a single root is a leaf.
    is_leaf: bool,
}

impl Subtree {
    /// The primitives of a leaf.
    pub(super) fn leaf(&self) -> Option<Range<u32>> {
        let (first, count) = self.range.filter(|_| self.is_leaf)?;
        Some(first..first + count)
    }
}

pub(super) struct CollapseCosts<'a> {
    nodes: &'a [Node],
    costs: &'a Costs,
    /// Nodes 2i + 1 and 2i + 2 are pair i, by promise 7 of [`Bvh`]. The last pair comes first.
    pairs: Vec<Pair>,
}

impl<'a> CollapseCosts<'a> {
    /// Computes the costs of a non-empty tree. When cancelled, some are missing.
    pub(super) fn of(binary: &'a Bvh, costs: &'a Costs, threads: &Threads) -> Self {
        debug_assert!(costs.item_size * costs.max_items <= PrimitiveRange::MAX_COUNT as usize);
        let nodes = binary.nodes();
        let level = Level::current();
        let (pairs, deferred) = vec_in_chunks(nodes.len() / 2, CHUNK, threads, &|first, chunk| {
            let mut deferred = Vec::new();
            if threads.is_cancelled() {
                (0..chunk.size()).for_each(|_| chunk.push(Pair::UNKNOWN));
            } else {
                level.run(Fill { nodes, costs, first, chunk, deferred: &mut deferred });
                threads.advance(2 * chunk.size());
            }
            deferred
        });
        let mut found = Self { nodes, costs, pairs };
        // Pairs with descendants in other chunks. By promise 5, descendants have later indices.
        for index in deferred.into_iter().flatten() {
            let pair = (found.pairs.len() - 1 - index) as u32;
            if let (Some(left), Some(right)) = (found.of_node(2 * pair + 1), found.of_node(2 * pair + 2)) {
                found.pairs[index] = joint_costs(&left, &right);
            }
        }
        found
    }

    /// Prefetches the nodes and pairs below a node, as far as they are contiguous: for small
    /// subtrees, as below most nodes, that is all.
    #[inline(always)]
    pub(super) fn prefetch(&self, isa: impl Isa, node: u32) {
        if let Target::Node(first) = self.nodes[node as usize].link.target() {
            let last = self.pairs.len().wrapping_sub(1 + first as usize / 2);
            for pair in 0..PREFETCH_BATCH {
                isa.prefetch(self.nodes, first as usize + 2 * pair);
            }
            for pair in (0..PREFETCH_BATCH).step_by(2) {
                isa.prefetch(&self.pairs, last.wrapping_sub(pair));
            }
        }
    }

    /// The costs of a node; `None` only when cancelled.
    pub(super) fn of_node(&self, node: u32) -> Option<Subtree> {
        let known = Known { pairs: &self.pairs, first: 0, count: self.pairs.len() };
        subtree(&self.nodes[node as usize], self.costs, &known)
    }
}

/// The part of the list of pairs that has been computed.
struct Known<'a> {
    pairs: &'a [Pair],
    /// The index of its first entry in the list, and the length of the list.
    first: usize,
    count: usize,
}

impl Known<'_> {
    /// The pair whose first node is `node`.
    #[inline(always)]
    fn pair(&self, node: u32) -> Option<&Pair> {
        let index = (self.count - 1).wrapping_sub(node as usize / 2);
        self.pairs.get(index.wrapping_sub(self.first)).filter(|pair| pair.primitives != PrimitiveRange::UNKNOWN)
    }
}

struct Fill<'a, 'b> {
    nodes: &'a [Node],
    costs: &'a Costs,
    first: usize,
    chunk: &'a mut ChunkWriter<'b, Pair>,
    /// The indices of pairs that depend on other chunks.
    deferred: &'a mut Vec<usize>,
}

impl Kernel for Fill<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, _: I) {
        let Self { nodes, costs, first, chunk, deferred } = self;
        let count = nodes.len() / 2;
        for index in first..first + chunk.size() {
            let pair = count - 1 - index;
            let known = Known { pairs: chunk.written(), first, count };
            let left = subtree(&nodes[2 * pair + 1], costs, &known);
            let right = subtree(&nodes[2 * pair + 2], costs, &known);
            match (left, right) {
                (Some(left), Some(right)) => chunk.push(joint_costs(&left, &right)),
                _ => {
                    chunk.push(Pair::UNKNOWN);
                    deferred.push(index);
                }
            }
        }
    }
}

/// The costs of a node; `None` if those of its children are not computed.
#[inline(always)]
fn subtree(node: &Node, costs: &Costs, known: &Known<'_>) -> Option<Subtree> {
    let area = node.bounds.half_area();
    match node.link.target() {
        Target::Primitives(range) => {
            let count = range.end - range.start;
            let roots = [area * costs.of_leaf(count); LANES];
            Some(Subtree { roots, range: Some((range.start, count)), is_leaf: true })
        }
        Target::Node(first) => {
            let pair = known.pair(first)?;
            let range = pair.primitives.range();
            let as_node = area * costs.node + pair.shared[LANES - 2];
            let as_leaf = match range {
                Some((_, count)) if costs.fits_a_leaf(count) => area * costs.of_leaf(count),
                _ => f32::INFINITY,
            };
            let is_leaf = as_leaf <= as_node && as_leaf < f32::INFINITY;
            let mut roots = [if is_leaf { as_leaf } else { as_node }; LANES];
            for k in 1..LANES - 1 {
                roots[k] = fast_min(pair.shared[k - 1], roots[k - 1]);
            }
            roots[LANES - 1] = roots[LANES - 2];
            Some(Subtree { roots, range, is_leaf })
        }
    }
}

/// The best distributions of 2, 3, .. 8 slots to two siblings, one per SIMD lane.
#[inline(always)]
fn joint_costs(left: &Subtree, right: &Subtree) -> Pair {
    // A sibling without a slot, or with more than are left, has infinite cost.
    let mut shifted = [f32::INFINITY; 3 * LANES];
    shifted[LANES..2 * LANES - 1].copy_from_slice(&right.roots[..LANES - 1]);
    let mut best = [f32::INFINITY; LANES];
    for to_left in 1..LANES {
        let others = &shifted[LANES + 1 - to_left..][..LANES];
        for lane in 0..LANES {
            best[lane] = fast_min(left.roots[to_left - 1] + others[lane], best[lane]);
        }
    }
    let mut shared = [0.0; LANES - 1];
    shared.copy_from_slice(&best[..LANES - 1]);
    let below = match (left.range, right.range) {
        (Some((first, count)), Some((next, more))) if first + count == next => Some((first, count + more)),
        _ => None,
    };
    Pair { shared, primitives: PrimitiveRange::of(below) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build;
    use crate::geometry::Aabb;

    const COSTS: Costs = Costs::TRIANGLES;

    /// The slow twin: the cost of a subtree with at most `roots` roots, by its definition, and its
    /// number of primitives.
    fn naive_costs(binary: &Bvh, node: u32, roots: usize) -> (f32, u32) {
        let Node { bounds, link } = binary.nodes()[node as usize];
        let as_leaf = |count| bounds.half_area() * COSTS.of_leaf(count);
        match link.target() {
            Target::Primitives(range) => (as_leaf(range.len() as u32), range.len() as u32),
            Target::Node(first) => {
                let count = naive_costs(binary, first, 1).1 + naive_costs(binary, first + 1, 1).1;
                let shared = |slots: usize| {
                    let costs = (1..slots).map(|to_left| {
                        naive_costs(binary, first, to_left.min(7)).0
                            + naive_costs(binary, first + 1, (slots - to_left).min(7)).0
                    });
                    costs.fold(f32::INFINITY, f32::min)
                };
                let mut least = bounds.half_area() * COSTS.node + shared(LANES);
                if COSTS.fits_a_leaf(count) {
                    least = least.min(as_leaf(count));
                }
                ((2..=roots).map(shared).fold(least, f32::min), count)
            }
        }
    }

    #[test]
    fn what_is_found_for_all_slots_at_once_is_what_trying_finds() {
        for count in [1_u32, 2, 3, 5, 8, 11] {
            let at = |i: u32| [i % 3, i * i % 7, i * 5 % 11].map(|x| x as f32);
            let bounds_of = |i: u32| Aabb::new(at(i), at(i).map(|x| x + 1.0 + i as f32 * 0.1));
            let binary = build::build_clustered(count as usize, bounds_of, &build::BuildOptions::default());
            let collapse_costs = CollapseCosts::of(&binary, &COSTS, &Threads::one());
            for node in 0..binary.node_count() as u32 {
                let found = collapse_costs.of_node(node).expect("nothing cancels");
                for roots in 1..LANES {
                    assert_eq!(found.roots[roots - 1], naive_costs(&binary, node, roots).0, "{count}, {node}, {roots}");
                }
            }
        }
    }
}
