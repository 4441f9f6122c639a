//! The expected cost of rays through a tree, and the density of its triangles: together they
//! distinguish a tree that has degraded from a pose that is expensive for every tree.

use super::costs::Costs;
use super::{MeshBvh, TriangleBlock};
use crate::geometry::Aabb;
use crate::threads::Threads;

/// Nodes or blocks per parallel task. The sums do not depend on the number of threads.
const GRAIN: usize = 4096;

/// The cost of a ray in one pose. Both figures are expectations over random lines that cross the
/// root's box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RayCost {
    /// The work of a ray: node visits and block tests, weighted with the costs of the collapse.
    pub(crate) work: f64,
    /// The number of triangle boxes that a line crosses: their summed areas over the root's area.
    /// It depends on the pose, not on the tree, except that triangles which spatial splits cut
    /// count once per leaf.
    pub(crate) crossed: f64,
}

impl RayCost {
    /// `None` if the area of the root or of all triangles is zero or not finite.
    fn of_areas(root: &Aabb, weighed_boxes: f64, triangle_boxes: f64) -> Option<Self> {
        let root = f64::from(root.half_area());
        let has_area = root > 0.0 && root.is_finite() && triangle_boxes > 0.0;
        let cost =
            Self { work: f64::from(Costs::TRIANGLES.node) + weighed_boxes / root, crossed: triangle_boxes / root };
        (has_area && cost.work.is_finite() && cost.crossed.is_finite() && cost.crossed > 0.0).then_some(cost)
    }
}

impl MeshBvh {
    /// The expected cost of rays in this pose: from the sums of the refit if there was one,
    /// otherwise from a pass over the tree.
    pub(crate) fn ray_cost(&self, threads: &Threads) -> Option<RayCost> {
        let sum = |a: f64, b: f64| a + b;
        let (boxes, triangles) = if self.chunks.is_empty() {
            let boxes = |nodes: &[super::WideNode]| -> f64 {
                nodes.iter().map(|node| node.cost_of_lanes(Costs::TRIANGLES.node, Costs::TRIANGLES.item)).sum()
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
