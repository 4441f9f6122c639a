//! Refitting: new boxes for the same tree, whose primitives have moved.
//!
//! Leaf boxes are computed from their primitives, then the boxes of parents in one pass from the
//! last node to the first, because children come after their parents (promise 5). The boxes are
//! written to another tree than the one whose links are read, so that queries of the old tree go on
//! undisturbed.

use crate::geometry::Aabb;
use crate::threads::Threads;
use crate::tree::{Bvh, Target};

/// Nodes per parallel task.
const GRAIN: usize = 4096;

/// Writes the tree `current`, with the present boxes of its primitives, to `spare`, whatever its
/// contents. If `spare` has the same topology, nothing is allocated.
///
/// In a tree with duplicates, each leaf gets the whole boxes of its primitives: the tree stays
/// valid, but loses the gain of spatial splits.
pub fn refit(current: &Bvh, spare: &mut Bvh, bounds_of: impl Fn(u32) -> Aabb + Sync, threads: &Threads) {
    let nodes = spare.nodes_to_rewrite(current);
    nodes.clear();
    nodes.extend_from_slice(current.nodes());
    threads.for_each(nodes, GRAIN, &|_, node| {
        if let Target::Primitives(range) = node.link.target() {
            let primitives = &current.primitives()[range.start as usize..range.end as usize];
            node.bounds = primitives.iter().fold(Aabb::EMPTY, |all, &primitive| all.union(&bounds_of(primitive)));
        }
    });
    for at in (0..nodes.len()).rev() {
        if let Target::Node(first) = nodes[at].link.target() {
            nodes[at].bounds = nodes[first as usize].bounds.union(&nodes[first as usize + 1].bounds);
        }
    }
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
            let mut spare = build_binned(3, |i| boxes(3, 1.0)[i as usize], &BuildOptions::default());
            for _ in 0..2 {
                refit(&built, &mut spare, |i| bent[i as usize], &Threads::default());
                assert_eq!(spare.validate(), Ok(()));
                assert_eq!(spare.bounds(), bent.iter().fold(Aabb::EMPTY, |all, one| all.union(one)));
                assert_eq!(spare.primitives(), built.primitives());
            }
            assert_eq!(built.nodes(), before);
        }
    }

    #[test]
    fn a_refitted_leaf_is_as_small_as_its_primitives() {
        let (still, bent) = (boxes(300, 0.0), boxes(300, 1.5));
        let built = build_binned(300, |i| still[i as usize], &BuildOptions::default());
        let mut spare = Bvh::default();
        refit(&built, &mut spare, |i| bent[i as usize], &Threads::one());
        for node in spare.nodes() {
            if let Target::Primitives(range) = node.link.target() {
                let primitives = &spare.primitives()[range.start as usize..range.end as usize];
                let tight = primitives.iter().fold(Aabb::EMPTY, |all, &i| all.union(&bent[i as usize]));
                assert_eq!(node.bounds, tight);
            }
        }
    }
}
