//! Insertion-based optimization: subtrees are removed and reinserted where they cost least.
//!
//! The largest nodes, which most rays visit, search for a better position: away from their sibling,
//! and beside any other node of the tree. The area that a move saves follows from the boxes on the
//! path up and down, and a branch-and-bound search prunes subtrees that cannot beat the best
//! position so far. All searches of a batch read the same tree, in parallel; then the moves are
//! applied, best first, except those that touch nodes which an earlier move has changed.
//!
//! Bittner, Hapala and Havran 2013, "Fast Insertion-Based Optimization of Bounding Volume
//! Hierarchies"; in parallel after Meister and Bittner 2018, "Parallel Reinsertion for Bounding
//! Volume Hierarchy Optimization".

use super::fast_box::FastBox;
use super::reference::GRAIN;
use crate::geometry::Aabb;
use crate::memory::{vec_in_chunks, vec_in_large_pages};
use crate::threads::Threads;
use crate::tree::{Bvh, Link, MAX_DEPTH, Node, Target};

/// Nodes are of the same size class if their areas agree but for this many low bits: sign, exponent
/// and seven bits of the mantissa are left.
const CLASS_SHIFT: u32 = 16;

/// Searches per parallel task.
const SEARCH_GRAIN: usize = 64;

/// Reduces the total area of the inner nodes, keeping the leaves. `batches` holds, for each batch,
/// the largest fraction of all nodes that may move. The result does not depend on the number of
/// threads.
pub(crate) fn reinsert(bvh: Bvh, batches: &[f32], threads: &Threads) -> Bvh {
    let finite = bvh.bounds().half_area().is_finite();
    if bvh.node_count() < 5 || !finite {
        return bvh;
    }
    let mut tree = ParentedTree::of(bvh);
    let mut undo = Vec::with_capacity(batches.len());
    threads.begin_stage(0.8, (tree.nodes.len() as f32 * batches.iter().sum::<f32>()) as usize);
    for fraction in batches {
        if threads.is_cancelled() {
            break;
        }
        let moves = tree.search((tree.nodes.len() as f32 * fraction) as usize, threads);
        let result = tree.apply(&moves);
        let helps = result.saved > 0.0;
        undo.push(result.undo);
        if !helps {
            tree.roll_back(undo.pop().unwrap_or_default());
            break;
        }
    }
    loop {
        match (tree.in_depth_first_order(), undo.pop()) {
            (Some((nodes, primitives)), _) => return Bvh::from_parts(nodes, primitives, tree.distinct),
            (None, Some(before)) => tree.roll_back(before),
            (None, None) => unreachable!("the tree that was given keeps promise 6"),
        }
    }
}

/// A tree whose nodes are in no particular order, with parent links. The two children of a node are
/// adjacent, the first at an odd index (promise 7 of [`Bvh`]).
struct ParentedTree {
    nodes: Vec<Node>,
    parents: Vec<u32>,
    primitives: Vec<u32>,
    distinct: u32,
}

/// Removes node `from` and reinserts it as the sibling of node `to`.
#[derive(Clone, Copy)]
struct Move {
    from: u32,
    to: u32,
    /// The decrease of the total half area of the inner nodes.
    gain: f32,
}

/// The search for the best position of a node.
struct Search<'a> {
    nodes: &'a [Node],
    bounds: FastBox,
    own_area: f32,
    best: Move,
    /// Pairs of children to search, by the first child, with the gain if no box from their parent
    /// on grows.
    open: Vec<(f32, u32)>,
}

impl<'a> Search<'a> {
    fn of(tree: &'a ParentedTree, from: u32) -> Self {
        let bounds = FastBox::from(tree.bounds(from));
        let best = Move { from, to: 0, gain: 0.0 };
        Self { nodes: &tree.nodes, own_area: bounds.half_area(), bounds, best, open: Vec::with_capacity(64) }
    }

    /// Searches the subtree of a node, where `gain` is the gain on the path above it.
    fn below(&mut self, at: u32, gain: f32) {
        if !self.may_beat(gain) {
            return;
        }
        let first = self.beside(at, gain);
        self.open.extend(first);
        while let Some((gain, first)) = self.open.pop() {
            if self.may_beat(gain) {
                let both = [self.beside(first, gain), self.beside(first + 1, gain)];
                // The one with the larger gain goes on top of the stack.
                let [next, later] = match both {
                    [Some(one), Some(other)] if one.0 < other.0 => [Some(other), Some(one)],
                    both => both,
                };
                for (gain, first) in later.into_iter().chain(next) {
                    if self.may_beat(gain) {
                        self.open.push((gain, first));
                    }
                }
            }
        }
    }

    /// Whether a position below can be better than the best so far, if no box there grows.
    #[inline(always)]
    fn may_beat(&self, gain: f32) -> bool {
        gain - self.own_area > self.best.gain
    }

    /// Tries a position. Returns the entry for the children, if there are any.
    #[inline(always)]
    fn beside(&mut self, at: u32, gain: f32) -> Option<(f32, u32)> {
        let target = &self.nodes[at as usize];
        let bounds = FastBox::from(&target.bounds);
        let left = gain - bounds.union(&self.bounds).half_area();
        if left > self.best.gain {
            self.best = Move { to: at, gain: left, ..self.best };
        }
        match target.link.target() {
            // For positions further down, this node only grows.
            Target::Node(first) => Some((left + bounds.half_area(), first)),
            Target::Primitives(_) => None,
        }
    }
}

/// The result of a batch.
struct BatchResult {
    /// The decrease of the total half area of the inner nodes in this batch.
    saved: f64,
    /// The nodes that were overwritten.
    undo: UndoLog,
}

/// The previous values of nodes, in the order in which they were overwritten.
type UndoLog = Vec<(u32, Node)>;

impl ParentedTree {
    fn of(bvh: Bvh) -> Self {
        let (nodes, primitives, distinct) = bvh.into_parts();
        let mut parents = vec_in_large_pages(nodes.len());
        parents.resize(nodes.len(), 0);
        let mut tree = Self { nodes, parents, primitives, distinct };
        for at in 0..tree.nodes.len() {
            tree.adopt(at as u32);
        }
        tree
    }

    /// Sets the parent links of the children of a node.
    #[inline]
    fn adopt(&mut self, parent: u32) {
        if let Target::Node(first) = self.nodes[parent as usize].link.target() {
            self.parents[first as usize] = parent;
            self.parents[first as usize + 1] = parent;
        }
    }

    #[inline]
    fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    #[inline]
    fn parent(&self, node: u32) -> u32 {
        self.parents[node as usize]
    }

    /// The other child of the same parent: by promise 7, the first of a pair has an odd index.
    #[inline]
    fn sibling(&self, node: u32) -> u32 {
        ((node + 1) ^ 1) - 1
    }

    /// The best moves of the `count` largest nodes, best first.
    fn search(&self, count: usize, threads: &Threads) -> Vec<Move> {
        let mut moves: Vec<Move> =
            self.largest(count, threads).into_iter().map(|from| Move { from, to: 0, gain: 0.0 }).collect();
        threads.for_each(&mut moves, SEARCH_GRAIN, &|number, candidate| {
            if threads.is_cancelled() {
                return;
            }
            if number % SEARCH_GRAIN == 0 {
                threads.advance(SEARCH_GRAIN);
            }
            *candidate = self.best_move(candidate.from);
        });
        moves.retain(|candidate| candidate.gain > 0.0);
        moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.from.cmp(&b.from)));
        moves
    }

    /// The largest nodes except the root; of the last size class, those with smaller indices.
    fn largest(&self, count: usize, threads: &Threads) -> Vec<u32> {
        let below_root = &self.nodes[1..];
        // The bits of non-negative floats are ordered as the floats are.
        let class = |node: &Node| (node.bounds.half_area().abs().to_bits() >> CLASS_SHIFT) as u16;
        let (classes, _) = vec_in_chunks(below_root.len(), GRAIN, threads, &|first, chunk| {
            below_root[first..first + chunk.size()].iter().for_each(|node| chunk.push(class(node)));
        });
        let count = count.clamp(1, below_root.len());
        let mut sizes = vec![0_u32; 1 << (32 - CLASS_SHIFT)];
        classes.iter().for_each(|&class| sizes[usize::from(class)] += 1);
        let (mut last, mut left) = (sizes.len() - 1, count);
        while sizes[last] as usize <= left && last > 0 {
            left -= sizes[last] as usize;
            last -= 1;
        }
        let mut largest = Vec::with_capacity(count);
        for (number, class) in (1..).zip(classes) {
            let class = usize::from(class);
            let fits = class == last && left > 0;
            left -= usize::from(fits);
            if class > last || fits {
                largest.push(number);
            }
        }
        largest
    }

    fn best_move(&self, from: u32) -> Move {
        let mut search = Search::of(self, from);
        let parent = self.parent(from);
        // Removing the node removes its parent and shrinks the other ancestors: `saved` is that
        // area up to the pivot.
        let mut saved = self.bounds(parent).half_area();
        let mut sibling = self.sibling(from);
        let mut shrunk = *self.bounds(sibling);
        let mut pivot = parent;
        loop {
            search.below(sibling, saved);
            if pivot == 0 {
                break;
            }
            if pivot != parent {
                shrunk = shrunk.union(self.bounds(sibling));
                saved += self.bounds(pivot).half_area() - shrunk.half_area();
            }
            sibling = self.sibling(pivot);
            pivot = self.parent(pivot);
        }
        let best = search.best;
        if best.to == self.sibling(from) { Move { from, to: 0, gain: 0.0 } } else { best }
    }

    /// Applies the moves in order, except those that touch nodes which earlier moves have changed.
    fn apply(&mut self, moves: &[Move]) -> BatchResult {
        let mut touched = vec![false; self.nodes.len()];
        let mut result = BatchResult { saved: 0.0, undo: Vec::new() };
        for candidate in moves {
            let involved = [
                candidate.to,
                candidate.from,
                self.sibling(candidate.from),
                self.parent(candidate.to),
                self.parent(candidate.from),
            ];
            if involved.iter().any(|&node| touched[node as usize]) {
                continue;
            }
            involved.iter().for_each(|&node| touched[node as usize] = true);
            self.apply_one(candidate, &mut result);
        }
        result
    }

    fn apply_one(&mut self, candidate: &Move, result: &mut BatchResult) {
        let (sibling, parent) = (self.sibling(candidate.from), self.parent(candidate.from));
        let pair = candidate.from.min(sibling);
        for node in [parent, candidate.to, sibling] {
            result.undo.push((node, self.nodes[node as usize]));
        }
        // Before boxes are refitted, the parent is removed and a node with the target's box is
        // added.
        result.saved += f64::from(self.bounds(parent).half_area()) - f64::from(self.bounds(candidate.to).half_area());
        let (moved, kept) = (self.nodes[candidate.to as usize], self.nodes[sibling as usize]);
        self.nodes[candidate.to as usize].link = Link::node(pair);
        self.nodes[sibling as usize] = moved;
        self.nodes[parent as usize] = kept;
        [candidate.to, sibling, parent].into_iter().for_each(|node| self.adopt(node));
        for start in [candidate.to, parent] {
            self.refit_from(start, result);
        }
    }

    fn refit_from(&mut self, mut at: u32, result: &mut BatchResult) {
        loop {
            if let Target::Node(first) = self.nodes[at as usize].link.target() {
                let bounds = self.bounds(first).union(self.bounds(first + 1));
                if bounds != *self.bounds(at) {
                    result.undo.push((at, self.nodes[at as usize]));
                    result.saved += f64::from(self.bounds(at).half_area()) - f64::from(bounds.half_area());
                    self.nodes[at as usize].bounds = bounds;
                }
            }
            if at == 0 {
                return;
            }
            at = self.parent(at);
        }
    }

    fn roll_back(&mut self, undo: UndoLog) {
        for &(node, before) in undo.iter().rev() {
            self.nodes[node as usize] = before;
        }
        for (node, _) in undo {
            self.adopt(node);
        }
    }

    /// The nodes in depth-first order, as from a builder: parents before children, primitives in
    /// the order of the leaves. `None` if a path is too long.
    fn in_depth_first_order(&self) -> Option<(Vec<Node>, Vec<u32>)> {
        let mut nodes: Vec<Node> = vec_in_large_pages(self.nodes.len());
        let mut primitives = vec_in_large_pages(self.primitives.len());
        primitives.resize(self.primitives.len(), 0);
        // The part of `primitives` that is not written yet.
        let (mut start, mut end) = (0, primitives.len());
        // In the direction in which the tree was written, so that it is read sequentially.
        let leftwards = self.was_written_leftwards();
        nodes.push(self.nodes[0]);
        let mut open = vec![(0_usize, 1_usize)];
        while let Some((at, depth)) = open.pop() {
            if depth > MAX_DEPTH {
                return None;
            }
            match nodes[at].link.target() {
                Target::Node(first) => {
                    let pair = nodes.len();
                    nodes.extend_from_slice(&self.nodes[first as usize..first as usize + 2]);
                    nodes[at].link = Link::node(pair as u32);
                    let (next, later) = if leftwards { (pair + 1, pair) } else { (pair, pair + 1) };
                    open.extend([(later, depth + 1), (next, depth + 1)]);
                }
                Target::Primitives(range) => {
                    let count = range.len();
                    let first = if leftwards { end - count } else { start };
                    primitives[first..first + count]
                        .copy_from_slice(&self.primitives[range.start as usize..range.end as usize]);
                    nodes[at].link = Link::primitives(first as u32..(first + count) as u32);
                    if leftwards { end -= count } else { start += count }
                }
            }
        }
        Some((nodes, primitives))
    }

    /// Whether the subtree of the root's second child comes before that of the first.
    fn was_written_leftwards(&self) -> bool {
        let below = |node: u32| match self.nodes[node as usize].link.target() {
            Target::Node(first) => Some(first),
            Target::Primitives(_) => None,
        };
        let Some(first) = below(0) else { return false };
        below(first).zip(below(first + 1)).is_some_and(|(left, right)| right < left)
    }
}
