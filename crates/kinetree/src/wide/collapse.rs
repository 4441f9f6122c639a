//! From two children to eight, at the least cost: see [`Least`].
//!
//! What has been found cheapest is written down from the root on, depth first, larger boxes before others.

use std::ops::Range;

use super::least::{Least, Subtree};
use super::node::LANES;
use super::{WideLink, WideNode, WideTree};
use crate::arena::with_room;
use crate::threads::Threads;
use crate::tree::{Bvh, Target};

/// So many nodes are written between two looks at whether the tree is still wanted.
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
    #[inline(always)]
    pub(super) fn of_leaf(&self, primitives: u32) -> f32 {
        self.unit * self.units(primitives) as f32
    }

    #[inline(always)]
    pub(super) fn fits_a_leaf(&self, primitives: u32) -> bool {
        self.units(primitives) <= self.max_units
    }

    #[inline(always)]
    fn units(&self, primitives: u32) -> usize {
        (primitives as usize).div_ceil(self.unit_size)
    }
}

/// Collapses a binary tree. `leaf` is told the places of the primitives of each leaf, in their order, and makes units of them.
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
    let least = Least::of(binary, costs, threads);
    if threads.is_cancelled() {
        return WideTree::default();
    }
    tree.nodes = with_room(binary.node_count() / 4 + 1);
    let mut open = vec![(0_u32, u32::MAX)];
    let mut roots = Roots { binary, least: &least, found: Vec::with_capacity(LANES) };
    while let Some((from, parent_lane)) = open.pop() {
        let number = tree.nodes.len() as u32;
        if number as usize % PAUSE == PAUSE - 1 {
            threads.tick(PAUSE);
            if threads.is_cancelled() {
                return WideTree::default();
            }
        }
        if number > 0 {
            tree.link_of_lane(parent_lane, WideLink::node(number));
        }
        let mut node = WideNode::new(parent_lane);
        roots.below(from);
        let before = open.len();
        for (lane, root) in roots.found.iter().enumerate() {
            node.set_box(lane, &binary.nodes()[root.node as usize].bounds);
            node.in_use |= 1 << lane;
            match &root.leaf {
                Some(places) => {
                    let units = leaf(places.clone());
                    tree.units = units.end;
                    node.links[lane] = WideLink::units(units).bits();
                }
                None => open.push((root.node, number * LANES as u32 + lane as u32)),
            }
        }
        // The first lane comes next, so that a subtree stands together.
        open[before..].reverse();
        tree.nodes.push(node);
    }
    tree.nodes.shrink_to_fit();
    tree
}

/// What a lane of a wide node leads to.
struct Root {
    node: u32,
    area: f32,
    /// The places of its primitives, if it becomes a leaf.
    leaf: Option<Range<u32>>,
}

struct Roots<'a> {
    binary: &'a Bvh,
    least: &'a Least<'a>,
    found: Vec<Root>,
}

impl Roots<'_> {
    /// Finds what the eight slots of a wide node are filled with: larger boxes come first; of equal ones, those that came first before.
    fn below(&mut self, node: u32) {
        self.found.clear();
        let subtree = self.of_node(node);
        match self.binary.nodes()[node as usize].link.target() {
            // Only the root of the whole can be a leaf here.
            Target::Node(first) if subtree.leaf().is_none() => self.share(first, LANES),
            _ => self.push(node, &subtree),
        }
    }

    fn of_node(&self, node: u32) -> Subtree {
        self.least.of_node(node).expect("all pairs are known unless somebody cancels")
    }

    fn share(&mut self, first: u32, slots: usize) {
        let (left, right) = (self.of_node(first), self.of_node(first + 1));
        let (mut to_left, mut least) = (1, f32::INFINITY);
        for share in 1..slots {
            let cost = left.roots[share - 1] + right.roots[slots - share - 1];
            if cost < least {
                (to_left, least) = (share, cost);
            }
        }
        self.fill(first, to_left, &left);
        self.fill(first + 1, slots - to_left, &right);
    }

    fn fill(&mut self, node: u32, mut slots: usize, subtree: &Subtree) {
        // More slots than help are not taken.
        while slots > 1 && subtree.roots[slots - 1] >= subtree.roots[slots - 2] {
            slots -= 1;
        }
        match self.binary.nodes()[node as usize].link.target() {
            Target::Node(first) if slots > 1 => self.share(first, slots),
            _ => self.push(node, subtree),
        }
    }

    fn push(&mut self, node: u32, subtree: &Subtree) {
        let area = self.binary.nodes()[node as usize].bounds.half_area();
        let mut at = self.found.len();
        while at > 0 && area.total_cmp(&self.found[at - 1].area).is_gt() {
            at -= 1;
        }
        self.found.insert(at, Root { node, area, leaf: subtree.leaf() });
    }
}
