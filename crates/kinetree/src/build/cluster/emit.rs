//! From merged clusters to a tree: nodes in depth-first order, primitives in the order of the leaves, paths bounded.
//!
//! Pairs lie in the order in which they were made, and on the whole what is further right was made later. So the walk goes from right to left: then it reads them
//! backwards, nearly one after the other.

use super::pair::{Half, Pair, half};
use crate::geometry::Aabb;
use crate::simd::{Isa, Kernel, Level};
use crate::tree::{Link, MAX_DEPTH, Node};

/// What stands below one node, about to be written.
pub(super) struct Subtree<'a> {
    pub(super) pairs: &'a [Pair],
    pub(super) chains: &'a [u64],
    /// All nodes below, and the number of the first of them.
    pub(super) below: &'a mut [Node],
    pub(super) below_at: u32,
    /// All primitives, and the place of the first of them.
    pub(super) primitives: &'a mut [u32],
    pub(super) first_place: u32,
}

/// Half of a pair.
#[derive(Clone, Copy)]
pub(super) struct Top {
    pub(super) bounds: Aabb,
    pub(super) link: u32,
    /// Nodes on the longest path from here.
    pub(super) height: u32,
}

impl Top {
    fn halves(pair: &Pair) -> [Self; 2] {
        [0, 1].map(|half| Self { bounds: pair.bounds[half], link: pair.links[half], height: pair.heights[half] })
    }
}

/// The number of nodes on the longest path of a balanced tree.
pub(super) fn balanced_height(leaves: usize) -> usize {
    leaves.next_power_of_two().ilog2() as usize + 1
}

impl Subtree<'_> {
    /// Writes what is below `top`, which is the `depth`th node of its path, and gives its own node.
    pub(super) fn write(self, level: Level, top: Top, depth: usize) -> Node {
        level.run(Write { subtree: self, top, depth })
    }
}

struct Write<'a> {
    subtree: Subtree<'a>,
    top: Top,
    depth: usize,
}

impl Kernel for Write<'_> {
    type Output = Node;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Node {
        let to_place = self.subtree.primitives.len();
        Writer { isa, nodes: 0, to_place, subtree: self.subtree }.write(self.top, self.depth)
    }
}

struct Writer<'a, I> {
    isa: I,
    subtree: Subtree<'a>,
    nodes: usize,
    /// Primitives that have no place yet: the first ones.
    to_place: usize,
}

/// How far ahead pairs are asked for.
const AHEAD: usize = 16;

impl<I: Isa> Writer<'_, I> {
    fn write(&mut self, top: Top, depth: usize) -> Node {
        match half(top.link) {
            Half::Leaf { place, count } => self.write_leaf(&top.bounds, place, count),
            Half::Pair(pair) => {
                let halves = Top::halves(&self.subtree.pairs[pair]);
                self.isa.prefetch(self.subtree.pairs, pair.saturating_sub(AHEAD));
                if let Half::Pair(left) = half(halves[0].link) {
                    self.isa.prefetch(self.subtree.pairs, left);
                }
                if depth + top.height as usize > MAX_DEPTH + 1 && !halves.iter().all(|half| self.has_room(half, depth))
                {
                    let mut leaves = Vec::new();
                    self.leaves_below(&top, &mut leaves);
                    return self.write_balanced(&leaves);
                }
                let first = self.two_nodes();
                for at in [1, 0] {
                    self.subtree.below[first + at] = self.write(halves[at], depth + 1);
                }
                Node { bounds: top.bounds, link: self.link_to(first) }
            }
        }
    }

    /// Whether a child of the `depth`th node of a path can keep promise 6, if it is rebuilt.
    fn has_room(&self, child: &Top, depth: usize) -> bool {
        let mut leaves = Vec::new();
        self.leaves_below(child, &mut leaves);
        depth + balanced_height(leaves.len()) <= MAX_DEPTH
    }

    /// The leaves below, from left to right.
    fn leaves_below(&self, top: &Top, leaves: &mut Vec<Top>) {
        let mut pending = vec![*top];
        while let Some(next) = pending.pop() {
            match half(next.link) {
                Half::Leaf { .. } => leaves.push(next),
                Half::Pair(pair) => pending.extend(Top::halves(&self.subtree.pairs[pair]).into_iter().rev()),
            }
        }
    }

    /// Splits at the middle until one is left. The recursion is as deep as the tree it makes.
    fn write_balanced(&mut self, leaves: &[Top]) -> Node {
        if let [leaf] = leaves
            && let Half::Leaf { place, count } = half(leaf.link)
        {
            return self.write_leaf(&leaf.bounds, place, count);
        }
        let first = self.two_nodes();
        let (left, right) = leaves.split_at(leaves.len().div_ceil(2));
        let right = self.write_balanced(right);
        let pair = [self.write_balanced(left), right];
        self.subtree.below[first..first + 2].copy_from_slice(&pair);
        Node { bounds: pair[0].bounds.union(&pair[1].bounds), link: self.link_to(first) }
    }

    fn write_leaf(&mut self, bounds: &Aabb, mut place: usize, count: usize) -> Node {
        let end = self.to_place;
        self.to_place -= count;
        for primitive in &mut self.subtree.primitives[self.to_place..end] {
            let chain = self.subtree.chains[place];
            *primitive = chain as u32;
            place = (chain >> 32) as usize;
        }
        let first = self.subtree.first_place;
        let range = first + self.to_place as u32..first + end as u32;
        Node { bounds: *bounds, link: Link::primitives(range) }
    }

    /// Room for two children: where the first stands among the nodes below.
    fn two_nodes(&mut self) -> usize {
        self.nodes += 2;
        self.nodes - 2
    }

    fn link_to(&self, first: usize) -> Link {
        Link::node(self.subtree.below_at + first as u32)
    }
}
