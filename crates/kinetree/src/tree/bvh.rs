//! A binary tree of boxes.

use std::fmt;

use super::{Node, Target};
use crate::geometry::Aabb;

/// The largest number of nodes on a path from the root. The fixed-size traversal stacks rely on it.
pub const MAX_DEPTH: usize = 64;

/// A binary tree of boxes. Always:
/// 1. node 0 is the root;
/// 2. the two children of an inner node are neighbours;
/// 3. a child lies within its parent;
/// 4. every primitive is in exactly one leaf, or in several when `has_duplicates()`;
/// 5. a child comes after its parent, so that refitting is one pass from the last node to the
///    first;
/// 6. no path is longer than [`MAX_DEPTH`];
/// 7. pair i of children is nodes 2i + 1 and 2i + 2: the first child of a pair has an odd index,
///    and every node but the root belongs to a pair.
///
/// A tree without primitives has no nodes.
#[doc(alias = "BLAS")]
#[doc(alias = "TLAS")]
#[derive(Clone, Default)]
pub struct Bvh {
    nodes: Vec<Node>,
    primitives: Vec<u32>,
    /// The number of distinct primitives in the leaves.
    distinct: u32,
}

/// Prints the sizes only.
impl fmt::Debug for Bvh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (nodes, primitives) = (self.node_count(), self.primitive_count());
        f.debug_struct("Bvh").field("nodes", &nodes).field("primitives", &primitives).finish_non_exhaustive()
    }
}

impl Bvh {
    /// A tree of the parts that a builder made. The builder must keep the promises; they are not
    /// checked here.
    pub(crate) fn from_parts(nodes: Vec<Node>, primitives: Vec<u32>, distinct: u32) -> Self {
        Self { nodes, primitives, distinct }
    }

    /// The arguments of [`Self::from_parts`]: nodes, primitives, and the number of distinct
    /// primitives.
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

    /// Primitive indices in the order of the leaves.
    #[inline]
    pub fn primitives(&self) -> &[u32] {
        &self.primitives
    }

    /// The number of distinct primitives.
    pub fn primitive_count(&self) -> usize {
        self.distinct as usize
    }

    /// Whether some primitive is in several leaves.
    pub fn has_duplicates(&self) -> bool {
        self.primitives.len() > self.distinct as usize
    }

    /// The number of nodes, leaves included.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Bytes of heap memory held.
    pub fn heap_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.primitives.capacity() * size_of::<u32>()
    }

    /// The number of nodes on the longest path from the root, the root included.
    pub fn depth(&self) -> usize {
        let mut depth_of = vec![0_u32; self.nodes.len()];
        let mut deepest = 0;
        for (node, at) in self.nodes.iter().zip(0..) {
            // Promise 5: the parent's depth is known.
            let depth: u32 = depth_of[at] + 1;
            deepest = deepest.max(depth);
            if let Target::Node(first) = node.link.target() {
                depth_of[first as usize] = depth;
                depth_of[first as usize + 1] = depth;
            }
        }
        deepest as usize
    }

    /// The same tree with each primitive index `i` replaced by `number_of[i]`.
    pub(crate) fn renumbered(mut self, number_of: &[u32]) -> Self {
        self.primitives.iter_mut().for_each(|primitive| *primitive = number_of[*primitive as usize]);
        self
    }
}
