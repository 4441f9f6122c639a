//! Repairing a finished tree: subtrees are taken out and put back where they cost least.
//!
//! A top-down builder decides high up what it can only know further down. So the largest nodes, which most rays meet, look for a better place: away from their
//! sibling, and beside any other node of the tree. How much area a move saves follows from the boxes on the way up and down, and a search that cannot beat the best
//! place so far is broken off. All searches of a batch look at the same tree, at the same time; then the moves are made, best first,
//! except those that touch what an earlier one has changed.
//!
//! Bittner, Hapala and Havran 2013, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies"; in parallel after Meister and Bittner 2018, "Parallel
//! Reinsertion for Bounding Volume Hierarchy Optimization".

use crate::geometry::Aabb;
use crate::threads::Threads;
use crate::tree::{Bvh, Link, MAX_DEPTH, Node, Target};

/// Fewer searches than this are one thread's.
const SEARCHES: usize = 64;

/// The same primitives in the same leaves, under inner nodes with less area in all. Each batch moves at most that share of all nodes. The same tree for any
/// number of threads.
pub(crate) fn reinsert(bvh: Bvh, batches: &[f32], threads: &Threads) -> Bvh {
    let finite = bvh.bounds().half_area().is_finite();
    if bvh.node_count() < 5 || !finite {
        return bvh;
    }
    let mut tree = Loose::of(&bvh);
    let mut area = tree.measure().area;
    threads.stage(0.8, (bvh.node_count() as f32 * batches.iter().sum::<f32>()) as usize);
    for share in batches {
        if threads.is_cancelled() {
            return bvh;
        }
        let moves = tree.search((bvh.node_count() as f32 * share) as usize, threads);
        let undo = tree.carry_out(&moves);
        let measured = tree.measure();
        if measured.depth > MAX_DEPTH || measured.area >= area {
            tree.take_back(undo);
            break;
        }
        area = measured.area;
    }
    tree.laid_out(&bvh)
}

/// A tree whose nodes stand in no order, but know their parents. Children are neighbours, the first with an odd number.
struct Loose {
    nodes: Vec<Node>,
    parents: Vec<u32>,
}

/// Takes node `from` out and puts it beside node `to`.
#[derive(Clone, Copy)]
struct Move {
    from: u32,
    to: u32,
    /// By how much the area of all inner nodes falls.
    gain: f32,
}

struct Measured {
    depth: usize,
    /// Of all inner nodes, below the root.
    area: f64,
}

impl Loose {
    fn of(bvh: &Bvh) -> Self {
        let mut loose = Self { nodes: bvh.nodes().to_vec(), parents: vec![0; bvh.node_count()] };
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

    /// Every builder of this crate numbers pairs from 1 on, so the first of a pair is odd.
    #[inline]
    fn sibling(&self, node: u32) -> u32 {
        ((node + 1) ^ 1) - 1
    }

    /// The largest nodes, and where each would best go.
    fn search(&self, count: usize, threads: &Threads) -> Vec<Move> {
        let mut largest: Vec<(f32, u32)> =
            (1..self.nodes.len() as u32).map(|node| (self.bounds(node).half_area(), node)).collect();
        let count = count.clamp(1, largest.len());
        if count < largest.len() {
            largest.select_nth_unstable_by(count, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            largest.truncate(count);
        }
        let mut moves: Vec<Move> = largest.into_iter().map(|(_, from)| Move { from, to: 0, gain: 0.0 }).collect();
        threads.for_each(&mut moves, SEARCHES, &|number, one| {
            if number % SEARCHES == 0 {
                threads.tick(SEARCHES);
            }
            if !threads.is_cancelled() {
                *one = self.best_move(one.from);
            }
        });
        moves.retain(|one| one.gain > 0.0);
        moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.from.cmp(&b.from)));
        moves
    }

    fn best_move(&self, from: u32) -> Move {
        let bounds = *self.bounds(from);
        let own_area = bounds.half_area();
        let parent = self.parent(from);
        let mut best = Move { from, to: 0, gain: 0.0 };
        // With the node gone its parent is not needed, and all further up shrink: `saved` is that area up to the pivot.
        let mut saved = self.bounds(parent).half_area();
        let mut sibling = self.sibling(from);
        let mut shrunk = *self.bounds(sibling);
        let mut pivot = parent;
        let mut open = Vec::with_capacity(64);
        loop {
            open.push((saved, sibling));
            while let Some((gain, at)) = open.pop() {
                if gain - own_area <= best.gain {
                    continue;
                }
                let there = &self.nodes[at as usize];
                let left = gain - there.bounds.union(&bounds).half_area();
                if left > best.gain {
                    best = Move { from, to: at, gain: left };
                }
                if let Target::Node(first) = there.link.target() {
                    // Further down, this node only grows.
                    let below = left + there.bounds.half_area();
                    open.push((below, first));
                    open.push((below, first + 1));
                }
            }
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
        if best.to == self.sibling(from) { Move { from, to: 0, gain: 0.0 } } else { best }
    }

    /// Makes the moves that do not touch what others have changed; what was there before is returned.
    fn carry_out(&mut self, moves: &[Move]) -> Vec<(u32, Node)> {
        let mut touched = vec![false; self.nodes.len()];
        let mut undo = Vec::new();
        for one in moves {
            let around = [one.to, one.from, self.sibling(one.from), self.parent(one.to), self.parent(one.from)];
            if around.iter().any(|&node| touched[node as usize]) {
                continue;
            }
            around.iter().for_each(|&node| touched[node as usize] = true);
            self.carry_out_one(one, &mut undo);
        }
        undo
    }

    fn carry_out_one(&mut self, one: &Move, undo: &mut Vec<(u32, Node)>) {
        let (sibling, parent) = (self.sibling(one.from), self.parent(one.from));
        let pair = one.from.min(sibling);
        for node in [parent, one.to, sibling] {
            undo.push((node, self.nodes[node as usize]));
        }
        let (moved, stays) = (self.nodes[one.to as usize], self.nodes[sibling as usize]);
        self.nodes[one.to as usize].link = Link::node(pair);
        self.nodes[sibling as usize] = moved;
        self.nodes[parent as usize] = stays;
        [one.to, sibling, parent].into_iter().for_each(|node| self.adopt(node));
        for start in [one.to, parent] {
            self.refit_from(start, undo);
        }
    }

    fn refit_from(&mut self, mut at: u32, undo: &mut Vec<(u32, Node)>) {
        loop {
            if let Target::Node(first) = self.nodes[at as usize].link.target() {
                let bounds = self.bounds(first).union(self.bounds(first + 1));
                if bounds != *self.bounds(at) {
                    undo.push((at, self.nodes[at as usize]));
                    self.nodes[at as usize].bounds = bounds;
                }
            }
            if at == 0 {
                return;
            }
            at = self.parent(at);
        }
    }

    fn take_back(&mut self, undo: Vec<(u32, Node)>) {
        for &(node, before) in undo.iter().rev() {
            self.nodes[node as usize] = before;
        }
        for (node, _) in undo {
            self.adopt(node);
        }
    }

    fn measure(&self) -> Measured {
        let mut measured = Measured { depth: 0, area: 0.0 };
        let mut open = vec![(0_u32, 1_usize)];
        while let Some((at, depth)) = open.pop() {
            measured.depth = measured.depth.max(depth);
            if let Target::Node(first) = self.nodes[at as usize].link.target() {
                measured.area += f64::from(self.bounds(at).half_area());
                open.push((first + 1, depth + 1));
                open.push((first, depth + 1));
            }
        }
        measured
    }

    /// Depth first, as a builder would have laid it out: parents before children, primitives in the order of the leaves.
    fn laid_out(&self, bvh: &Bvh) -> Bvh {
        let mut nodes = Vec::with_capacity(self.nodes.len());
        let mut primitives = Vec::with_capacity(bvh.primitives().len());
        nodes.push(self.nodes[0]);
        let mut open = vec![0_usize];
        while let Some(at) = open.pop() {
            match nodes[at].link.target() {
                Target::Node(first) => {
                    let pair = nodes.len();
                    nodes.extend_from_slice(&self.nodes[first as usize..first as usize + 2]);
                    nodes[at].link = Link::node(pair as u32);
                    open.push(pair + 1);
                    open.push(pair);
                }
                Target::Primitives(places) => {
                    let start = primitives.len() as u32;
                    primitives.extend_from_slice(&bvh.primitives()[places.start as usize..places.end as usize]);
                    nodes[at].link = Link::primitives(start..primitives.len() as u32);
                }
            }
        }
        Bvh::from_parts(nodes, primitives, bvh.primitive_count() as u32)
    }
}
