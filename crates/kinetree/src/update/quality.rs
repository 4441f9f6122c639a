//! How far a tree has drifted since it was built.
//!
//! A refitted tree is always right, but its boxes grow into each other when neighbours part. How much dearer its rays have become is measured
//! by its expected cost, not guessed from the number of frames (compare Lauterbach et al. 2006, "RT-DEFORM").

use crate::tree::Bvh;
use crate::wide::WideMesh;

/// Costs that a binary tree is judged by; only ratios matter.
const NODE_COST: f32 = 1.0;
const PRIMITIVE_COST: f32 = 1.0;

/// What drift is measured against: the expected cost of a tree as it was built.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BuildCost(f32);

impl BuildCost {
    pub(crate) fn of(tree: &WideMesh) -> Self {
        Self(tree.expected_cost())
    }

    /// The expected cost of a ray now over that at the build: 1 when nothing got worse.
    pub(crate) fn drift(self, now: &WideMesh) -> f32 {
        ratio(now.expected_cost(), self.0)
    }
}

/// How much dearer a ray through `now` is expected to be than through `built`, as a ratio.
pub fn drift(built: &Bvh, now: &Bvh) -> f32 {
    ratio(now.cost(NODE_COST, PRIMITIVE_COST), built.cost(NODE_COST, PRIMITIVE_COST))
}

fn ratio(now: f32, built: f32) -> f32 {
    if built > 0.0 { now / built } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, binned};
    use crate::geometry::Aabb;
    use crate::threads::Threads;
    use crate::update::refit;

    #[test]
    fn a_tree_drifts_when_neighbours_part_and_not_when_all_move_together() {
        let row =
            |place: fn(u32) -> f32| move |i: u32| Aabb::from_points([[place(i), 0.0, 0.0], [place(i) + 0.5, 1.0, 1.0]]);
        let built = binned(256, row(|i| i as f32), &BuildOptions::default());
        let mut spare = Bvh::default();
        refit(&built, &mut spare, row(|i| i as f32 + 40.0), &Threads::one());
        assert!((drift(&built, &spare) - 1.0).abs() < 1e-3);
        refit(&built, &mut spare, row(|i| (i * 97 % 256) as f32), &Threads::one());
        assert!(drift(&built, &spare) > 2.0);
        assert_eq!(drift(&Bvh::default(), &Bvh::default()), 1.0);
    }
}
