//! The eight-way tree over triangles.

use std::fmt;
use std::sync::{Arc, OnceLock};

use super::collapse::collapse;
use super::costs::Costs;
use super::leaves::Leaves;
use super::refit::{ChunkBounds, Plan};
use super::{TriangleBlock, WideBvh};
use crate::geometry::{Aabb, Triangles};
use crate::memory::vec_in_large_pages;
use crate::threads::Threads;
use crate::tree::Bvh;

/// An eight-way tree whose leaves hold blocks of four triangles. Beside promises 1 to 7 of a
/// [`WideBvh`], always:
///
/// 8. every triangle is in a block that a leaf links to, or in several when spatial splits cut it;
/// 9. the box of a leaf contains the padded boxes of its triangles; for a triangle in several
///    leaves, the union of their boxes does;
/// 10. no box extends beyond the union of the padded boxes of all triangles.
#[doc(alias = "BLAS")]
#[derive(Clone, Default)]
pub struct MeshBvh {
    pub(super) tree: WideBvh,
    pub(super) blocks: Vec<TriangleBlock>,
    /// The number of distinct triangles in the leaves.
    pub(super) triangles: u32,
    /// Made by the first refit. Trees that share a plan have the same topology.
    pub(super) plan: OnceLock<Arc<Plan>>,
    /// The results of the refit that wrote this tree: one per chunk, then one for the nodes above
    /// them. Empty in a tree that was built.
    pub(super) chunks: Vec<ChunkBounds>,
}

/// Prints the sizes only.
impl fmt::Debug for MeshBvh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (nodes, triangles) = (self.node_count(), self.primitive_count());
        f.debug_struct("MeshBvh").field("nodes", &nodes).field("triangles", &triangles).finish_non_exhaustive()
    }
}

impl MeshBvh {
    /// Collapses a binary tree over triangles.
    ///
    /// # Panics
    /// When the tree refers to triangles that do not exist.
    pub fn new(binary: &Bvh, triangles: &Triangles) -> Self {
        Self::new_on(binary, triangles, &Threads::one())
    }

    /// As `new`, on `threads`. If the build is cancelled, the result is unspecified and must be
    /// dropped.
    pub(crate) fn new_on(binary: &Bvh, triangles: &Triangles, threads: &Threads) -> Self {
        let mut leaves = Leaves::of(binary);
        let tree = collapse(binary, &Costs::TRIANGLES, threads, &mut leaves);
        let blocks = leaves.blocks(triangles, threads);
        Self { tree, blocks, triangles: binary.primitive_count() as u32, ..Self::default() }
    }

    /// A tree of deserialized parts. Its items are the blocks.
    pub(super) fn from_parts(tree: WideBvh, blocks: Vec<TriangleBlock>, triangles: u32) -> Self {
        assert_eq!(tree.item_count(), blocks.len(), "each item is a block");
        Self { tree, blocks, triangles, ..Self::default() }
    }

    /// Copies the topology of another tree; the refit that follows writes corners and planes.
    pub(super) fn copy_topology_of(&mut self, other: &Self, plan: Arc<Plan>) {
        self.triangles = other.triangles;
        self.tree.items = other.tree.items;
        copy(&other.tree.nodes, &mut self.tree.nodes);
        copy(&other.blocks, &mut self.blocks);
        self.plan = OnceLock::from(plan);
    }

    /// The nodes.
    #[inline(always)]
    pub fn tree(&self) -> &WideBvh {
        &self.tree
    }

    /// The triangle blocks, in the order of the leaves.
    #[inline(always)]
    pub fn blocks(&self) -> &[TriangleBlock] {
        &self.blocks
    }

    /// The block of an item index in a leaf's link.
    #[inline(always)]
    pub(crate) fn block(&self, item: usize) -> &TriangleBlock {
        &self.blocks[item]
    }

    /// The box around everything.
    #[inline(always)]
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds()
    }

    /// The number of distinct triangles.
    pub fn primitive_count(&self) -> usize {
        self.triangles as usize
    }

    /// The number of nodes.
    pub fn node_count(&self) -> usize {
        self.tree.node_count()
    }

    /// The number of nodes on the longest path from the root.
    pub fn depth(&self) -> usize {
        self.tree.depth()
    }

    /// Bytes of heap memory held, triangles included.
    pub fn heap_bytes(&self) -> usize {
        self.tree.heap_bytes()
            + self.blocks.capacity() * size_of::<TriangleBlock>()
            + self.chunks.capacity() * size_of::<ChunkBounds>()
    }

    /// Bytes of heap memory held for refits, shared by all trees that were refitted from each
    /// other.
    pub fn refit_memory(&self) -> usize {
        self.plan.get().map_or(0, |plan| plan.heap_bytes())
    }

    /// The address and the size in bytes of the shared refit data, if there has been a refit.
    pub(crate) fn refit_plan(&self) -> Option<(*const (), usize)> {
        self.plan.get().map(|plan| (Arc::as_ptr(plan).cast(), plan.heap_bytes()))
    }

    /// The expected cost of a ray that hits the root, from the costs of a node visit and a block
    /// test.
    pub fn cost(&self, node_cost: f32, block_cost: f32) -> f32 {
        self.tree.cost(node_cost, block_cost)
    }

    /// See [`WideBvh::overlap`].
    pub fn overlap(&self) -> f32 {
        self.tree.overlap()
    }
}

/// Replaces the contents of `to`, in its own memory if the capacity suffices, otherwise in large
/// pages.
fn copy<T: Copy>(from: &[T], to: &mut Vec<T>) {
    if to.capacity() < from.len() {
        *to = vec_in_large_pages(from.len());
    }
    to.clear();
    to.extend_from_slice(from);
}
