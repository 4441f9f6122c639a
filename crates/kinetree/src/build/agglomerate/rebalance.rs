//! From merges to a tree with bounded paths.
//!
//! Greedy merging may make a path as long as there are boxes, when all are the same. A subtree that would be too
//! deep is kept down to where its leaves still have room for a balanced tree, and is rebuilt from there by halving
//! the list of its leaves, in the order in which the merges put them.

use super::dendrogram::Dendrogram;
use super::holds_something;
use crate::geometry::Aabb;
use crate::tree::{Bvh, Link, MAX_DEPTH, Node, Target};

/// The tree of a dendrogram, and how many of its subtrees were rebuilt.
///
/// A box that holds nothing gets an empty leaf.
pub(super) fn into_tree(dendrogram: &Dendrogram, boxes: &[Aabb]) -> (Bvh, usize) {
    let Some(shape) = Shape::new(dendrogram) else { return (Bvh::default(), 0) };
    let mut writer = Writer {
        shape: &shape,
        nodes: Vec::with_capacity(2 * dendrogram.leaves - 1),
        primitives: Vec::with_capacity(dendrogram.leaves),
        rebalanced: 0,
    };
    writer.write();
    let Writer { mut nodes, primitives, rebalanced, .. } = writer;
    fit(&mut nodes, &primitives, boxes);
    (Bvh::from_parts(nodes, primitives, dendrogram.leaves as u32), rebalanced)
}

/// Clusters numbered so that what is merged comes before the merge: first the leaves, then the merges.
struct Shape {
    leaves: usize,
    /// The two clusters of each merge.
    children: Vec<[u32; 2]>,
    /// Per merge, how many leaves there are below.
    sizes: Vec<u32>,
    /// Per merge, the number of nodes on the longest path from it to a leaf.
    heights: Vec<u32>,
}

impl Shape {
    /// `None` without leaves.
    fn new(dendrogram: &Dendrogram) -> Option<Self> {
        let leaves = dendrogram.leaves;
        // The cluster that has this smallest leaf by now.
        let mut current: Vec<u32> = (0..leaves as u32).collect();
        let merges = dendrogram.merges.len();
        let mut shape = Self {
            leaves,
            children: Vec::with_capacity(merges),
            sizes: Vec::with_capacity(merges),
            heights: Vec::with_capacity(merges),
        };
        for pair in &dendrogram.merges {
            let [left, right] = [pair.left, pair.right].map(|leaf| current[leaf as usize]);
            current[pair.left as usize] = (leaves + shape.children.len()) as u32;
            shape.sizes.push(shape.size(left) + shape.size(right));
            shape.heights.push(1 + shape.height(left).max(shape.height(right)));
            shape.children.push([left, right]);
        }
        (leaves > 0).then_some(shape)
    }

    fn root(&self) -> u32 {
        (self.leaves + self.children.len() - 1) as u32
    }

    /// The two clusters that were merged; none for a leaf.
    fn children(&self, cluster: u32) -> Option<[u32; 2]> {
        (cluster as usize).checked_sub(self.leaves).map(|merge| self.children[merge])
    }

    fn size(&self, cluster: u32) -> u32 {
        (cluster as usize).checked_sub(self.leaves).map_or(1, |merge| self.sizes[merge])
    }

    fn height(&self, cluster: u32) -> u32 {
        (cluster as usize).checked_sub(self.leaves).map_or(1, |merge| self.heights[merge])
    }

    /// The leaves below, from left to right.
    fn leaves_below(&self, cluster: u32) -> Vec<u32> {
        let mut leaves = Vec::with_capacity(self.size(cluster) as usize);
        let mut pending = vec![cluster];
        while let Some(next) = pending.pop() {
            match self.children(next) {
                Some([left, right]) => pending.extend([right, left]),
                None => leaves.push(next),
            }
        }
        leaves
    }
}

/// The number of nodes on the longest path of a balanced tree.
fn balanced_height(leaves: u32) -> u32 {
    leaves.next_power_of_two().trailing_zeros() + 1
}

/// Writes nodes in depth-first order, the two children of a node side by side.
struct Writer<'a> {
    shape: &'a Shape,
    nodes: Vec<Node>,
    primitives: Vec<u32>,
    rebalanced: usize,
}

impl Writer<'_> {
    fn write(&mut self) {
        self.add_node();
        // Cluster, the node it gets, and the number of nodes on the path there.
        let mut pending = vec![(self.shape.root(), 0, 1)];
        while let Some((cluster, at, depth)) = pending.pop() {
            let room = MAX_DEPTH as u32 + 1 - depth;
            match self.shape.children(cluster) {
                None => self.write_leaf(at, cluster),
                Some(children) if self.fits(cluster, children, room) => {
                    let first = self.write_inner(at);
                    pending.push((children[1], first + 1, depth + 1));
                    pending.push((children[0], first, depth + 1));
                }
                Some(_) => {
                    self.rebalanced += 1;
                    self.write_balanced(at, &self.shape.leaves_below(cluster));
                }
            }
        }
    }

    /// Whether this merge can stand, with a path of at most `room` nodes from here: as it is, or with something
    /// rebuilt below.
    fn fits(&self, cluster: u32, children: [u32; 2], room: u32) -> bool {
        self.shape.height(cluster) <= room
            || children.iter().all(|&child| balanced_height(self.shape.size(child)) < room)
    }

    /// Splits at the middle until one is left. The recursion is as deep as the tree it makes.
    fn write_balanced(&mut self, at: usize, leaves: &[u32]) {
        if let [leaf] = leaves {
            self.write_leaf(at, *leaf);
            return;
        }
        let first = self.write_inner(at);
        let (left, right) = leaves.split_at(leaves.len().div_ceil(2));
        self.write_balanced(first, left);
        self.write_balanced(first + 1, right);
    }

    fn write_leaf(&mut self, at: usize, leaf: u32) {
        let place = self.primitives.len() as u32;
        self.primitives.push(leaf);
        self.nodes[at].link = Link::primitives(place..place + 1);
    }

    /// Makes two children, and gives the place of the first.
    fn write_inner(&mut self, at: usize) -> usize {
        let first = self.nodes.len();
        self.nodes[at].link = Link::node(first as u32);
        self.add_node();
        self.add_node();
        first
    }

    /// A node that is yet to be filled in.
    fn add_node(&mut self) {
        self.nodes.push(Node { bounds: Aabb::EMPTY, link: Link::node(0) });
    }
}

/// Gives every node its box, leaves first. No child stands before its parent.
fn fit(nodes: &mut [Node], primitives: &[u32], boxes: &[Aabb]) {
    for at in (0..nodes.len()).rev() {
        nodes[at].bounds = match nodes[at].link.target() {
            Target::Node(first) => nodes[first as usize].bounds.union(&nodes[first as usize + 1].bounds),
            Target::Primitives(places) => {
                let given = &boxes[primitives[places.start as usize] as usize];
                if holds_something(given) { *given } else { Aabb::EMPTY }
            }
        };
    }
}
