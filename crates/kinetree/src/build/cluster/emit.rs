//! Writing a tree of merged clusters: nodes in depth-first order, primitives in the order of the
//! leaves, paths bounded.
//!
//! Pairs are in the order in which they were merged, mostly from left to right. So the tree is
//! written from right to left, which reads the pairs backwards, nearly sequentially.

use super::pair::{Half, Pair, half};
use crate::geometry::Aabb;
use crate::simd::{Isa, Kernel, Level};
use crate::tree::{Link, MAX_DEPTH, Node};

/// The output of the subtree below one node.
pub(super) struct Subtree<'a> {
    pub(super) pairs: &'a [Pair],
    pub(super) chains: &'a [u64],
    /// The nodes below, and the index of the first.
    pub(super) below: &'a mut [Node],
    pub(super) below_at: u32,
    /// The primitives, and the index of the first.
    pub(super) primitives: &'a mut [u32],
    pub(super) primitives_at: u32,
}

/// One child of a pair: the root of a subtree to be written.
#[derive(Clone, Copy)]
pub(super) struct SubtreeRoot {
    pub(super) bounds: Aabb,
    pub(super) link: u32,
    /// The number of nodes on the longest path from here.
    pub(super) height: u32,
}

impl SubtreeRoot {
    fn halves(pair: &Pair) -> [Self; 2] {
        [0, 1].map(|half| Self { bounds: pair.bounds[half], link: pair.links[half], height: pair.heights[half] })
    }
}

/// The number of nodes on the longest path of a balanced tree.
pub(super) fn balanced_height(leaves: usize) -> usize {
    leaves.next_power_of_two().ilog2() as usize + 1
}

impl Subtree<'_> {
    /// Writes all nodes below `root`, which is at depth `depth` (1 for the root), and returns its
    /// own node.
    pub(super) fn write(self, level: Level, root: SubtreeRoot, depth: usize) -> Node {
        level.run(Write { subtree: self, root, depth })
    }
}

struct Write<'a> {
    subtree: Subtree<'a>,
    root: SubtreeRoot,
    depth: usize,
}

impl Kernel for Write<'_> {
    type Output = Node;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Node {
        let to_place = self.subtree.primitives.len();
        Writer { isa, nodes: 0, to_place, subtree: self.subtree }.write(self.root, self.depth)
    }
}

struct Writer<'a, I> {
    isa: I,
    subtree: Subtree<'a>,
    nodes: usize,
    /// The number of primitives that are not written yet; they are written from the last to the
    /// first.
    to_place: usize,
}

/// The prefetch distance for pairs.
const PREFETCH_DISTANCE: usize = 16;

impl<I: Isa> Writer<'_, I> {
    fn write(&mut self, root: SubtreeRoot, depth: usize) -> Node {
        match half(root.link) {
            Half::Leaf { index, count } => self.write_leaf(&root.bounds, index, count),
            Half::Pair(pair) => {
                let halves = SubtreeRoot::halves(&self.subtree.pairs[pair]);
                self.isa.prefetch(self.subtree.pairs, pair.saturating_sub(PREFETCH_DISTANCE));
                if let Half::Pair(left) = half(halves[0].link) {
                    self.isa.prefetch(self.subtree.pairs, left);
                }
                if depth + root.height as usize > MAX_DEPTH + 1 && !halves.iter().all(|half| self.fits(half, depth)) {
                    let mut leaves = Vec::new();
                    self.leaves_below(&root, &mut leaves);
                    return self.write_balanced(&leaves);
                }
                let first = self.two_nodes();
                for at in [1, 0] {
                    self.subtree.below[first + at] = self.write(halves[at], depth + 1);
                }
                Node { bounds: root.bounds, link: self.link_to(first) }
            }
        }
    }

    /// Whether a child of a node at this depth fits the depth limit (promise 6) if it is
    /// rebalanced.
    fn fits(&self, child: &SubtreeRoot, depth: usize) -> bool {
        let mut leaves = Vec::new();
        self.leaves_below(child, &mut leaves);
        depth + balanced_height(leaves.len()) <= MAX_DEPTH
    }

    /// Appends the leaves below, from left to right.
    fn leaves_below(&self, root: &SubtreeRoot, leaves: &mut Vec<SubtreeRoot>) {
        let mut pending = vec![*root];
        while let Some(next) = pending.pop() {
            match half(next.link) {
                Half::Leaf { .. } => leaves.push(next),
                Half::Pair(pair) => pending.extend(SubtreeRoot::halves(&self.subtree.pairs[pair]).into_iter().rev()),
            }
        }
    }

    /// Writes a balanced tree over the leaves. The recursion is as deep as the tree.
    fn write_balanced(&mut self, leaves: &[SubtreeRoot]) -> Node {
        if let [leaf] = leaves
            && let Half::Leaf { index, count } = half(leaf.link)
        {
            return self.write_leaf(&leaf.bounds, index, count);
        }
        let first = self.two_nodes();
        let (left, right) = leaves.split_at(leaves.len().div_ceil(2));
        let right = self.write_balanced(right);
        let pair = [self.write_balanced(left), right];
        self.subtree.below[first..first + 2].copy_from_slice(&pair);
        Node { bounds: pair[0].bounds.union(&pair[1].bounds), link: self.link_to(first) }
    }

    fn write_leaf(&mut self, bounds: &Aabb, mut index: usize, count: usize) -> Node {
        let end = self.to_place;
        self.to_place -= count;
        for primitive in &mut self.subtree.primitives[self.to_place..end] {
            let chain = self.subtree.chains[index];
            *primitive = chain as u32;
            index = (chain >> 32) as usize;
        }
        let first = self.subtree.primitives_at;
        let range = first + self.to_place as u32..first + end as u32;
        Node { bounds: *bounds, link: Link::primitives(range) }
    }

    /// Allocates two children and returns the index of the first among the nodes below.
    fn two_nodes(&mut self) -> usize {
        self.nodes += 2;
        self.nodes - 2
    }

    fn link_to(&self, first: usize) -> Link {
        Link::node(self.subtree.below_at + first as u32)
    }
}
