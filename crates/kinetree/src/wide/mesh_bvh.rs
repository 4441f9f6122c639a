//! A wide tree over triangles, which stand in its leaves.

use std::fmt;
use std::sync::{Arc, OnceLock};

use super::block::BLOCK;
use super::collapse::{Costs, collapse};
use super::leaves::Leaves;
use super::refit::{ChunkBounds, Plan};
use super::{TriangleBlock, WideBvh};
use crate::geometry::{Aabb, Triangles};
use crate::memory::vec_in_large_pages;
use crate::threads::Threads;
use crate::tree::Bvh;

/// Of a node and of a block, in the same units: a step over eight boxes is taken to cost as much as a test of four triangles.
pub(super) const COSTS: Costs = Costs { node: 1.0, item: 1.0, item_size: BLOCK, max_items: 4 };

/// An eight-way tree whose leaves hold blocks of four triangles. Beside promises 1 to 7 of a
/// [`WideBvh`], always:
///
/// 8. every triangle is in a block that a leaf leads to, or in several when spatial splits cut it;
/// 9. the box of a leaf contains its triangles and what rays may miss them by; of a triangle in
///    several leaves, their boxes together do;
/// 10. no box reaches beyond the box around all triangles so widened.
#[doc(alias = "BLAS")]
#[derive(Clone, Default)]
pub struct MeshBvh {
    pub(super) tree: WideBvh,
    pub(super) blocks: Vec<TriangleBlock>,
    /// How many different triangles the leaves hold.
    pub(super) triangles: u32,
    /// Made by the first refit. Trees with the same plan have the same shape.
    pub(super) plan: OnceLock<Arc<Plan>>,
    /// What the refit that wrote this tree found: of each chunk, and at last of the nodes above them. Nothing in a tree that was built.
    pub(super) chunks: Vec<ChunkBounds>,
}

/// In short: how large it is.
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
    /// When the tree is one over more triangles than there are.
    pub fn new(binary: &Bvh, triangles: &Triangles) -> Self {
        Self::new_on(binary, triangles, &Threads::one())
    }

    /// The same on these threads. When cancelled, any tree at all.
    pub(crate) fn new_on(binary: &Bvh, triangles: &Triangles, threads: &Threads) -> Self {
        let mut leaves = Leaves::of(binary);
        let tree = collapse(binary, &COSTS, threads, &mut leaves);
        let blocks = leaves.blocks(triangles, threads);
        Self { tree, blocks, triangles: binary.primitive_count() as u32, ..Self::default() }
    }

    /// From parts that were read. As many blocks as the tree has items.
    pub(super) fn from_parts(tree: WideBvh, blocks: Vec<TriangleBlock>, triangles: u32) -> Self {
        assert_eq!(tree.item_count(), blocks.len(), "each item is a block");
        Self { tree, blocks, triangles, ..Self::default() }
    }

    /// Becomes a copy but for corners and planes, which a refit is going to write.
    pub(super) fn take_shape_of(&mut self, other: &Self, plan: Arc<Plan>) {
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

    /// The triangles, as the leaves hold them.
    #[inline(always)]
    pub fn blocks(&self) -> &[TriangleBlock] {
        &self.blocks
    }

    /// A block that a leaf of this tree leads to.
    #[inline(always)]
    pub(crate) fn block(&self, item: usize) -> &TriangleBlock {
        &self.blocks[item]
    }

    /// The box around everything.
    #[inline(always)]
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds()
    }

    /// How many different triangles there are.
    pub fn primitive_count(&self) -> usize {
        self.triangles as usize
    }

    /// How many nodes there are.
    pub fn node_count(&self) -> usize {
        self.tree.node_count()
    }

    /// The number of nodes on the longest path from the root.
    pub fn depth(&self) -> usize {
        self.tree.depth()
    }

    /// Bytes held, triangles included.
    pub fn heap_bytes(&self) -> usize {
        self.tree.heap_bytes()
            + self.blocks.capacity() * size_of::<TriangleBlock>()
            + self.chunks.capacity() * size_of::<ChunkBounds>()
    }

    /// Bytes held for refits, once for all trees that were refitted from each other.
    pub fn refit_memory(&self) -> usize {
        self.plan.get().map_or(0, |plan| plan.heap_bytes())
    }

    /// Where what is held for refits stands, and how many bytes it has, if there has been a refit.
    pub(crate) fn refit_plan(&self) -> Option<(*const (), usize)> {
        self.plan.get().map(|plan| (Arc::as_ptr(plan).cast(), plan.heap_bytes()))
    }

    /// The expected cost of a ray that hits the root, in visits of nodes and tests of blocks.
    pub fn cost(&self, node_cost: f32, block_cost: f32) -> f32 {
        self.tree.cost(node_cost, block_cost)
    }

    /// See [`WideBvh::overlap`].
    pub fn overlap(&self) -> f32 {
        self.tree.overlap()
    }
}

/// Replaces the contents of `to`, in the memory that is there if it is enough, otherwise in large pages.
fn copy<T: Copy>(from: &[T], to: &mut Vec<T>) {
    if to.capacity() < from.len() {
        *to = vec_in_large_pages(from.len());
    }
    to.clear();
    to.extend_from_slice(from);
}
