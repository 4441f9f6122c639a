//! From two children to eight, at the least cost: see [`CollapseCosts`].
//!
//! What has been found cheapest is written down from the root on, depth first, larger boxes before others.

use std::ops::Range;

use super::collapse_costs::{CollapseCosts, Subtree};
use super::node::LANES;
use super::{WideBvh, WideLink, WideNode};
use crate::memory::vec_in_large_pages;
use crate::simd::{Isa, Kernel, Level};
use crate::threads::Threads;
use crate::tree::{Bvh, Target};

/// Subtrees whose roots are so many nodes below that of the whole are written at the same time, each for itself, and then put in their places.
const DEPTH_OF_PARTS: u32 = 3;

/// Smaller trees have no parts. (Nodes of the binary tree.)
const SMALL: usize = 8192;

/// So many parts are one thread's.
const PARTS: usize = 4;

/// What nodes and leaves cost, and how large leaves may be.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Costs {
    pub(crate) node: f32,
    pub(crate) item: f32,
    /// Primitives in an item.
    pub(crate) item_size: usize,
    /// Items in a leaf.
    pub(crate) max_items: usize,
}

impl Costs {
    #[inline(always)]
    pub(super) fn of_leaf(&self, primitives: u32) -> f32 {
        self.item * self.items(primitives) as f32
    }

    #[inline(always)]
    pub(super) fn fits_a_leaf(&self, primitives: u32) -> bool {
        self.items(primitives) <= self.max_items
    }

    #[inline(always)]
    fn items(&self, primitives: u32) -> usize {
        (primitives as usize).div_ceil(self.item_size)
    }
}

/// What leaves lead to.
pub(crate) trait Items: Send + Sync {
    /// Makes items of the primitives of one leaf more, given their places, and numbers them from 0 on.
    fn add(&mut self, places: Range<u32>) -> Range<u32>;

    /// An empty list, for a part of the tree.
    fn part(&self) -> Self;

    /// The items of a part follow.
    fn append(&mut self, part: Self);
}

/// Collapses a binary tree. The leaves are added to `items` in their order.
pub(crate) fn collapse<U: Items>(binary: &Bvh, costs: &Costs, threads: &Threads, items: &mut U) -> WideBvh {
    write(binary, costs, threads, items, binary.node_count() > SMALL && !threads.is_single_and_unobserved())
}

fn write<U: Items>(binary: &Bvh, costs: &Costs, threads: &Threads, items: &mut U, in_parts: bool) -> WideBvh {
    if binary.nodes().is_empty() {
        return WideBvh::default();
    }
    // Wide nodes are about an eighth as many.
    threads.begin_stage(1.0, binary.node_count() + binary.node_count() / 8);
    let collapse_costs = CollapseCosts::of(binary, costs, threads);
    if threads.is_cancelled() {
        return WideBvh::default();
    }
    let roots = Roots { binary, costs: &collapse_costs, found: Vec::with_capacity(LANES) };
    let of_parts = if in_parts { roots.clone().of_parts() } else { Vec::new() };
    let mut parts: Vec<(u32, Option<Part<U>>)> = of_parts.into_iter().map(|root| (root, None)).collect();
    let empty = items.part();
    let level = Level::current();
    threads.for_each(&mut parts, PARTS, &|_, (root, part)| {
        let mut written = Part { nodes: Vec::new(), items: empty.part(), item_count: 0 };
        if !threads.is_cancelled() {
            level.run(Write { part: &mut written, root: *root, roots: roots.clone(), parts: &mut std::iter::empty() });
            threads.advance(written.nodes.len());
        }
        *part = Some(written);
    });
    if threads.is_cancelled() {
        return WideBvh::default();
    }
    let room = if parts.is_empty() {
        binary.node_count() / FEWEST + 1
    } else {
        parts.iter().flat_map(|(_, part)| part).map(|part| part.nodes.len()).sum::<usize>() + MOST_ABOVE
    };
    let mut whole = Part { nodes: vec_in_large_pages(room), items: empty, item_count: 0 };
    let mut parts = parts.into_iter().filter_map(|(_, part)| part);
    level.run(Write { part: &mut whole, root: 0, roots, parts: &mut parts });
    whole.nodes.shrink_to_fit();
    items.append(whole.items);
    WideBvh { nodes: whole.nodes, items: whole.item_count, bounds: binary.bounds() }
}

/// As a rule, no fewer nodes of the binary tree become a wide one.
const FEWEST: usize = 4;

/// The most nodes above the parts.
const MOST_ABOVE: usize = 1 + LANES + LANES * LANES;
const _: () = assert!(DEPTH_OF_PARTS == 3);

/// A subtree, numbered from 0 on.
struct Part<U> {
    nodes: Vec<WideNode>,
    items: U,
    item_count: u32,
}

impl<U: Items> Part<U> {
    /// Writes the subtree of a binary node, depth first. As long as there are parts, they stand for what is so far down.
    #[inline(always)]
    fn write(&mut self, isa: impl Isa, root: u32, mut roots: Roots<'_>, parts: &mut impl Iterator<Item = Self>) {
        let mut open = vec![(root, u32::MAX, 0)];
        while let Some((from, parent_lane, depth)) = open.pop() {
            let number = self.nodes.len() as u32;
            if number > 0 {
                let (parent, lane) = (parent_lane as usize / LANES, parent_lane as usize % LANES);
                self.nodes[parent].links[lane] = WideLink::node(number).bits();
            }
            if depth == DEPTH_OF_PARTS
                && let Some(part) = parts.next()
            {
                self.append(part, parent_lane);
                continue;
            }
            let mut node = WideNode::new(parent_lane);
            roots.below(from);
            let before = open.len();
            for (lane, root) in roots.found.iter().enumerate() {
                node.set_box(lane, &roots.binary.nodes()[root.node as usize].bounds);
                node.in_use |= 1 << lane;
                match &root.leaf {
                    Some(places) => {
                        let items = self.items.add(places.clone());
                        self.item_count = items.end;
                        node.links[lane] = WideLink::items(items).bits();
                    }
                    None => {
                        roots.costs.prefetch(isa, root.node);
                        open.push((root.node, number * LANES as u32 + lane as u32, depth + 1));
                    }
                }
            }
            // The first lane comes next, so that a subtree stands together.
            open[before..].reverse();
            self.nodes.push(node);
        }
    }

    fn append(&mut self, part: Self, parent_lane: u32) {
        let (first_node, first_item) = (self.nodes.len() as u32, self.item_count);
        self.nodes.extend_from_slice(&part.nodes);
        for node in &mut self.nodes[first_node as usize..] {
            for link in &mut node.links[..node.in_use.count_ones() as usize] {
                *link = WideLink::from_bits(*link).moved(first_node, first_item).bits();
            }
            node.parent_lane = match node.parent_lane {
                u32::MAX => parent_lane,
                lane => lane + first_node * LANES as u32,
            };
        }
        self.item_count += part.item_count;
        self.items.append(part.items);
    }
}

/// Calls [`Part::write`].
struct Write<'a, 'b, U, P> {
    part: &'a mut Part<U>,
    root: u32,
    roots: Roots<'b>,
    parts: &'a mut P,
}

impl<U: Items, P: Iterator<Item = Part<U>>> Kernel for Write<'_, '_, U, P> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        self.part.write(isa, self.root, self.roots, self.parts);
    }
}

/// What a lane of a wide node leads to.
#[derive(Clone)]
struct Root {
    node: u32,
    /// What a ray that enters its box is expected to cost.
    cost: f32,
    /// The places of its primitives, if it becomes a leaf.
    leaf: Option<Range<u32>>,
}

#[derive(Clone)]
struct Roots<'a> {
    binary: &'a Bvh,
    costs: &'a CollapseCosts<'a>,
    found: Vec<Root>,
}

impl Roots<'_> {
    /// The roots of the parts, in their order.
    fn of_parts(mut self) -> Vec<u32> {
        let mut parts = Vec::new();
        let mut open = vec![(0, 0)];
        while let Some((from, depth)) = open.pop() {
            if depth == DEPTH_OF_PARTS {
                parts.push(from);
                continue;
            }
            self.below(from);
            open.extend(self.found.iter().rev().filter(|root| root.leaf.is_none()).map(|root| (root.node, depth + 1)));
        }
        parts
    }

    /// Finds what the eight slots of a wide node are filled with. Those with the lowest expected
    /// cost come first; equal ones keep their order. Queries for any hit visit lanes in this order:
    /// a cheap subtree is done quickly, and a few large triangles hide most.
    fn below(&mut self, node: u32) {
        self.found.clear();
        let subtree = self.of_node(node);
        match self.binary.nodes()[node as usize].link.target() {
            // Only the root of the whole can be a leaf here.
            Target::Node(first) if subtree.leaf().is_none() => self.divide_slots(first, LANES),
            _ => self.push(node, &subtree),
        }
    }

    fn of_node(&self, node: u32) -> Subtree {
        self.costs.of_node(node).expect("all pairs are known unless somebody cancels")
    }

    fn divide_slots(&mut self, first: u32, slots: usize) {
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
            Target::Node(first) if slots > 1 => self.divide_slots(first, slots),
            _ => self.push(node, subtree),
        }
    }

    fn push(&mut self, node: u32, subtree: &Subtree) {
        let area = self.binary.nodes()[node as usize].bounds.half_area();
        let cost = if area > 0.0 { subtree.roots[0] / area } else { 0.0 };
        let mut at = self.found.len();
        while at > 0 && cost.total_cmp(&self.found[at - 1].cost).is_lt() {
            at -= 1;
        }
        self.found.insert(at, Root { node, cost, leaf: subtree.leaf() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build;
    use crate::geometry::Aabb;
    use crate::wide::mesh_bvh::COSTS;

    /// As many primitives as there are, in the order of the leaves.
    #[derive(Default, PartialEq, Debug)]
    struct Places(Vec<u32>);

    impl Items for Places {
        fn add(&mut self, places: Range<u32>) -> Range<u32> {
            let first = self.0.len() as u32;
            self.0.push(places.start);
            first..first + 1
        }

        fn part(&self) -> Self {
            Self::default()
        }

        fn append(&mut self, part: Self) {
            self.0.extend(part.0);
        }
    }

    #[test]
    fn a_tree_written_in_parts_is_the_one_written_at_one_go() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 24) as f32
        };
        for count in [1, 2, 9, 60, 700, 9000] {
            let boxes: Vec<Aabb> = (0..count)
                .map(|_| {
                    let corner = [random(), random(), random()];
                    Aabb::new(corner, corner.map(|x| x + 0.02 * random()))
                })
                .collect();
            let binary = build::build_clustered(count, |i| boxes[i as usize], &build::BuildOptions::default());
            let (mut places, mut in_parts) = (Places::default(), Places::default());
            let tree = write(&binary, &COSTS, &Threads::one(), &mut places, false);
            let other = write(&binary, &COSTS, &Threads::default(), &mut in_parts, true);
            assert_eq!(tree.nodes(), other.nodes(), "{count}");
            assert_eq!((tree.item_count(), places), (other.item_count(), in_parts), "{count}");
            tree.validate().unwrap();
        }
    }
}
