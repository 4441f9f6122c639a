//! A wide tree over triangles, which stand in its leaves.

use std::sync::{Arc, OnceLock};

use super::block::BLOCK;
use super::collapse::{Costs, collapse};
use super::leaves::Leaves;
use super::refit::{Plan, Swept};
use super::{TriangleBlock, WideTree, WideViolation};
use crate::arena::with_room;
use crate::geometry::{Aabb, Triangles};
use crate::threads::Threads;
use crate::tree::Bvh;

/// Of a node and of a block, in the same units: a step over eight boxes is taken to cost as much as a test of four triangles.
pub(super) const COSTS: Costs = Costs { node: 1.0, unit: 1.0, unit_size: BLOCK, max_units: 4 };

/// An eight-way tree whose leaves hold blocks of four triangles.
#[doc(alias = "BLAS")]
#[derive(Debug, Clone, Default)]
pub struct WideMesh {
    pub(super) tree: WideTree,
    pub(super) blocks: Vec<TriangleBlock>,
    /// How many different triangles the leaves hold.
    triangles: u32,
    /// Made by the first refit. Trees with the same plan have the same shape.
    pub(super) plan: OnceLock<Arc<Plan>>,
    /// What the refit that wrote this tree found: of each chunk, and at last of the nodes above them. Nothing in a tree that was built.
    pub(super) chunks: Vec<Swept>,
}

impl WideMesh {
    /// Collapses a binary tree over triangles.
    ///
    /// # Panics
    /// When the tree is one over more triangles than there are.
    pub fn new(binary: &Bvh, triangles: &Triangles) -> Self {
        Self::new_watched(binary, triangles, &Threads::one())
    }

    /// The same on these threads. When cancelled, any tree at all.
    pub(crate) fn new_watched(binary: &Bvh, triangles: &Triangles, threads: &Threads) -> Self {
        let mut leaves = Leaves::of(binary);
        let tree = collapse(binary, &COSTS, threads, &mut leaves);
        let blocks = leaves.blocks(triangles, threads);
        Self { tree, blocks, triangles: binary.primitive_count() as u32, ..Self::default() }
    }

    /// From parts that were read. As many blocks as the tree has units.
    pub(super) fn from_parts(tree: WideTree, blocks: Vec<TriangleBlock>, triangles: u32) -> Self {
        assert_eq!(tree.unit_count(), blocks.len(), "each unit is a block");
        Self { tree, blocks, triangles, ..Self::default() }
    }

    /// Becomes a copy but for corners and planes, which a refit is going to write.
    pub(super) fn take_shape_of(&mut self, other: &Self, plan: Arc<Plan>) {
        self.triangles = other.triangles;
        self.tree.units = other.tree.units;
        copy(&other.tree.nodes, &mut self.tree.nodes);
        copy(&other.blocks, &mut self.blocks);
        self.plan = OnceLock::from(plan);
    }

    /// The nodes.
    #[inline(always)]
    pub fn tree(&self) -> &WideTree {
        &self.tree
    }

    /// The triangles, as the leaves hold them.
    #[inline(always)]
    pub fn blocks(&self) -> &[TriangleBlock] {
        &self.blocks
    }

    /// A block that a leaf of this tree leads to.
    #[inline(always)]
    pub(crate) fn block(&self, unit: usize) -> &TriangleBlock {
        &self.blocks[unit]
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
    pub fn memory(&self) -> usize {
        self.tree.memory()
            + self.blocks.capacity() * size_of::<TriangleBlock>()
            + self.chunks.capacity() * size_of::<Swept>()
    }

    /// Bytes held for refits, once for all trees that were refitted from each other.
    pub fn refit_memory(&self) -> usize {
        self.plan.get().map_or(0, |plan| plan.memory())
    }

    /// The expected cost of a ray that hits the root, in visits of nodes and tests of blocks.
    pub fn cost(&self, node_cost: f32, block_cost: f32) -> f32 {
        self.tree.cost(node_cost, block_cost)
    }

    /// See [`WideTree::overlap`].
    pub fn overlap(&self) -> f32 {
        self.tree.overlap()
    }

    /// Checks the promises of the tree, and that its boxes contain the triangles.
    ///
    /// # Errors
    /// The first promise that does not hold, and where.
    pub fn validate(&self) -> Result<(), WideViolation> {
        self.tree.validate()?;
        let mut numbers: Vec<u32> = self.blocks.iter().flat_map(|block| block.primitives()).copied().collect();
        numbers.sort_unstable();
        numbers.dedup();
        let violation = |promise, what, node, lane| Err(WideViolation { promise, what, node, lane });
        if numbers.len() != self.triangles as usize || self.tree.unit_count() != self.blocks.len() {
            return violation(4, "triangles that are in no leaf", 0, 0);
        }
        Ok(())
    }
}

/// Replaces the contents of `to`, in the memory that is there if it is enough, otherwise in large pages.
fn copy<T: Copy>(from: &[T], to: &mut Vec<T>) {
    if to.capacity() < from.len() {
        *to = with_room(from.len());
    }
    to.clear();
    to.extend_from_slice(from);
}
