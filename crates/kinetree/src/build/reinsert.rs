//! Repairing a finished tree: subtrees are taken out and put back where they cost least.
//!
//! A top-down builder decides high up what it can only know further down. So the largest nodes, which most rays meet, look for a better place: away from their
//! sibling, and beside any other node of the tree. How much area a move saves follows from the boxes on the way up and down, and a search that cannot beat the best
//! place so far is broken off. All searches of a batch look at the same tree, at the same time; then the moves are result, best first,
//! except those that touch what an earlier one has changed.
//!
//! Bittner, Hapala and Havran 2013, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies"; in parallel after Meister and Bittner 2018, "Parallel
//! Reinsertion for Bounding Volume Hierarchy Optimization".

use super::fast_box::FastBox;
use super::reference::GRAIN;
use crate::geometry::Aabb;
use crate::memory::{vec_in_chunks, vec_in_large_pages};
use crate::threads::Threads;
use crate::tree::{Bvh, Link, MAX_DEPTH, Node, Target};

/// Nodes are of the same size if their areas agree but for so many of the last bits: sign, exponent and seven bits are left.
const CLASS_SHIFT: u32 = 16;

/// Fewer searches than this are one thread's.
const SEARCHES: usize = 64;

/// The same primitives in the same leaves, under inner nodes with less area in all. Each batch moves at most that share of all nodes. The same tree for any
/// number of threads.
pub(crate) fn reinsert(bvh: Bvh, batches: &[f32], threads: &Threads) -> Bvh {
    let finite = bvh.bounds().half_area().is_finite();
    if bvh.node_count() < 5 || !finite {
        return bvh;
    }
    let mut tree = ParentedTree::of(bvh);
    let mut undo = Vec::with_capacity(batches.len());
    threads.begin_stage(0.8, (tree.nodes.len() as f32 * batches.iter().sum::<f32>()) as usize);
    for share in batches {
        if threads.is_cancelled() {
            break;
        }
        let moves = tree.search((tree.nodes.len() as f32 * share) as usize, threads);
        let result = tree.carry_out(&moves);
        let helps = result.saved > 0.0;
        undo.push(result.undo);
        if !helps {
            tree.take_back(undo.pop().unwrap_or_default());
            break;
        }
    }
    loop {
        match (tree.laid_out(), undo.pop()) {
            (Some((nodes, primitives)), _) => return Bvh::from_parts(nodes, primitives, tree.distinct),
            (None, Some(before)) => tree.take_back(before),
            (None, None) => unreachable!("the tree that was given keeps promise 6"),
        }
    }
}

/// A tree whose nodes stand in no order, but know their parents. Children are neighbours, the first
/// with an odd number (promise 7 of [`Bvh`]).
struct ParentedTree {
    nodes: Vec<Node>,
    parents: Vec<u32>,
    primitives: Vec<u32>,
    distinct: u32,
}

/// Takes node `from` out and puts it beside node `to`.
#[derive(Clone, Copy)]
struct Move {
    from: u32,
    to: u32,
    /// By how much the area of all inner nodes falls.
    gain: f32,
}

/// Looks for the best place for a node.
struct Search<'a> {
    nodes: &'a [Node],
    bounds: FastBox,
    own_area: f32,
    best: Move,
    /// First children that may have a better place below them, and what is gained where their parent does not grow any more.
    open: Vec<(f32, u32)>,
}

impl<'a> Search<'a> {
    fn of(tree: &'a ParentedTree, from: u32) -> Self {
        let bounds = FastBox::from(tree.bounds(from));
        let best = Move { from, to: 0, gain: 0.0 };
        Self { nodes: &tree.nodes, own_area: bounds.half_area(), bounds, best, open: Vec::with_capacity(64) }
    }

    /// At a node and everywhere below, when `gain` is what has been gained above.
    fn below(&mut self, at: u32, gain: f32) {
        if !self.may_beat(gain) {
            return;
        }
        let first = self.beside(at, gain);
        self.open.extend(first);
        while let Some((gain, first)) = self.open.pop() {
            if self.may_beat(gain) {
                let both = [self.beside(first, gain), self.beside(first + 1, gain)];
                // The more promising one last, so that it comes next.
                let [soon, later] = match both {
                    [Some(one), Some(other)] if one.0 < other.0 => [Some(other), Some(one)],
                    both => both,
                };
                for (gain, first) in later.into_iter().chain(soon) {
                    if self.may_beat(gain) {
                        self.open.push((gain, first));
                    }
                }
            }
        }
    }

    /// Whether a place below can be better than the best, if no box has to grow for it.
    #[inline(always)]
    fn may_beat(&self, gain: f32) -> bool {
        gain - self.own_area > self.best.gain
    }

    /// Tries a place, and says what is to be searched below it.
    #[inline(always)]
    fn beside(&mut self, at: u32, gain: f32) -> Option<(f32, u32)> {
        let there = &self.nodes[at as usize];
        let bounds = FastBox::from(&there.bounds);
        let left = gain - bounds.union(&self.bounds).half_area();
        if left > self.best.gain {
            self.best = Move { to: at, gain: left, ..self.best };
        }
        match there.link.target() {
            // Further down, this node only grows.
            Target::Node(first) => Some((left + bounds.half_area(), first)),
            Target::Primitives(_) => None,
        }
    }
}

/// What a batch has done.
struct BatchResult {
    /// By how much the area of all inner nodes has fallen.
    saved: f64,
    /// What was there before.
    undo: UndoLog,
}

/// Nodes as they were, in the order in which they were overwritten.
type UndoLog = Vec<(u32, Node)>;

impl ParentedTree {
    fn of(bvh: Bvh) -> Self {
        let (nodes, primitives, distinct) = bvh.into_parts();
        let mut parents = vec_in_large_pages(nodes.len());
        parents.resize(nodes.len(), 0);
        let mut loose = Self { nodes, parents, primitives, distinct };
        for at in 0..loose.nodes.len() {
            loose.adopt(at as u32);
        }
        loose
    }

    /// Tells the children of a node who their parent is.
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

    /// The other one of its pair: by promise 7, the first of a pair has an odd number.
    #[inline]
    fn sibling(&self, node: u32) -> u32 {
        ((node + 1) ^ 1) - 1
    }

    /// The largest nodes, and where each would best go.
    fn search(&self, count: usize, threads: &Threads) -> Vec<Move> {
        let mut moves: Vec<Move> =
            self.largest(count, threads).into_iter().map(|from| Move { from, to: 0, gain: 0.0 }).collect();
        threads.for_each(&mut moves, SEARCHES, &|number, one| {
            if threads.is_cancelled() {
                return;
            }
            if number % SEARCHES == 0 {
                threads.advance(SEARCHES);
            }
            *one = self.best_move(one.from);
        });
        moves.retain(|one| one.gain > 0.0);
        moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.from.cmp(&b.from)));
        moves
    }

    /// The largest nodes but the root; of those as large as the last one, but for the last bits of its area, those with smaller numbers.
    fn largest(&self, count: usize, threads: &Threads) -> Vec<u32> {
        let below_root = &self.nodes[1..];
        // Areas are not negative, so their bits are in order.
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
        // With the node gone its parent is not needed, and all further up shrink: `saved` is that area up to the pivot.
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

    /// Makes the moves that do not touch what others have changed.
    fn carry_out(&mut self, moves: &[Move]) -> BatchResult {
        let mut touched = vec![false; self.nodes.len()];
        let mut result = BatchResult { saved: 0.0, undo: Vec::new() };
        for one in moves {
            let around = [one.to, one.from, self.sibling(one.from), self.parent(one.to), self.parent(one.from)];
            if around.iter().any(|&node| touched[node as usize]) {
                continue;
            }
            around.iter().for_each(|&node| touched[node as usize] = true);
            self.carry_out_one(one, &mut result);
        }
        result
    }

    fn carry_out_one(&mut self, one: &Move, result: &mut BatchResult) {
        let (sibling, parent) = (self.sibling(one.from), self.parent(one.from));
        let pair = one.from.min(sibling);
        for node in [parent, one.to, sibling] {
            result.undo.push((node, self.nodes[node as usize]));
        }
        // The parent goes, and a node as large as the target comes, before boxes are brought up to date.
        result.saved += f64::from(self.bounds(parent).half_area()) - f64::from(self.bounds(one.to).half_area());
        let (moved, stays) = (self.nodes[one.to as usize], self.nodes[sibling as usize]);
        self.nodes[one.to as usize].link = Link::node(pair);
        self.nodes[sibling as usize] = moved;
        self.nodes[parent as usize] = stays;
        [one.to, sibling, parent].into_iter().for_each(|node| self.adopt(node));
        for start in [one.to, parent] {
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

    fn take_back(&mut self, undo: UndoLog) {
        for &(node, before) in undo.iter().rev() {
            self.nodes[node as usize] = before;
        }
        for (node, _) in undo {
            self.adopt(node);
        }
    }

    /// Depth first, as a builder would have laid it out: parents before children, primitives in the order of the leaves. Nothing if a path is too long.
    fn laid_out(&self) -> Option<(Vec<Node>, Vec<u32>)> {
        let mut nodes: Vec<Node> = vec_in_large_pages(self.nodes.len());
        let mut primitives = vec_in_large_pages(self.primitives.len());
        primitives.resize(self.primitives.len(), 0);
        // What has not been placed yet.
        let (mut start, mut end) = (0, primitives.len());
        // From the side from which the tree was written, so that it is read in a row.
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
                    let (soon, later) = if leftwards { (pair + 1, pair) } else { (pair, pair + 1) };
                    open.extend([(later, depth + 1), (soon, depth + 1)]);
                }
                Target::Primitives(places) => {
                    let count = places.len();
                    let first = if leftwards { end - count } else { start };
                    primitives[first..first + count]
                        .copy_from_slice(&self.primitives[places.start as usize..places.end as usize]);
                    nodes[at].link = Link::primitives(first as u32..(first + count) as u32);
                    if leftwards { end -= count } else { start += count }
                }
            }
        }
        Some((nodes, primitives))
    }

    /// Whether what is below the second child of the root stands before what is below the first.
    fn was_written_leftwards(&self) -> bool {
        let below = |node: u32| match self.nodes[node as usize].link.target() {
            Target::Node(first) => Some(first),
            Target::Primitives(_) => None,
        };
        let Some(first) = below(0) else { return false };
        below(first).zip(below(first + 1)).is_some_and(|(left, right)| right < left)
    }
}
