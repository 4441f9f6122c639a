//! What every subtree of a binary tree costs at least, by how many roots may stand for it.
//!
//! For every binary node and every k up to seven: what does its subtree cost at least if it may be represented by up to k roots? A single root is a leaf, or a wide
//! node whose eight slots are shared out to the two children in the best way; more roots are shared out likewise. Forming leaves is part of the recursion.
//!
//! Only what two children cost together is kept, for each number of slots that they share: half a cache line for two nodes.
//!
//! Wald, Benthin and Boulos 2008, "Getting Rid of Packets" (collapsing); the recursion after Ylitie, Karras and Laine 2017, "Efficient Incoherent
//! Ray Traversal on GPUs Through Compressed Wide BVHs".

use std::ops::Range;

use super::collapse::Costs;
use super::node::LANES;
use crate::memory::{ChunkWriter, vec_in_chunks};
use crate::simd::{Isa, Kernel, Level};
use crate::threads::Threads;
use crate::tree::{Bvh, Node, Target};

/// So many pairs are one thread's, and are done before anybody asks whether the tree is still wanted.
const CHUNK: usize = 4096;

/// For how many pairs memory is asked before they are looked at.
const PREFETCH_BATCH: usize = 8;

/// What two children cost at least.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Pair {
    /// Together, if they share 2, 3, .. 8 slots.
    shared: [f32; LANES - 1],
    primitives: PrimitiveRange,
}

const _: () = assert!(size_of::<Pair>() == 32);

impl Pair {
    const UNKNOWN: Self = Self { shared: [f32::INFINITY; LANES - 1], primitives: PrimitiveRange::UNKNOWN };
}

/// The primitives below two children, if they are few and stand together: the place of the first, and in the lower bits how many they are, less one.
#[derive(Clone, Copy, PartialEq)]
#[repr(transparent)]
struct PrimitiveRange(u32);

impl PrimitiveRange {
    const COUNT_BITS: u32 = 4;
    const MOST: u32 = 1 << Self::COUNT_BITS;
    /// Two are never one, so this is free to mean that nothing is known yet.
    const UNKNOWN: Self = Self(0);
    const TOO_MANY: Self = Self(u32::MAX);

    #[inline(always)]
    fn of(places: Option<(u32, u32)>) -> Self {
        match places {
            Some((first, count)) if count <= Self::MOST => Self(first << Self::COUNT_BITS | (count - 1)),
            _ => Self::TOO_MANY,
        }
    }

    /// The first place, and how many there are.
    #[inline(always)]
    fn places(self) -> Option<(u32, u32)> {
        (self != Self::TOO_MANY).then_some((self.0 >> Self::COUNT_BITS, (self.0 & (Self::MOST - 1)) + 1))
    }
}

/// What a subtree costs at least.
pub(super) struct Subtree {
    /// With up to 1, 2, .. 7 roots; nothing costs as much as the eighth.
    pub(super) roots: [f32; LANES],
    /// The first place and the number of its primitives, if they are few.
    places: Option<(u32, u32)>,
    /// Whether a single root is best a leaf.
    is_leaf: bool,
}

impl Subtree {
    /// The primitives of a leaf.
    pub(super) fn leaf(&self) -> Option<Range<u32>> {
        let (first, count) = self.places.filter(|_| self.is_leaf)?;
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
    /// Of a tree with nodes. When cancelled, some are not known.
    pub(super) fn of(binary: &'a Bvh, costs: &'a Costs, threads: &Threads) -> Self {
        debug_assert!(costs.item_size * costs.max_items <= PrimitiveRange::MOST as usize);
        let nodes = binary.nodes();
        let level = Level::current();
        let (pairs, open) = vec_in_chunks(nodes.len() / 2, CHUNK, threads, &|first, chunk| {
            let mut open = Vec::new();
            if threads.is_cancelled() {
                (0..chunk.size()).for_each(|_| chunk.push(Pair::UNKNOWN));
            } else {
                level.run(Fill { nodes, costs, first, chunk, open: &mut open });
                threads.advance(2 * chunk.size());
            }
            open
        });
        let mut found = Self { nodes, costs, pairs };
        // Pairs with something below them in another chunk. Promise 5: what is below comes later.
        for place in open.into_iter().flatten() {
            let pair = (found.pairs.len() - 1 - place) as u32;
            if let (Some(left), Some(right)) = (found.of_node(2 * pair + 1), found.of_node(2 * pair + 2)) {
                found.pairs[place] = together(&left, &right);
            }
        }
        found
    }

    /// Asks for the memory of what is below a node, as far as it stands together: all of it where the tree ends, as at most nodes.
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

    /// Of one node; nothing only when cancelled.
    pub(super) fn of_node(&self, node: u32) -> Option<Subtree> {
        let known = Known { pairs: &self.pairs, first: 0, count: self.pairs.len() };
        subtree(&self.nodes[node as usize], self.costs, &known)
    }
}

/// A piece of the list of pairs, as far as it has been written.
struct Known<'a> {
    pairs: &'a [Pair],
    /// The place of the first in the list, and how long the list is.
    first: usize,
    count: usize,
}

impl Known<'_> {
    /// The pair that begins with this node.
    #[inline(always)]
    fn pair(&self, node: u32) -> Option<&Pair> {
        let place = (self.count - 1).wrapping_sub(node as usize / 2);
        self.pairs.get(place.wrapping_sub(self.first)).filter(|pair| pair.primitives != PrimitiveRange::UNKNOWN)
    }
}

struct Fill<'a, 'b> {
    nodes: &'a [Node],
    costs: &'a Costs,
    first: usize,
    chunk: &'a mut ChunkWriter<'b, Pair>,
    /// The places of those that have to wait for others.
    open: &'a mut Vec<usize>,
}

impl Kernel for Fill<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, _: I) {
        let Self { nodes, costs, first, chunk, open } = self;
        let count = nodes.len() / 2;
        for place in first..first + chunk.size() {
            let pair = count - 1 - place;
            let known = Known { pairs: chunk.written(), first, count };
            let left = subtree(&nodes[2 * pair + 1], costs, &known);
            let right = subtree(&nodes[2 * pair + 2], costs, &known);
            match (left, right) {
                (Some(left), Some(right)) => chunk.push(together(&left, &right)),
                _ => {
                    chunk.push(Pair::UNKNOWN);
                    open.push(place);
                }
            }
        }
    }
}

/// What a node costs; nothing if what is below is not known.
#[inline(always)]
fn subtree(node: &Node, costs: &Costs, known: &Known<'_>) -> Option<Subtree> {
    let area = node.bounds.half_area();
    match node.link.target() {
        Target::Primitives(places) => {
            let count = places.end - places.start;
            let roots = [area * costs.of_leaf(count); LANES];
            Some(Subtree { roots, places: Some((places.start, count)), is_leaf: true })
        }
        Target::Node(first) => {
            let pair = known.pair(first)?;
            let places = pair.primitives.places();
            let as_node = area * costs.node + pair.shared[LANES - 2];
            let as_leaf = match places {
                Some((_, count)) if costs.fits_a_leaf(count) => area * costs.of_leaf(count),
                _ => f32::INFINITY,
            };
            let is_leaf = as_leaf <= as_node && as_leaf < f32::INFINITY;
            let mut roots = [if is_leaf { as_leaf } else { as_node }; LANES];
            for k in 1..LANES - 1 {
                roots[k] = lesser(pair.shared[k - 1], roots[k - 1]);
            }
            roots[LANES - 1] = roots[LANES - 2];
            Some(Subtree { roots, places, is_leaf })
        }
    }
}

/// The best ways to share 2, 3, .. 8 slots, all at once: a lane for each.
#[inline(always)]
fn together(left: &Subtree, right: &Subtree) -> Pair {
    // Who gets no slot, or more than the others leave, costs beyond measure.
    let mut shifted = [f32::INFINITY; 3 * LANES];
    shifted[LANES..2 * LANES - 1].copy_from_slice(&right.roots[..LANES - 1]);
    let mut best = [f32::INFINITY; LANES];
    for to_left in 1..LANES {
        let others = &shifted[LANES + 1 - to_left..][..LANES];
        for lane in 0..LANES {
            best[lane] = lesser(left.roots[to_left - 1] + others[lane], best[lane]);
        }
    }
    let mut shared = [0.0; LANES - 1];
    shared.copy_from_slice(&best[..LANES - 1]);
    let below = match (left.places, right.places) {
        (Some((first, count)), Some((next, more))) if first + count == next => Some((first, count + more)),
        _ => None,
    };
    Pair { shared, primitives: PrimitiveRange::of(below) }
}

/// The second one if either is no number.
#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build;
    use crate::geometry::Aabb;
    use crate::wide::mesh_bvh::COSTS;

    /// The same by the definition: what a subtree costs with up to so many roots, and how many primitives it has.
    fn by_trying(binary: &Bvh, node: u32, roots: usize) -> (f32, u32) {
        let Node { bounds, link } = binary.nodes()[node as usize];
        let as_leaf = |count| bounds.half_area() * COSTS.of_leaf(count);
        match link.target() {
            Target::Primitives(places) => (as_leaf(places.len() as u32), places.len() as u32),
            Target::Node(first) => {
                let count = by_trying(binary, first, 1).1 + by_trying(binary, first + 1, 1).1;
                let shared = |slots: usize| {
                    let costs = (1..slots).map(|to_left| {
                        by_trying(binary, first, to_left.min(7)).0
                            + by_trying(binary, first + 1, (slots - to_left).min(7)).0
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
                    assert_eq!(found.roots[roots - 1], by_trying(&binary, node, roots).0, "{count}, {node}, {roots}");
                }
            }
        }
    }
}
