//! The eight-way tree over instances.

use std::fmt;
use std::ops::Range;

use super::WideBvh;
use super::collapse::{Items, collapse};
use super::costs::Costs;
use crate::geometry::Aabb;
use crate::geometry::slab::FarRays;
use crate::threads::Threads;
use crate::tree::{Bvh, Violation};

/// An eight-way tree whose leaves are instance records.
#[doc(alias = "TLAS")]
#[derive(Clone, Default)]
pub struct TopLevelBvh {
    tree: WideBvh,
    instances: Vec<u32>,
    far: FarRays,
}

/// The indices of instances, in the order of the leaves.
struct Instances<'a> {
    primitives: &'a [u32],
    list: Vec<u32>,
}

impl Items for Instances<'_> {
    fn add(&mut self, places: Range<u32>) -> Range<u32> {
        let first = self.list.len() as u32;
        self.list.extend_from_slice(&self.primitives[places.start as usize..places.end as usize]);
        first..self.list.len() as u32
    }

    fn part(&self) -> Self {
        Self { primitives: self.primitives, list: Vec::new() }
    }

    fn append(&mut self, part: Self) {
        self.list.extend_from_slice(&part.list);
    }
}

/// Prints the sizes only.
impl fmt::Debug for TopLevelBvh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (nodes, instances) = (self.node_count(), self.instance_count());
        f.debug_struct("TopLevelBvh").field("nodes", &nodes).field("instances", &instances).finish_non_exhaustive()
    }
}

impl TopLevelBvh {
    /// Collapses a binary tree over instances with one instance per leaf. `far` is the additional
    /// error bound for rays with distant origins.
    pub(crate) fn new(binary: &Bvh, far: FarRays) -> Self {
        let mut instances =
            Instances { primitives: binary.primitives(), list: Vec::with_capacity(binary.primitives().len()) };
        let tree = collapse(binary, &Costs::INSTANCES, &Threads::one(), &mut instances);
        Self { tree, instances: instances.list, far }
    }

    /// Copies another tree, reusing memory; `far` replaces its error bound for rays with distant
    /// origins.
    pub(crate) fn copy_from(&mut self, other: &Self, far: FarRays) {
        self.tree.nodes.clone_from(&other.tree.nodes);
        self.tree.items = other.tree.items;
        self.tree.bounds = other.tree.bounds;
        self.instances.clone_from(&other.instances);
        self.far = far;
    }

    /// The additional error bound for rays with distant origins.
    #[inline(always)]
    pub(crate) fn far(&self) -> FarRays {
        self.far
    }

    /// The nodes.
    #[inline(always)]
    pub fn tree(&self) -> &WideBvh {
        &self.tree
    }

    /// Indices of instance records, in the order of the leaves.
    #[inline(always)]
    pub fn instances(&self) -> &[u32] {
        &self.instances
    }

    /// The box around everything.
    #[inline(always)]
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds()
    }

    /// The number of instances.
    pub fn instance_count(&self) -> usize {
        self.instances.len()
    }

    /// The number of nodes.
    pub fn node_count(&self) -> usize {
        self.tree.node_count()
    }

    /// The number of nodes on the longest path from the root.
    pub fn depth(&self) -> usize {
        self.tree.depth()
    }

    /// Bytes of heap memory held.
    pub fn heap_bytes(&self) -> usize {
        self.tree.heap_bytes() + self.instances.capacity() * size_of::<u32>()
    }

    /// The expected cost of a ray that hits the root, from the costs of a node visit and of
    /// entering an instance.
    pub fn cost(&self, node_cost: f32, instance_cost: f32) -> f32 {
        self.tree.cost(node_cost, instance_cost)
    }

    /// See [`WideBvh::overlap`].
    pub fn overlap(&self) -> f32 {
        self.tree.overlap()
    }

    /// Checks the promises of the tree.
    ///
    /// # Errors
    /// The first promise that is broken, and where.
    pub fn validate(&self) -> Result<(), Violation> {
        self.tree.validate()
    }
}
