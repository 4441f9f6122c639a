//! What a tree costs rays, beside how densely its triangles stand: both are needed to tell a tree
//! that has degraded from a pose that is expensive for every tree.

use super::mesh_bvh::COSTS;
use super::{MeshBvh, TriangleBlock};
use crate::geometry::Aabb;
use crate::threads::Threads;

/// Nodes or blocks that one thread adds up. The sums are the same for any number of threads.
const GRAIN: usize = 4096;

/// Measured over a pose whose root has an area. Both figures are expectations over random lines
/// that cross the root's box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RayCost {
    /// The work of a ray, in visits of nodes and tests of blocks, as weighed by the collapse of the
    /// tree.
    pub(crate) work: f64,
    /// How many of the triangles' boxes a line crosses: their summed areas over the root's area. It
    /// depends on the pose, not on the tree, but that triangles which spatial splits had cut count
    /// once per leaf.
    pub(crate) crossed: f64,
}

impl RayCost {
    /// `None` where a ratio would have no meaning: when the root, or all triangles together, have
    /// no area, or one that is not finite.
    fn of_areas(root: &Aabb, weighed_boxes: f64, triangle_boxes: f64) -> Option<Self> {
        let root = f64::from(root.half_area());
        let has_area = root > 0.0 && root.is_finite() && triangle_boxes > 0.0;
        let cost = Self { work: f64::from(COSTS.node) + weighed_boxes / root, crossed: triangle_boxes / root };
        (has_area && cost.work.is_finite() && cost.crossed.is_finite() && cost.crossed > 0.0).then_some(cost)
    }
}

impl MeshBvh {
    /// What rays are expected to cost in this pose. After a refit it is known, otherwise the tree
    /// is walked.
    pub(crate) fn ray_cost(&self, threads: &Threads) -> Option<RayCost> {
        let sum = |a: f64, b: f64| a + b;
        let (boxes, triangles) = if self.chunks.is_empty() {
            let boxes = |nodes: &[super::WideNode]| -> f64 {
                nodes.iter().map(|node| node.cost_of_lanes(COSTS.node, COSTS.item)).sum()
            };
            let triangles =
                |blocks: &[TriangleBlock]| -> f64 { blocks.iter().map(TriangleBlock::triangle_box_areas).sum() };
            (
                threads.reduce(&self.tree.nodes, GRAIN, &boxes, &sum),
                threads.reduce(&self.blocks, GRAIN, &triangles, &sum),
            )
        } else {
            let of = |value: fn(&super::refit::ChunkBounds) -> f64| self.chunks.iter().map(value).sum();
            (of(|chunk| chunk.cost), of(|chunk| chunk.triangle_boxes))
        };
        RayCost::of_areas(&self.bounds(), boxes, triangles)
    }
}
