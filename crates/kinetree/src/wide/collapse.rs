//! From two children to eight, at the least cost.
//!
//! For every binary node and every k up to seven: what does its subtree cost at least if it may be represented by up to k roots? A single root is a leaf, or a wide
//! node whose eight slots are shared out to the two children in the best way; more roots are shared out likewise. Forming leaves is part of the recursion.
//!
//! Wald, Benthin and Boulos 2008, "Getting Rid of Packets" (collapsing); the recursion after Ylitie, Karras and Laine 2017, "Efficient Incoherent
//! Ray Traversal on GPUs Through Compressed Wide BVHs".

use std::ops::Range;

use super::node::LANES;
use super::{WideLink, WideNode, WideTree};
use crate::arena::with_room;
use crate::threads::Threads;
use crate::tree::{Bvh, Target};

/// So many nodes are visited between two looks at whether the tree is still wanted.
const PAUSE: usize = 4096;

/// What nodes and leaves cost, and how large leaves may be.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Costs {
    pub(crate) node: f32,
    pub(crate) unit: f32,
    /// Primitives in a unit.
    pub(crate) unit_size: usize,
    /// Units in a leaf.
    pub(crate) max_units: usize,
}

impl Costs {
    fn units(&self, primitives: usize) -> usize {
        primitives.div_ceil(self.unit_size)
    }
}

/// Collapses a binary tree. `leaf` is told the places of the primitives of each leaf, and makes units of them. All on the calling thread; `threads` may
/// have somebody who watches.
pub(crate) fn collapse(
    binary: &Bvh,
    costs: &Costs,
    threads: &Threads,
    mut leaf: impl FnMut(Range<u32>) -> Range<u32>,
) -> WideTree {
    let mut tree = WideTree { nodes: Vec::new(), units: 0, bounds: binary.bounds() };
    if binary.nodes().is_empty() {
        return tree;
    }
    // Wide nodes are about an eighth as many.
    threads.stage(1.0, binary.node_count() + binary.node_count() / 8);
    let plan = Plan::of(binary, costs, threads);
    if threads.is_cancelled() {
        return WideTree::default();
    }
    tree.nodes = with_room(binary.node_count() / 4 + 1);
    let mut open = vec![(0_u32, u32::MAX)];
    let mut roots = Vec::with_capacity(LANES);
    while let Some((from, parent_lane)) = open.pop() {
        let number = tree.nodes.len() as u32;
        if number as usize % PAUSE == PAUSE - 1 {
            threads.tick(PAUSE);
            if threads.is_cancelled() {
                return WideTree::default();
            }
        }
        tree.nodes.push(WideNode::new(parent_lane));
        if number > 0 {
            tree.link_of_lane(parent_lane, WideLink::node(number));
        }
        roots.clear();
        plan.children(from, &mut roots);
        plan.smallest_first(&mut roots);
        let mut node = tree.nodes[number as usize];
        for (lane, &root) in roots.iter().enumerate() {
            node.set_box(lane, &binary.nodes()[root as usize].bounds);
            node.in_use |= 1 << lane;
            if plan.is_leaf(root) {
                let units = leaf(plan.places(root));
                tree.units = units.end;
                node.links[lane] = WideLink::units(units).bits();
            }
        }
        tree.nodes[number as usize] = node;
        // The first lane comes next, so that a subtree stands together.
        for (lane, &root) in roots.iter().enumerate().rev() {
            if !plan.is_leaf(root) {
                open.push((root, number * LANES as u32 + lane as u32));
            }
        }
    }
    tree.nodes.shrink_to_fit();
    tree
}

/// The least costs of a subtree.
#[derive(Clone, Copy)]
struct Least {
    /// With up to 1, 2, .. 7 roots.
    roots: [f32; LANES - 1],
    first_place: u32,
    count: u32,
    is_leaf: bool,
}

struct Plan<'a> {
    binary: &'a Bvh,
    /// Of each node; the last node comes first.
    least: Vec<Least>,
}

impl<'a> Plan<'a> {
    fn of(binary: &'a Bvh, costs: &Costs, threads: &Threads) -> Self {
        let mut plan = Self { binary, least: with_room(binary.node_count()) };
        // Promise 5: children have been looked at before their parents.
        for (at, node) in binary.nodes().iter().enumerate().rev() {
            if at % PAUSE == 0 && at > 0 {
                threads.tick(PAUSE);
                if threads.is_cancelled() {
                    break;
                }
            }
            let area = node.bounds.half_area();
            let leaf_cost = |count: u32| area * costs.unit * costs.units(count as usize) as f32;
            let least = match node.link.target() {
                Target::Primitives(places) => {
                    let count = places.len() as u32;
                    Least { roots: [leaf_cost(count); LANES - 1], first_place: places.start, count, is_leaf: true }
                }
                Target::Node(first) => {
                    let (left, right) = (*plan.of_node(first), *plan.of_node(first + 1));
                    let count = left.count + right.count;
                    let together = left.first_place + left.count == right.first_place;
                    let shared = |slots: usize| best_share(&left, &right, slots).1;
                    let as_node = area * costs.node + shared(LANES);
                    let may_be_leaf = together && costs.units(count as usize) <= costs.max_units;
                    let is_leaf = may_be_leaf && leaf_cost(count) <= as_node;
                    let mut roots = [if is_leaf { leaf_cost(count) } else { as_node }; LANES - 1];
                    for k in 2..LANES {
                        let split = shared(k);
                        roots[k - 1] = if split < roots[k - 2] { split } else { roots[k - 2] };
                    }
                    Least { roots, first_place: left.first_place, count, is_leaf }
                }
            };
            plan.least.push(least);
        }
        plan
    }

    #[inline(always)]
    fn of_node(&self, node: u32) -> &Least {
        &self.least[self.binary.node_count() - 1 - node as usize]
    }

    fn is_leaf(&self, node: u32) -> bool {
        self.of_node(node).is_leaf
    }

    fn places(&self, node: u32) -> Range<u32> {
        let least = self.of_node(node);
        least.first_place..least.first_place + least.count
    }

    /// Subtrees of fewer primitives come first, and of equal ones those with larger boxes: where any hit will do, they are the soonest looked through, and
    /// a few large triangles hide most. (Embree orders its builders' children likewise.)
    fn smallest_first(&self, roots: &mut [u32]) {
        let area = |root: u32| self.binary.nodes()[root as usize].bounds.half_area();
        roots.sort_by(|&a, &b| {
            self.of_node(a).count.cmp(&self.of_node(b).count).then_with(|| area(b).total_cmp(&area(a)))
        });
    }

    /// The roots that the eight slots of a wide node are filled with.
    fn children(&self, node: u32, roots: &mut Vec<u32>) {
        match self.binary.nodes()[node as usize].link.target() {
            // Only the root of the whole can be a leaf here.
            Target::Node(first) if !self.is_leaf(node) => self.share(first, LANES, roots),
            _ => roots.push(node),
        }
    }

    fn share(&self, first: u32, slots: usize, roots: &mut Vec<u32>) {
        let (left, right) = (self.of_node(first), self.of_node(first + 1));
        let (to_left, _) = best_share(left, right, slots);
        self.fill(first, to_left, roots);
        self.fill(first + 1, slots - to_left, roots);
    }

    fn fill(&self, node: u32, mut slots: usize, roots: &mut Vec<u32>) {
        let least = &self.of_node(node).roots;
        // More slots than help are not taken.
        while slots > 1 && least[slots - 1] >= least[slots - 2] {
            slots -= 1;
        }
        match self.binary.nodes()[node as usize].link.target() {
            Target::Node(first) if slots > 1 => self.share(first, slots, roots),
            _ => roots.push(node),
        }
    }
}

/// How many of the slots go to the left child, and what both cost then.
fn best_share(left: &Least, right: &Least, slots: usize) -> (usize, f32) {
    let mut best = (1, f32::INFINITY);
    for to_left in 1..slots {
        let cost = left.roots[to_left.min(LANES - 1) - 1] + right.roots[(slots - to_left).min(LANES - 1) - 1];
        if cost < best.1 {
            best = (to_left, cost);
        }
    }
    best
}
