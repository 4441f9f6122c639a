//! A wide tree over triangles, which stand in its leaves.

use super::block::BLOCK;
use super::collapse::{Costs, collapse};
use super::{TriangleBlock, WideTree, WideViolation};
use crate::arena::with_room;
use crate::geometry::{Aabb, Triangles};
use crate::threads::Threads;
use crate::tree::Bvh;

/// Of a node and of a block, in the same units: a step over eight boxes is taken to cost as much as a test of four triangles.
const COSTS: Costs = Costs { node: 1.0, unit: 1.0, unit_size: BLOCK, max_units: 4 };

/// An eight-way tree whose leaves hold blocks of four triangles.
#[doc(alias = "BLAS")]
#[derive(Debug, Clone, Default)]
pub struct WideMesh {
    tree: WideTree,
    blocks: Vec<TriangleBlock>,
    /// How many different triangles the leaves hold.
    triangles: u32,
}

impl WideMesh {
    /// Collapses a binary tree over triangles.
    ///
    /// # Panics
    /// When the tree is one over more triangles than there are.
    pub fn new(binary: &Bvh, triangles: &Triangles) -> Self {
        Self::new_watched(binary, triangles, &Threads::one())
    }

    /// The same for whoever watches these threads; nothing is shared between them. When cancelled, any tree at all.
    pub(crate) fn new_watched(binary: &Bvh, triangles: &Triangles, threads: &Threads) -> Self {
        let mut blocks = with_room(binary.primitives().len() / 2 + 1);
        let mut distinct: Vec<u32> = Vec::new();
        let tree = collapse(binary, &COSTS, threads, |places| {
            let first = blocks.len() as u32;
            let mut primitives = &binary.primitives()[places.start as usize..places.end as usize];
            // Pieces of the same triangle may meet again in a leaf.
            if binary.has_duplicates() {
                distinct.clear();
                distinct.extend_from_slice(primitives);
                distinct.sort_unstable();
                distinct.dedup();
                primitives = &distinct;
            }
            blocks.extend(primitives.chunks(BLOCK).map(|four| TriangleBlock::new(four, |i| triangles.get(i))));
            first..blocks.len() as u32
        });
        blocks.shrink_to_fit();
        Self { tree, blocks, triangles: binary.primitive_count() as u32 }
    }

    /// From parts that were read. As many blocks as the tree has units.
    pub(super) fn from_parts(tree: WideTree, blocks: Vec<TriangleBlock>, triangles: u32) -> Self {
        assert_eq!(tree.unit_count(), blocks.len(), "each unit is a block");
        Self { tree, blocks, triangles }
    }

    /// The same tree for triangles that have moved, written into `spare`, whatever that held before. If it held a tree of the same size, nothing is
    /// allocated.
    pub(crate) fn refit_into(&self, spare: &mut Self, triangles: &Triangles) {
        spare.triangles = self.triangles;
        spare.blocks.clone_from(&self.blocks);
        spare.tree.nodes.clone_from(&self.tree.nodes);
        spare.tree.units = self.tree.units;
        let blocks = &mut spare.blocks;
        blocks.iter_mut().for_each(|block| block.move_to(|triangle| triangles.get(triangle)));
        spare.tree.refit(|unit| blocks[unit as usize].bounds());
        if spare.tree.nodes.is_empty() {
            spare.tree.bounds = Aabb::EMPTY;
        }
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
        self.tree.memory() + self.blocks.capacity() * size_of::<TriangleBlock>()
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
