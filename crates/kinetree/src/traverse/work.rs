//! Counting what a walk does.

use std::fmt;
use std::ops::AddAssign;

/// Is told what a walk does. `()` does not care, and costs nothing.
pub(crate) trait Tally {
    /// A node was visited: in an eight-way tree one that is no leaf.
    fn node(&mut self) {}
    /// A leaf was reached.
    fn leaf(&mut self) {}
    /// A triangle was tested.
    fn triangle(&mut self) {}
    /// A block of triangles was tested.
    #[inline(always)]
    fn block(&mut self, triangles: u32) {
        (0..triangles).for_each(|_| self.triangle());
    }
    /// An instance was entered.
    fn instance(&mut self) {}
    /// The counters behind it, if there are any.
    fn work(&mut self) -> Option<&mut Work> {
        None
    }
}

impl Tally for () {}

/// How much work queries did: the measure of a tree that no noisy clock disturbs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Work {
    /// Nodes that were visited: steps over eight boxes, of which one or more may be entered; of a
    /// binary tree, boxes that were entered, those of leaves included.
    pub nodes: u64,
    /// Leaves reached, those of the tree over the instances included.
    pub leaves: u64,
    /// Blocks of triangles tested.
    pub blocks: u64,
    /// Triangles tested.
    pub triangles: u64,
    /// Instances entered.
    pub instances: u64,
}

impl Tally for Work {
    #[inline]
    fn node(&mut self) {
        self.nodes += 1;
    }

    #[inline]
    fn leaf(&mut self) {
        self.leaves += 1;
    }

    #[inline]
    fn triangle(&mut self) {
        self.triangles += 1;
    }

    #[inline]
    fn block(&mut self, triangles: u32) {
        self.blocks += 1;
        self.triangles += u64::from(triangles);
    }

    #[inline]
    fn instance(&mut self) {
        self.instances += 1;
    }

    #[inline]
    fn work(&mut self) -> Option<&mut Self> {
        Some(self)
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, more: Self) {
        self.nodes += more.nodes;
        self.leaves += more.leaves;
        self.blocks += more.blocks;
        self.triangles += more.triangles;
        self.instances += more.instances;
    }
}

impl fmt::Display for Work {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { nodes, leaves, blocks, triangles, instances } = self;
        write!(f, "{nodes} nodes, {leaves} leaves, {blocks} blocks, {triangles} triangles, {instances} instances")
    }
}
