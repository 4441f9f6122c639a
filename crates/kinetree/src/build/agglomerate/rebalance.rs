//! Turning merges into a tree of bounded depth.
//!
//! Greedy merging may make a path as long as the list of boxes, for instance when all are equal. A
//! subtree that is too deep is kept down to the depth where its leaves still fit a balanced tree,
//! and is rebuilt from there by halving the list of its leaves, in the order of the merges.

use super::dendrogram::Dendrogram;
use crate::geometry::Aabb;
use crate::tree::{Bvh, Link, MAX_DEPTH, Node, Target};

/// The tree of a dendrogram, and the number of subtrees that were rebalanced.
///
/// A box that contains no point gets an empty leaf.
pub(super) fn into_tree(dendrogram: &Dendrogram, boxes: &[Aabb]) -> (Bvh, usize) {
    let Some(merge_tree) = MergeTree::new(dendrogram) else { return (Bvh::default(), 0) };
    let mut writer = Writer {
        merge_tree: &merge_tree,
        nodes: Vec::with_capacity(2 * dendrogram.leaves - 1),
        primitives: Vec::with_capacity(dendrogram.leaves),
        rebalanced: 0,
    };
    writer.write();
    let Writer { mut nodes, primitives, rebalanced, .. } = writer;
    fit(&mut nodes, &primitives, boxes);
    (Bvh::from_parts(nodes, primitives, dendrogram.leaves as u32), rebalanced)
}

/// The merge tree. Clusters are numbered so that children come before parents: first the leaves,
/// then the merges.
struct MergeTree {
    leaves: usize,
    /// The two clusters of each merge.
    children: Vec<[u32; 2]>,
    /// Per merge, the number of leaves below.
    sizes: Vec<u32>,
    /// Per merge, the number of nodes on the longest path from it to a leaf.
    heights: Vec<u32>,
}

impl MergeTree {
    /// `None` without leaves.
    fn new(dendrogram: &Dendrogram) -> Option<Self> {
        let leaves = dendrogram.leaves;
        // The cluster that has this smallest leaf by now.
        let mut current: Vec<u32> = (0..leaves as u32).collect();
        let merges = dendrogram.merges.len();
        let mut merge_tree = Self {
            leaves,
            children: Vec::with_capacity(merges),
            sizes: Vec::with_capacity(merges),
            heights: Vec::with_capacity(merges),
        };
        for pair in &dendrogram.merges {
            let [left, right] = [pair.left, pair.right].map(|leaf| current[leaf as usize]);
            current[pair.left as usize] = (leaves + merge_tree.children.len()) as u32;
            merge_tree.sizes.push(merge_tree.size(left) + merge_tree.size(right));
            merge_tree.heights.push(1 + merge_tree.height(left).max(merge_tree.height(right)));
            merge_tree.children.push([left, right]);
        }
        (leaves > 0).then_some(merge_tree)
    }

    fn root(&self) -> u32 {
        (self.leaves + self.children.len() - 1) as u32
    }

    /// The two clusters that were merged; `None` for a leaf.
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

/// Writes nodes in depth-first order, with the two children of a node adjacent.
struct Writer<'a> {
    merge_tree: &'a MergeTree,
    nodes: Vec<Node>,
    primitives: Vec<u32>,
    rebalanced: usize,
}

impl Writer<'_> {
    fn write(&mut self) {
        self.add_node();
        // The cluster, the index of its node, and the number of nodes on the path to it.
        let mut pending = vec![(self.merge_tree.root(), 0, 1)];
        while let Some((cluster, at, depth)) = pending.pop() {
            let levels = MAX_DEPTH as u32 + 1 - depth;
            match self.merge_tree.children(cluster) {
                None => self.write_leaf(at, cluster),
                Some(children) if self.fits(cluster, children, levels) => {
                    let first = self.write_inner(at);
                    pending.push((children[1], first + 1, depth + 1));
                    pending.push((children[0], first, depth + 1));
                }
                Some(_) => {
                    self.rebalanced += 1;
                    self.write_balanced(at, &self.merge_tree.leaves_below(cluster));
                }
            }
        }
    }

    /// Whether this merge can be kept with paths of at most `levels` nodes from here: as it is, or
    /// with its children rebalanced.
    fn fits(&self, cluster: u32, children: [u32; 2], levels: u32) -> bool {
        self.merge_tree.height(cluster) <= levels
            || children.iter().all(|&child| balanced_height(self.merge_tree.size(child)) < levels)
    }

    /// Writes a balanced tree over the leaves. The recursion is as deep as the tree.
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
        let index = self.primitives.len() as u32;
        self.primitives.push(leaf);
        self.nodes[at].link = Link::primitives(index..index + 1);
    }

    /// Allocates two children and returns the index of the first.
    fn write_inner(&mut self, at: usize) -> usize {
        let first = self.nodes.len();
        self.nodes[at].link = Link::node(first as u32);
        self.add_node();
        self.add_node();
        first
    }

    /// Allocates a node that is written later.
    fn add_node(&mut self) {
        self.nodes.push(Node { bounds: Aabb::EMPTY, link: Link::node(0) });
    }
}

/// Computes the box of every node, from the last to the first, since children come after their
/// parents.
fn fit(nodes: &mut [Node], primitives: &[u32], boxes: &[Aabb]) {
    for at in (0..nodes.len()).rev() {
        nodes[at].bounds = match nodes[at].link.target() {
            Target::Node(first) => nodes[first as usize].bounds.union(&nodes[first as usize + 1].bounds),
            Target::Primitives(range) => {
                let given = &boxes[primitives[range.start as usize] as usize];
                if given.has_point() { *given } else { Aabb::EMPTY }
            }
        };
    }
}
