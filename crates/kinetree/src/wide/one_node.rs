//! The collapse of a small binary tree to a single wide node.
//!
//! With at most eight leaves, the lanes of one node suffice for any choice of subtrees, and further
//! nodes would only cost further visits. So the dynamic program of
//! [`CollapseCosts`](super::collapse_costs::CollapseCosts) becomes one choice per subtree: a single
//! leaf, or the best leaves of its two children. Nothing is allocated but the result.

use super::collapse::Items;
use super::costs::Costs;
use super::node::LANES;
use super::{WideBvh, WideLink, WideNode};
use crate::tree::{Bvh, Node, Target};

/// The number of nodes of a binary tree of eight leaves.
pub(super) const MAX_NODES: usize = 2 * LANES - 1;

/// Collapses a tree of 1 to [`MAX_NODES`] nodes.
pub(super) fn collapse_to_one_node<U: Items>(binary: &Bvh, costs: &Costs, items: &mut U) -> WideBvh {
    let nodes = binary.nodes();
    let subtrees = Subtree::all(nodes, costs);
    let mut node = WideNode::new(u32::MAX);
    let lanes = lanes(nodes, &subtrees);
    let mut item_count = 0;
    for (lane, &(root, _)) in lanes.roots[..lanes.count].iter().enumerate() {
        let Subtree { first, count, .. } = subtrees[root];
        let leaf = items.add(first..first + count);
        item_count = leaf.end;
        node.set_lane(lane, &nodes[root].bounds, WideLink::items(leaf));
    }
    WideBvh { nodes: vec![node], items: item_count, bounds: binary.bounds() }
}

#[derive(Clone, Copy)]
struct Subtree {
    /// The minimum cost of its leaves, each times its half area.
    cost: f32,
    /// The index of its first primitive, and the number of its primitives if they are contiguous,
    /// otherwise 0.
    first: u32,
    count: u32,
    /// Whether the minimum is a single leaf.
    is_leaf: bool,
}

impl Subtree {
    fn all(nodes: &[Node], costs: &Costs) -> [Self; MAX_NODES] {
        let mut all = [Self { cost: 0.0, first: 0, count: 0, is_leaf: false }; MAX_NODES];
        for at in (0..nodes.len()).rev() {
            let area = nodes[at].bounds.half_area();
            all[at] = match nodes[at].link.target() {
                Target::Primitives(range) => {
                    let count = range.len() as u32;
                    Self { cost: area * costs.of_leaf(count), first: range.start, count, is_leaf: true }
                }
                Target::Node(first) => {
                    // Promise 5: children come after their parent.
                    let [left, right] = [all[first as usize], all[first as usize + 1]];
                    let is_contiguous = left.count > 0 && right.count > 0 && left.first + left.count == right.first;
                    let count = if is_contiguous { left.count + right.count } else { 0 };
                    let cost = left.cost + right.cost;
                    let as_leaf = area * costs.of_leaf(count);
                    let is_leaf = count > 0 && costs.fits_a_leaf(count) && as_leaf <= cost;
                    Self { cost: if is_leaf { as_leaf } else { cost }, first: left.first, count, is_leaf }
                }
            };
        }
        all
    }
}

struct Lanes {
    /// The root of the subtree of each lane, and the expected cost of a ray that enters its box.
    roots: [(usize, f32); LANES],
    count: usize,
}

/// The leaves, in ascending order of cost; equal ones keep the order of the binary tree.
fn lanes(nodes: &[Node], subtrees: &[Subtree; MAX_NODES]) -> Lanes {
    let mut lanes = Lanes { roots: [(0, 0.0); LANES], count: 0 };
    let (mut stack, mut top) = ([0; LANES], 1);
    while top > 0 {
        top -= 1;
        let at: usize = stack[top];
        if let (false, Target::Node(first)) = (subtrees[at].is_leaf, nodes[at].link.target()) {
            // At most one node per level waits, and all of them have different leaves.
            (stack[top], stack[top + 1]) = (first as usize + 1, first as usize);
            top += 2;
            continue;
        }
        let area = nodes[at].bounds.half_area();
        let cost = if area > 0.0 { subtrees[at].cost / area } else { 0.0 };
        let mut lane = lanes.count;
        while lane > 0 && cost.total_cmp(&lanes.roots[lane - 1].1).is_lt() {
            lanes.roots[lane] = lanes.roots[lane - 1];
            lane -= 1;
        }
        lanes.roots[lane] = (at, cost);
        lanes.count += 1;
    }
    lanes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, build_clustered};
    use crate::geometry::Aabb;

    const COSTS: Costs = Costs::TRIANGLES;

    /// Records the leaves.
    struct Leaves(Vec<std::ops::Range<u32>>);

    impl Items for Leaves {
        fn add(&mut self, range: std::ops::Range<u32>) -> std::ops::Range<u32> {
            self.0.push(range);
            self.0.len() as u32 - 1..self.0.len() as u32
        }

        fn part(&self) -> Self {
            Self(Vec::new())
        }

        fn append(&mut self, part: Self) {
            self.0.extend(part.0);
        }
    }

    /// The slow twin: the minimum over all ways to cut a subtree into leaves.
    fn naive_cost(binary: &Bvh, node: u32) -> (f32, u32) {
        let Node { bounds, link } = binary.nodes()[node as usize];
        let as_leaf = |count| bounds.half_area() * COSTS.of_leaf(count);
        match link.target() {
            Target::Primitives(range) => (as_leaf(range.len() as u32), range.len() as u32),
            Target::Node(first) => {
                let [left, right] = [0, 1].map(|child| naive_cost(binary, first + child));
                let count = left.1 + right.1;
                ((left.0 + right.0).min(as_leaf(count)), count)
            }
        }
    }

    #[test]
    fn leaves_are_those_of_minimum_cost_and_hold_all_primitives() {
        for (count, size) in (1..=LANES as u32).flat_map(|count| [0.0, 0.3, 2.0, 9.0].map(|size| (count, size))) {
            let at = |i: u32| [i % 3, i * i % 7, i * 5 % 11].map(|x| x as f32);
            let bounds_of = |i: u32| Aabb::new(at(i), at(i).map(|x| x + size * (1.0 + i as f32 * 0.1)));
            let binary =
                build_clustered(count as usize, bounds_of, &BuildOptions { max_leaf: 1, ..Default::default() });
            let mut leaves = Leaves(Vec::new());
            let tree = collapse_to_one_node(&binary, &COSTS, &mut leaves);
            assert_eq!(tree.validate(), Ok(()));
            let root = &tree.nodes()[0];
            let cost: f32 = root.lanes().map(|(lane, _)| root.bounds(lane).half_area()).sum();
            assert!((cost - naive_cost(&binary, 0).0).abs() <= 1e-5 * cost, "{count}, {size}");
            assert_eq!(leaves.0.iter().map(|leaf| leaf.len() as u32).sum::<u32>(), count);
        }
    }
}
