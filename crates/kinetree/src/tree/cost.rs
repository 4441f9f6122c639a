//! The expected cost of a ray through a tree: the surface area heuristic over all nodes.

use super::{Bvh, Target};

impl Bvh {
    /// The expected cost of a ray that hits the root: node visits and primitive tests, each
    /// weighted by the probability that a random line through the root's box crosses the node's box
    /// (Goldsmith and Salmon 1987; MacDonald and Booth 1990). 0 for an empty tree; if the root has
    /// no area, every node has probability one.
    pub fn cost(&self, node_cost: f32, primitive_cost: f32) -> f32 {
        let root = f64::from(self.bounds().half_area());
        let probability = |area: f32| if root > 0.0 && root.is_finite() { f64::from(area) / root } else { 1.0 };
        let expected = self.nodes().iter().map(|node| {
            probability(node.bounds.half_area())
                * match node.link.target() {
                    Target::Node(_) => f64::from(node_cost),
                    Target::Primitives(range) => f64::from(primitive_cost) * range.len() as f64,
                }
        });
        expected.sum::<f64>() as f32
    }

    /// How much siblings overlap: the summed area of the intersections of siblings' boxes over the
    /// root's area.
    pub fn overlap(&self) -> f32 {
        let root = f64::from(self.bounds().half_area());
        let shared = self.nodes().iter().map(|node| match node.link.target() {
            Target::Node(first) => {
                let (left, right) = (&self.nodes()[first as usize], &self.nodes()[first as usize + 1]);
                f64::from(left.bounds.intersection(&right.bounds).half_area())
            }
            Target::Primitives(_) => 0.0,
        });
        let shared = shared.sum::<f64>();
        if root > 0.0 && root.is_finite() { (shared / root) as f32 } else { 0.0 }
    }
}
