//! Bottom-up construction by merging, again and again, the two clusters whose joint box is smallest.
//!
//! Two ways make the same merges, ties included: [`naive`] looks at every pair for every merge and is the one to
//! believe; [`chain`] follows best matches from cluster to cluster until two choose each other, and finds a best
//! match with the help of an [`index`]. Both end in [`rebalance`], which turns the merges into a tree whose paths
//! are bounded.
//!
//! The distance of two clusters is the half area of their joint box. It is *reducible*: a union is never closer to
//! a third cluster than both its parts were. That holds for floats as it does for real numbers, since the union of
//! boxes is exact (it only selects among the bounds) and extents and areas are made of subtractions, products and
//! sums of non-negative values, each of which is monotone when correctly rounded. With ties broken by one total
//! order, that of [`dendrogram::Pair`], mutual best matches therefore stay mutual best matches whatever else is merged
//! first.
//!
//! Walter, Bala, Kulkarni and Pingali 2008, "Fast Agglomerative Clustering for Rendering".

mod chain;
mod clusters;
mod dendrogram;
mod index;
mod naive;
mod rebalance;
mod search;
#[cfg(test)]
mod tests;

use crate::geometry::Aabb;
use crate::tree::Bvh;

/// A tree made by clustering, with an account of how.
#[derive(Clone, Debug)]
pub struct Agglomerated {
    /// The tree: one primitive in each leaf, numbered like the boxes. Of two siblings, the left one holds the
    /// primitive with the smallest number, except in subtrees that were rebuilt.
    pub bvh: Bvh,
    /// What finding the merges took.
    pub work: ClusteringWork,
    /// How many subtrees were rebuilt by median splits, because greedy merging had made paths longer than a tree
    /// may have. Zero for nearly all input.
    pub rebalanced: usize,
}

/// What finding the merges took, in counts that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClusteringWork {
    /// Searches for the best match of one cluster.
    pub queries: u64,
    /// Joint areas of two clusters that were computed.
    pub distances: u64,
    /// Lower bounds on the joint area with a whole group of clusters that were computed.
    pub bounds: u64,
}

/// Clusters boxes into a tree, by following best matches.
///
/// Near `n log n` for boxes that are scattered as objects of a scene are, quadratic at worst. Boxes may be empty,
/// infinite or NaN; one that is inside out or has a NaN holds nothing, and gets an empty leaf.
///
/// # Panics
/// When there are more boxes than a tree has room for, half of [`Link::MAX_INDEX`](crate::tree::Link::MAX_INDEX).
pub fn agglomerate(boxes: &[Aabb]) -> Agglomerated {
    let (dendrogram, work) = chain::best_match_chain(boxes, chain::LINEAR_UP_TO);
    finished(boxes, &dendrogram, work)
}

/// Clusters boxes into the same tree by comparing all pairs before each merge: cubic, and short enough to be
/// believed.
///
/// # Panics
/// As [`agglomerate`].
pub fn agglomerate_naive(boxes: &[Aabb]) -> Agglomerated {
    let (dendrogram, work) = naive::naive(boxes);
    finished(boxes, &dendrogram, work)
}

fn finished(boxes: &[Aabb], dendrogram: &dendrogram::Dendrogram, work: ClusteringWork) -> Agglomerated {
    let (bvh, rebalanced) = rebalance::into_tree(dendrogram, boxes);
    Agglomerated { bvh, work, rebalanced }
}

/// The distance of two clusters: the half area of their joint box.
fn distance(a: &Aabb, b: &Aabb) -> f32 {
    a.union(b).half_area()
}

/// The box that clustering sees in the place of one it is given: never empty, and small enough that no extent
/// overflows, so that a distance is never NaN (it may be infinite).
///
/// A box that holds nothing is taken for the origin. The tree gets the boxes as they were given; this only decides
/// who is merged with whom.
fn clamped(given: &Aabb) -> Aabb {
    /// Extents of boxes within plus and minus this stay finite.
    const LIMIT: f32 = f32::MAX / 2.0;

    if !holds_something(given) {
        return Aabb::new([0.0; 3], [0.0; 3]);
    }
    // Adding zero makes zeros positive, so that no extent is -0 and equal distances have equal bits.
    let clamp = |x: f32| x.clamp(-LIMIT, LIMIT) + 0.0;
    Aabb::new(given.min.map(clamp), given.max.map(clamp))
}

/// Whether a box has a point. One that is inside out, or has a NaN, has none.
fn holds_something(given: &Aabb) -> bool {
    (0..3).all(|axis| given.min[axis] <= given.max[axis])
}
