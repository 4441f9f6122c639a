//! Collapsing a binary tree to an eight-way tree of minimum cost: see [`CollapseCosts`].
//!
//! Nodes are written in depth-first order, with the children of a node ordered by expected cost.

use std::ops::Range;

use super::collapse_costs::{CollapseCosts, Subtree};
use super::costs::Costs;
use super::node::LANES;
use super::one_node::{MAX_NODES, collapse_to_one_node};
use super::{WideBvh, WideLink, WideNode};
use crate::memory::vec_in_large_pages;
use crate::simd::{Isa, Kernel, Level};
use crate::threads::Threads;
use crate::tree::{Bvh, Target};

/// The depth of the roots of the subtrees that are written in parallel and then concatenated, in
/// wide nodes.
const DEPTH_OF_PARTS: u32 = 3;

/// Trees of up to this many binary nodes are written by one thread.
const MAX_UNDIVIDED: usize = 8192;

/// Parts per parallel task.
const PARTS_PER_TASK: usize = 4;

/// The list of items that leaves link to.
pub(crate) trait Items: Send + Sync {
    /// Appends the items of a leaf, given the range of its primitives in the binary tree, and
    /// returns their indices.
    fn add(&mut self, range: Range<u32>) -> Range<u32>;

    /// A new list, for a part of the tree.
    fn part(&self) -> Self;

    /// Appends the items of a part.
    fn append(&mut self, part: Self);
}

/// Collapses a binary tree. Leaves are added to `items` in depth-first order.
pub(crate) fn collapse<U: Items>(binary: &Bvh, costs: &Costs, threads: &Threads, items: &mut U) -> WideBvh {
    if (1..=MAX_NODES).contains(&binary.node_count()) {
        threads.begin_stage(1.0, 1);
        return collapse_to_one_node(binary, costs, items);
    }
    write(binary, costs, threads, items, binary.node_count() > MAX_UNDIVIDED && !threads.is_single_and_unobserved())
}

fn write<U: Items>(binary: &Bvh, costs: &Costs, threads: &Threads, items: &mut U, in_parts: bool) -> WideBvh {
    if binary.nodes().is_empty() {
        return WideBvh::default();
    }
    // About one wide node per eight binary nodes.
    threads.begin_stage(1.0, binary.node_count() + binary.node_count() / 8);
    let collapse_costs = CollapseCosts::of(binary, costs, threads);
    if threads.is_cancelled() {
        return WideBvh::default();
    }
    let lanes = LaneSelection { binary, costs: &collapse_costs, found: Vec::with_capacity(LANES) };
    let part_roots = if in_parts { lanes.clone().part_roots() } else { Vec::new() };
    let mut parts: Vec<(u32, Option<Part<U>>)> = part_roots.into_iter().map(|root| (root, None)).collect();
    let empty = items.part();
    let level = Level::current();
    threads.for_each(&mut parts, PARTS_PER_TASK, &|_, (root, part)| {
        let mut written = Part { nodes: Vec::new(), items: empty.part(), item_count: 0 };
        if !threads.is_cancelled() {
            level.run(Write { part: &mut written, root: *root, lanes: lanes.clone(), parts: &mut std::iter::empty() });
            threads.advance(written.nodes.len());
        }
        *part = Some(written);
    });
    if threads.is_cancelled() {
        return WideBvh::default();
    }
    let capacity = if parts.is_empty() {
        binary.node_count() / MIN_BINARY_PER_WIDE + 1
    } else {
        parts.iter().flat_map(|(_, part)| part).map(|part| part.nodes.len()).sum::<usize>() + MAX_ABOVE_PARTS
    };
    let mut output = Part { nodes: vec_in_large_pages(capacity), items: empty, item_count: 0 };
    let mut parts = parts.into_iter().filter_map(|(_, part)| part);
    level.run(Write { part: &mut output, root: 0, lanes, parts: &mut parts });
    output.nodes.shrink_to_fit();
    items.append(output.items);
    WideBvh { nodes: output.nodes, items: output.item_count, bounds: binary.bounds() }
}

/// The usual minimum of binary nodes per wide node, for the initial capacity.
const MIN_BINARY_PER_WIDE: usize = 4;

/// The largest number of nodes above the parts.
const MAX_ABOVE_PARTS: usize = 1 + LANES + LANES * LANES;
const _: () = assert!(DEPTH_OF_PARTS == 3);

/// A subtree whose node and item indices start at 0.
struct Part<U> {
    nodes: Vec<WideNode>,
    items: U,
    item_count: u32,
}

impl<U: Items> Part<U> {
    /// Writes the subtree of a binary node, depth first. Subtrees at [`DEPTH_OF_PARTS`] are taken
    /// from `parts` while there are any.
    #[inline(always)]
    fn write(
        &mut self,
        isa: impl Isa,
        root: u32,
        mut lanes: LaneSelection<'_>,
        parts: &mut impl Iterator<Item = Self>,
    ) {
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
            lanes.select(from);
            let before = open.len();
            for (lane, root) in lanes.found.iter().enumerate() {
                let bounds = &lanes.binary.nodes()[root.node as usize].bounds;
                match &root.leaf {
                    Some(range) => {
                        let items = self.items.add(range.clone());
                        self.item_count = items.end;
                        node.set_lane(lane, bounds, WideLink::items(items));
                    }
                    None => {
                        // The link is written when the child is.
                        node.set_lane(lane, bounds, WideLink::default());
                        lanes.costs.prefetch(isa, root.node);
                        open.push((root.node, number * LANES as u32 + lane as u32, depth + 1));
                    }
                }
            }
            // The first lane goes on top of the stack, so that subtrees are contiguous (promise 7).
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
    lanes: LaneSelection<'b>,
    parts: &'a mut P,
}

impl<U: Items, P: Iterator<Item = Part<U>>> Kernel for Write<'_, '_, U, P> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        self.part.write(isa, self.root, self.lanes, self.parts);
    }
}

/// The subtree of a lane of a wide node.
#[derive(Clone)]
struct LaneRoot {
    node: u32,
    /// The expected cost of a ray that enters its box.
    cost: f32,
    /// The range of its primitives, if it becomes a leaf.
    leaf: Option<Range<u32>>,
}

#[derive(Clone)]
struct LaneSelection<'a> {
    binary: &'a Bvh,
    costs: &'a CollapseCosts<'a>,
    found: Vec<LaneRoot>,
}

impl LaneSelection<'_> {
    /// The roots of the parts, in depth-first order.
    fn part_roots(mut self) -> Vec<u32> {
        let mut parts = Vec::new();
        let mut open = vec![(0, 0)];
        while let Some((from, depth)) = open.pop() {
            if depth == DEPTH_OF_PARTS {
                parts.push(from);
                continue;
            }
            self.select(from);
            open.extend(self.found.iter().rev().filter(|root| root.leaf.is_none()).map(|root| (root.node, depth + 1)));
        }
        parts
    }

    /// Finds the subtrees of the eight lanes of a wide node, in ascending order of cost; equal ones
    /// keep the order of the binary tree. Any-hit queries visit lanes in this order: cheap subtrees
    /// take the least time to search, and a few large triangles occlude most rays.
    fn select(&mut self, node: u32) {
        self.found.clear();
        let subtree = self.of_node(node);
        match self.binary.nodes()[node as usize].link.target() {
            // Only the root of the tree can be a leaf here.
            Target::Node(first) if subtree.leaf().is_none() => self.divide_slots(first, LANES),
            _ => self.push(node, &subtree),
        }
    }

    fn of_node(&self, node: u32) -> Subtree {
        self.costs.of_node(node).expect("all pairs are known unless the build is cancelled")
    }

    fn divide_slots(&mut self, first: u32, slots: usize) {
        let (left, right) = (self.of_node(first), self.of_node(first + 1));
        let (mut to_left, mut min_cost) = (1, f32::INFINITY);
        for left_slots in 1..slots {
            let cost = left.roots[left_slots - 1] + right.roots[slots - left_slots - 1];
            if cost < min_cost {
                (to_left, min_cost) = (left_slots, cost);
            }
        }
        self.fill(first, to_left, &left);
        self.fill(first + 1, slots - to_left, &right);
    }

    fn fill(&mut self, node: u32, mut slots: usize, subtree: &Subtree) {
        // Slots that do not reduce the cost are not used.
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
        self.found.insert(at, LaneRoot { node, cost, leaf: subtree.leaf() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build;
    use crate::geometry::Aabb;
    use crate::test_random::Random;

    /// Records the first primitive of each leaf.
    #[derive(Default, PartialEq, Debug)]
    struct FirstPrimitives(Vec<u32>);

    impl Items for FirstPrimitives {
        fn add(&mut self, range: Range<u32>) -> Range<u32> {
            let first = self.0.len() as u32;
            self.0.push(range.start);
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
        let mut generator = Random(7);
        let mut random = || generator.unit();
        for count in [1, 2, 9, 60, 700, 9000] {
            let boxes: Vec<Aabb> = (0..count)
                .map(|_| {
                    let corner = [random(), random(), random()];
                    Aabb::new(corner, corner.map(|x| x + 0.02 * random()))
                })
                .collect();
            let binary = build::build_clustered(count, |i| boxes[i as usize], &build::BuildOptions::default());
            let (mut range, mut in_parts) = (FirstPrimitives::default(), FirstPrimitives::default());
            let tree = write(&binary, &Costs::TRIANGLES, &Threads::one(), &mut range, false);
            let other = write(&binary, &Costs::TRIANGLES, &Threads::default(), &mut in_parts, true);
            assert_eq!(tree.nodes(), other.nodes(), "{count}");
            assert_eq!((tree.item_count(), range), (other.item_count(), in_parts), "{count}");
            tree.validate().unwrap();
        }
    }
}
