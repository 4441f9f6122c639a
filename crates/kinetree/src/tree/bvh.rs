//! A binary tree of boxes.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

use super::{Node, Target};
use crate::geometry::Aabb;

/// No path is longer than this: the fixed stacks of walks are large enough because of it.
pub const MAX_DEPTH: usize = 64;

/// A binary tree of boxes. Always:
/// 1. node 0 is the root;
/// 2. the two children of an inner node are neighbours;
/// 3. a child lies within its parent;
/// 4. every primitive is in exactly one leaf, or in several when `has_duplicates()`;
/// 5. no child stands before its parent, so a backwards walk refits;
/// 6. no path is longer than [`MAX_DEPTH`];
/// 7. pairs of children are numbered from 1 on: the first of a pair has an odd number, so nodes 2i
///    + 1 and 2i + 2 are pair i, and no number is left out.
///
/// A tree without primitives has no nodes.
#[doc(alias = "BLAS")]
#[doc(alias = "TLAS")]
#[derive(Clone)]
pub struct Bvh {
    nodes: Vec<Node>,
    primitives: Vec<u32>,
    /// How many different primitives the leaves hold.
    distinct: u32,
    topology: Topology,
}

/// Which links and leaves a tree has: equal for trees that differ in their boxes only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Topology(u64);

impl Topology {
    fn fresh() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// In short: how large it is.
impl fmt::Debug for Bvh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (nodes, primitives) = (self.node_count(), self.primitive_count());
        f.debug_struct("Bvh").field("nodes", &nodes).field("primitives", &primitives).finish_non_exhaustive()
    }
}

impl Default for Bvh {
    fn default() -> Self {
        Self { nodes: Vec::new(), primitives: Vec::new(), distinct: 0, topology: Topology(0) }
    }
}

impl Bvh {
    /// From parts that a builder made. Its promises are the builder's to keep; tests check them with `validate`.
    pub(crate) fn from_parts(nodes: Vec<Node>, primitives: Vec<u32>, distinct: u32) -> Self {
        Self { nodes, primitives, distinct, topology: Topology::fresh() }
    }

    /// Nodes, primitives, and how many different ones there are: what it was made from.
    pub(crate) fn into_parts(self) -> (Vec<Node>, Vec<u32>, u32) {
        (self.nodes, self.primitives, self.distinct)
    }

    /// All nodes; the root is the first.
    #[inline]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The root, unless the tree is empty.
    pub fn root(&self) -> Option<&Node> {
        self.nodes.first()
    }

    /// The box around everything.
    pub fn bounds(&self) -> Aabb {
        self.root().map_or(Aabb::EMPTY, |root| root.bounds)
    }

    /// Numbers of primitives in the order of the leaves.
    #[inline]
    pub fn primitives(&self) -> &[u32] {
        &self.primitives
    }

    /// How many different primitives there are.
    pub fn primitive_count(&self) -> usize {
        self.distinct as usize
    }

    /// Whether a primitive may be in several leaves.
    pub fn has_duplicates(&self) -> bool {
        self.primitives.len() > self.distinct as usize
    }

    /// How many nodes there are, leaves included.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Bytes held.
    pub fn heap_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.primitives.capacity() * size_of::<u32>()
    }

    /// The number of nodes on the longest path from the root, the root included.
    pub fn depth(&self) -> usize {
        let mut depth_of = vec![0_u32; self.nodes.len()];
        let mut deepest = 0;
        for (node, at) in self.nodes.iter().zip(0..) {
            // Promise 5: the parent has been here before.
            let depth: u32 = depth_of[at] + 1;
            deepest = deepest.max(depth);
            if let Target::Node(first) = node.link.target() {
                depth_of[first as usize] = depth;
                depth_of[first as usize + 1] = depth;
            }
        }
        deepest as usize
    }

    /// The same tree over primitives with other numbers.
    pub(crate) fn renumbered(mut self, number_of: &[u32]) -> Self {
        self.primitives.iter_mut().for_each(|primitive| *primitive = number_of[*primitive as usize]);
        self
    }

    /// Takes over links and leaves of another tree, if they are others, and gives the boxes out for writing.
    pub(crate) fn nodes_to_rewrite(&mut self, like: &Self) -> &mut Vec<Node> {
        if self.topology != like.topology {
            self.primitives.clone_from(&like.primitives);
            self.distinct = like.distinct;
            self.topology = like.topology;
            self.nodes.clear();
        }
        &mut self.nodes
    }
}
