//! The eight-way tree, for any kind of items in its leaves.

use std::fmt;

use super::node::LANES;
use super::node_view::NodeArray;
use super::{WideNode, WideTarget};
use crate::geometry::Aabb;
use crate::tree::{Location, MAX_DEPTH, Violation};

/// The traversal stack that is always large enough: at most seven entries per level, and eight of
/// the last.
pub(crate) const WIDE_STACK: usize = (LANES - 1) * MAX_DEPTH + LANES;

/// An eight-way tree of boxes. Always:
/// 1. node 0 is the root;
/// 2. the lanes in use are the first ones, and there is at least one;
/// 3. the box of a lane contains all boxes of the node that it links to;
/// 4. every item is in exactly one leaf;
/// 5. a child comes after its parent, so that refitting is one pass from the last node to the
///    first; each node stores the lane of its parent that links to it;
/// 6. no path is longer than [`MAX_DEPTH`](crate::tree::MAX_DEPTH);
/// 7. nodes are in depth-first order: each node is followed by the subtrees of its lanes, in order,
///    and items are in the order of the leaves. So the nodes of a subtree are contiguous, and so
///    are its items.
///
/// A tree without items has no nodes.
#[derive(Clone, Default)]
pub struct WideBvh {
    pub(super) nodes: Vec<WideNode>,
    /// The number of items in the leaves.
    pub(super) items: u32,
    pub(super) bounds: Aabb,
}

/// Prints the sizes only.
impl fmt::Debug for WideBvh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (nodes, items) = (self.node_count(), self.item_count());
        f.debug_struct("WideBvh").field("nodes", &nodes).field("items", &items).finish_non_exhaustive()
    }
}

impl WideBvh {
    /// All nodes; the root is the first.
    #[inline(always)]
    pub fn nodes(&self) -> &[WideNode] {
        &self.nodes
    }

    /// All nodes as traversal reads them; `None` if there are none.
    #[inline(always)]
    pub(crate) fn rows(&self) -> Option<NodeArray<'_>> {
        NodeArray::new(bytemuck::cast_slice(&self.nodes))
    }

    /// The box around everything.
    #[inline(always)]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The box around everything, by reference.
    #[inline(always)]
    pub(crate) fn around(&self) -> &Aabb {
        &self.bounds
    }

    /// The number of items in the leaves.
    pub fn item_count(&self) -> usize {
        self.items as usize
    }

    /// The number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Bytes of heap memory held.
    pub fn heap_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<WideNode>()
    }

    /// The number of nodes on the longest path from the root.
    pub fn depth(&self) -> usize {
        let mut depth_of = vec![1_usize; self.nodes.len()];
        for (at, node) in self.nodes.iter().enumerate() {
            for (_, link) in node.lanes() {
                if let WideTarget::Node(child) = link.target() {
                    depth_of[child as usize] = depth_of[at] + 1;
                }
            }
        }
        depth_of.into_iter().max().unwrap_or(0)
    }

    /// The expected cost of a ray that hits the root: node visits and item tests, each weighted by
    /// the probability that a random line through the root's box crosses the lane's box.
    pub fn cost(&self, node_cost: f32, item_cost: f32) -> f32 {
        let root = f64::from(self.bounds.half_area());
        let probability = |area: f32| if root > 0.0 && root.is_finite() { f64::from(area) / root } else { 1.0 };
        let below = |node: &WideNode| -> f64 {
            node.lanes()
                .map(|(lane, link)| {
                    probability(node.bounds(lane).half_area())
                        * match link.target() {
                            WideTarget::Node(_) => f64::from(node_cost),
                            WideTarget::Items(items) => f64::from(item_cost) * items.len() as f64,
                        }
                })
                .sum()
        };
        let root_visit = if self.nodes.is_empty() { 0.0 } else { f64::from(node_cost) };
        (root_visit + self.nodes.iter().map(below).sum::<f64>()) as f32
    }

    /// How much siblings overlap: the summed area of the intersections of all pairs of siblings'
    /// boxes over the root's area.
    pub fn overlap(&self) -> f32 {
        let root = f64::from(self.bounds.half_area());
        let mut shared = 0.0;
        for node in &self.nodes {
            for (lane, _) in node.lanes() {
                for (other, _) in node.lanes().take_while(|(other, _)| *other < lane) {
                    shared += f64::from(node.bounds(lane).intersection(&node.bounds(other)).half_area());
                }
            }
        }
        if root > 0.0 && root.is_finite() { (shared / root) as f32 } else { 0.0 }
    }

    /// Checks promises 1 to 7.
    ///
    /// # Errors
    /// The first promise that is broken, and where.
    pub fn validate(&self) -> Result<(), Violation> {
        let mut depth_of = vec![0_usize; self.nodes.len()];
        let mut found = vec![false; self.items as usize];
        if let Some(root) = depth_of.first_mut() {
            *root = 1;
        }
        for (at, node) in self.nodes.iter().enumerate() {
            let violation = |promise, what, lane| Err(Violation::new(promise, what, Location::Lane { node: at, lane }));
            if depth_of[at] == 0 {
                return violation(5, "a node without a parent", 0);
            }
            if depth_of[at] > MAX_DEPTH {
                return violation(6, "a path that is too long", 0);
            }
            if node.in_use == 0 || node.in_use & node.in_use.wrapping_add(1) != 0 {
                return violation(2, "lanes with gaps, or none", 0);
            }
            for (lane, link) in node.lanes() {
                let bounds = node.bounds(lane);
                if bounds.min.iter().chain(&bounds.max).any(|x| x.is_nan()) {
                    return violation(3, "a box with a NaN", lane);
                }
                match link.target() {
                    WideTarget::Node(child) => {
                        let child = child as usize;
                        if child <= at || child >= self.nodes.len() || depth_of[child] != 0 {
                            return violation(5, "a child before its parent, with two parents, or nowhere", lane);
                        }
                        if self.nodes[child].parent_lane as usize != at * LANES + lane {
                            return violation(5, "a child that does not know its parent", lane);
                        }
                        if !bounds.contains(&self.nodes[child].all_bounds()) {
                            return violation(3, "a child that reaches out of its parent", lane);
                        }
                        depth_of[child] = depth_of[at] + 1;
                    }
                    WideTarget::Items(items) => {
                        for item in items {
                            match found.get_mut(item as usize) {
                                Some(found) if !*found => *found = true,
                                _ => return violation(4, "an item that is in two leaves, or nowhere", lane),
                            }
                        }
                    }
                }
            }
        }
        match found.iter().position(|found| !found) {
            Some(item) => Err(Violation::new(4, "an item in no leaf", Location::Item(item))),
            None if self.nodes.first().is_some_and(|root| !self.bounds.contains(&root.all_bounds())) => {
                Err(Violation::new(3, "a root that reaches out of the box around everything", Location::Node(0)))
            }
            None => self.check_order(),
        }
    }

    /// Checks promise 7, given the others.
    fn check_order(&self) -> Result<(), Violation> {
        let violation = |what, node, lane| Err(Violation::new(7, what, Location::Lane { node, lane }));
        let mut sizes = vec![1; self.nodes.len()];
        for at in (1..self.nodes.len()).rev() {
            sizes[self.nodes[at].parent_lane as usize / LANES] += sizes[at];
        }
        let mut next_item = 0;
        for (at, node) in self.nodes.iter().enumerate() {
            let mut next_node = at + 1;
            for (lane, link) in node.lanes() {
                match link.target() {
                    WideTarget::Node(child) if child as usize != next_node => {
                        return violation("a subtree that is not contiguous", at, lane);
                    }
                    WideTarget::Items(items) if items.start != next_item => {
                        return violation("items that are not in the order of their nodes", at, lane);
                    }
                    WideTarget::Node(child) => next_node += sizes[child as usize],
                    WideTarget::Items(items) => next_item = items.end,
                }
            }
        }
        Ok(())
    }
}
