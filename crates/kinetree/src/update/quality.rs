//! Drift: the cost of rays through a refitted tree relative to a good tree for the same pose.
//!
//! A refitted tree gives correct hits, but its boxes grow and overlap when neighbouring triangles
//! move apart. Drift is measured by the expected cost of the tree (compare Lauterbach et al. 2006,
//! "RT-DEFORM"), not guessed from the number of frames.
//!
//! The cost of a fresh tree changes with the pose too, so the plain ratio of costs misleads where
//! poses differ much. The density of the triangles corrects for some of that: the ratio is divided
//! by the fourth root of the ratio of triangle boxes crossed by a line. In a trial over 11 motions
//! this halved the false alarms of the plain ratio and missed none of its true ones; dividing by
//! the full ratio overcorrects.

use crate::tree::Bvh;
use crate::wide::RayCost;

/// Costs that a binary tree is judged by; only ratios matter.
const NODE_COST: f32 = 1.0;
const PRIMITIVE_COST: f32 = 1.0;

/// The estimated ratio of the cost of a ray now to its cost through a good tree for the present
/// pose. `good` is the cost when the tree was known to be good.
pub(super) fn estimated_drift(now: &RayCost, good: &RayCost) -> f64 {
    // Two square roots instead of `powf`, because they round the same on all platforms.
    let denser = (now.crossed / good.crossed).sqrt().sqrt();
    now.work / good.work / denser
}

/// How much more work a ray through `now` is expected to be than through `built`, as a ratio of
/// their costs. `None` where there is no such ratio: one of the roots has no area, or one that is
/// not finite.
pub fn drift(built: &Bvh, now: &Bvh) -> Option<f32> {
    let measured = |tree: &Bvh| {
        let area = tree.bounds().half_area();
        (area > 0.0 && area.is_finite()).then(|| tree.cost(NODE_COST, PRIMITIVE_COST))
    };
    let ratio = measured(now)? / measured(built)?;
    ratio.is_finite().then_some(ratio)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, build_binned};
    use crate::geometry::Aabb;
    use crate::threads::Threads;
    use crate::update::refit;

    #[test]
    fn a_tree_drifts_when_neighbours_part_and_not_when_all_move_together() {
        let row = |position: fn(u32) -> f32| {
            move |i: u32| Aabb::from_points([[position(i), 0.0, 0.0], [position(i) + 0.5, 1.0, 1.0]])
        };
        let built = build_binned(256, row(|i| i as f32), &BuildOptions::default());
        let mut spare = Bvh::default();
        refit(&built, &mut spare, row(|i| i as f32 + 40.0), &Threads::one());
        assert!((drift(&built, &spare).unwrap() - 1.0).abs() < 1e-3);
        refit(&built, &mut spare, row(|i| (i * 97 % 256) as f32), &Threads::one());
        assert!(drift(&built, &spare).unwrap() > 2.0);
    }

    #[test]
    fn there_is_no_drift_without_an_area() {
        let boxes = |size: f32| move |i: u32| Aabb::from_points([[i as f32 * size; 3], [(i + 1) as f32 * size; 3]]);
        let built = build_binned(64, boxes(1.0), &BuildOptions::default());
        assert_eq!(drift(&Bvh::default(), &Bvh::default()), None);
        for size in [0.0, 1e37] {
            let mut spare = Bvh::default();
            refit(&built, &mut spare, boxes(size), &Threads::one());
            assert_eq!((drift(&built, &spare), drift(&spare, &built)), (None, None), "{size}");
        }
    }

    #[test]
    fn a_pose_in_which_triangles_overlap_more_may_cost_more() {
        let cost = |work, crossed| RayCost { work, crossed };
        assert_eq!(estimated_drift(&cost(20.0, 3.0), &cost(20.0, 3.0)), 1.0);
        assert_eq!(estimated_drift(&cost(30.0, 3.0), &cost(20.0, 3.0)), 1.5);
        assert_eq!(estimated_drift(&cost(40.0, 48.0), &cost(20.0, 3.0)), 1.0);
        assert_eq!(estimated_drift(&cost(20.0, 3.0), &cost(20.0, 48.0)), 2.0);
    }
}
