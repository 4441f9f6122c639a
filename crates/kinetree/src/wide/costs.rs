//! The costs by which trees are built and collapsed: of a node, and of what is in leaves.

use super::block::BLOCK;

/// The costs of nodes and leaves, and the limits of leaves. Only ratios of costs matter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Costs {
    /// Of a visit of a wide node: eight box tests.
    pub(crate) node: f32,
    /// Of an item in a leaf: a block of triangles or an instance.
    pub(crate) item: f32,
    /// The largest number of primitives in an item.
    pub(crate) item_size: usize,
    /// The largest number of items in a leaf.
    pub(crate) max_items: usize,
}

impl Costs {
    /// Of trees over triangles. Testing a block of four triangles is assumed to cost as much as
    /// testing eight boxes: both are one pass over a few cache lines with about as many vector
    /// instructions.
    pub(crate) const TRIANGLES: Self = Self { node: 1.0, item: 1.0, item_size: BLOCK, max_items: 4 };

    /// Of trees over instances. Entering an instance transforms the ray and visits at least one node
    /// of the mesh, so it is assumed to cost as much as three nodes, and each leaf has one.
    pub(crate) const INSTANCES: Self = Self { node: 1.0, item: 3.0, item_size: 1, max_items: 1 };

    /// The cost of a node in units of one primitive of a full item, for builders of binary trees.
    pub(crate) const fn node_in_primitives(&self) -> f32 {
        self.node / self.item * self.item_size as f32
    }

    #[inline(always)]
    pub(crate) fn of_leaf(&self, primitives: u32) -> f32 {
        self.item * self.items(primitives) as f32
    }

    #[inline(always)]
    pub(super) fn fits_a_leaf(&self, primitives: u32) -> bool {
        self.items(primitives) <= self.max_items
    }

    #[inline(always)]
    fn items(&self, primitives: u32) -> usize {
        (primitives as usize).div_ceil(self.item_size)
    }
}
