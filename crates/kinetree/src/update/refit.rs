//! Refitting a binary tree: new boxes for the same tree, whose primitives have moved. The slow twin
//! of the refit of eight-way trees (`wide/refit`).
//!
//! Leaf boxes are computed from their primitives, then the boxes of parents in one pass from the
//! last node to the first, because children come after their parents (promise 5).

use crate::geometry::Aabb;
use crate::tree::{Bvh, Target};

/// The tree `current`, with the present boxes of its primitives.
///
/// In a tree with duplicates, each leaf gets the whole boxes of its primitives: the tree stays
/// valid, but loses the gain of spatial splits.
pub fn refit(current: &Bvh, bounds_of: impl Fn(u32) -> Aabb) -> Bvh {
    let (mut nodes, primitives, distinct) = current.clone().into_parts();
    for at in (0..nodes.len()).rev() {
        nodes[at].bounds = match nodes[at].link.target() {
            Target::Node(first) => nodes[first as usize].bounds.union(&nodes[first as usize + 1].bounds),
            Target::Primitives(range) => {
                let primitives = &primitives[range.start as usize..range.end as usize];
                primitives.iter().fold(Aabb::EMPTY, |all, &primitive| all.union(&bounds_of(primitive)))
            }
        };
    }
    Bvh::from_parts(nodes, primitives, distinct)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, build_binned};

    fn boxes(count: u32, bend: f32) -> Vec<Aabb> {
        (0..count)
            .map(|i| {
                let at =
                    [(i % 17) as f32, (i / 17 % 13) as f32 + bend * (i % 5) as f32, (i / 221) as f32 * (1.0 + bend)];
                Aabb::from_points([at, at.map(|x| x + 0.7)])
            })
            .collect()
    }

    #[test]
    fn refit_restores_the_promises_and_leaves_the_old_tree_alone() {
        for count in [0, 1, 2, 500, 5000] {
            let (still, bent) = (boxes(count, 0.0), boxes(count, 3.0));
            let built = build_binned(still.len(), |i| still[i as usize], &BuildOptions::default());
            let before = built.nodes().to_vec();
            let refitted = refit(&built, |i| bent[i as usize]);
            assert_eq!(refitted.validate(), Ok(()));
            assert_eq!(refitted.bounds(), bent.iter().fold(Aabb::EMPTY, |all, one| all.union(one)));
            assert_eq!(refitted.primitives(), built.primitives());
            assert_eq!(built.nodes(), before);
        }
    }

    #[test]
    fn a_refitted_leaf_is_as_small_as_its_primitives() {
        let (still, bent) = (boxes(300, 0.0), boxes(300, 1.5));
        let built = build_binned(300, |i| still[i as usize], &BuildOptions::default());
        let refitted = refit(&built, |i| bent[i as usize]);
        for node in refitted.nodes() {
            if let Target::Primitives(range) = node.link.target() {
                let primitives = &refitted.primitives()[range.start as usize..range.end as usize];
                let tight = primitives.iter().fold(Aabb::EMPTY, |all, &i| all.union(&bent[i as usize]));
                assert_eq!(node.bounds, tight);
            }
        }
    }

    #[test]
    fn the_cost_rises_when_neighbours_part_and_not_when_all_move_together() {
        let row = |x: fn(u32) -> f32| move |i: u32| Aabb::from_points([[x(i), 0.0, 0.0], [x(i) + 0.5, 1.0, 1.0]]);
        let built = build_binned(256, row(|i| i as f32), &BuildOptions::default());
        let ratio = |tree: &Bvh| tree.cost(1.0, 1.0) / built.cost(1.0, 1.0);
        assert!((ratio(&refit(&built, row(|i| i as f32 + 40.0))) - 1.0).abs() < 1e-3);
        assert!(ratio(&refit(&built, row(|i| (i * 97 % 256) as f32))) > 2.0);
    }
}
