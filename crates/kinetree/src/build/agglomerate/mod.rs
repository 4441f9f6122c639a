//! Bottom-up construction by agglomerative clustering: repeatedly merges the two clusters whose
//! joint box is smallest.
//!
//! Two algorithms make the same merges, ties included: `naive` examines every pair for every
//! merge and is the reference; [`chain`] follows best matches from cluster to cluster until two
//! choose each other, and finds best matches with an [`index`]. Both end in [`rebalance`], which
//! turns the merges into a tree of bounded depth.
//!
//! The distance of two clusters is the half area of their joint box. It is *reducible*: a union is
//! never closer to a third cluster than the nearer of its parts was. That holds for floats as for
//! real numbers, since the union of boxes is exact, and areas are differences, products and sums of
//! non-negative values, which are monotone when correctly rounded. With ties broken by the total
//! order of [`dendrogram::Pair`], mutual best matches therefore stay mutual best matches whatever
//! else is merged first.
//!
//! Walter, Bala, Kulkarni and Pingali 2008, "Fast Agglomerative Clustering for Rendering".

mod chain;
mod clusters;
mod dendrogram;
mod index;
#[cfg(any(test, feature = "twins"))]
mod naive;
mod rebalance;
mod search;
#[cfg(test)]
mod tests;

use crate::geometry::Aabb;
use crate::tree::Bvh;

/// A tree made by agglomerative clustering, with statistics.
#[derive(Clone, Debug)]
pub struct Agglomerated {
    /// The tree: one primitive per leaf, with the index of its box. Of two siblings, the left one
    /// contains the primitive with the smallest index, except in subtrees that were rebalanced.
    pub bvh: Bvh,
    /// The work of finding the merges.
    pub work: ClusteringWork,
    /// The number of subtrees that were rebuilt by median splits, because greedy merging had made
    /// paths longer than [`MAX_DEPTH`](crate::tree::MAX_DEPTH). Zero for nearly all input.
    pub rebalanced: usize,
}

/// The work of finding the merges, in counts that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClusteringWork {
    /// Searches for the best match of one cluster.
    pub queries: u64,
    /// Computed distances of two clusters.
    pub distances: u64,
    /// Computed lower bounds on the distances of a group of clusters.
    pub bounds: u64,
}

/// Builds a tree over boxes by agglomerative clustering, along nearest-neighbour chains.
///
/// Near `n log n` for boxes that are distributed like the objects of a scene, quadratic at worst.
/// Boxes may be empty, infinite or NaN; one that is inverted or has a NaN gets an empty leaf.
///
/// # Panics
/// When there are more boxes than half of [`Link::MAX_INDEX`](crate::tree::Link::MAX_INDEX).
pub fn agglomerate(boxes: &[Aabb]) -> Agglomerated {
    let (dendrogram, work) = chain::best_match_chain(boxes, chain::LINEAR_UP_TO);
    finished(boxes, &dendrogram, work)
}

/// The slow twin of [`agglomerate`]: the same tree, by examining all pairs before each merge.
/// Cubic.
///
/// # Panics
/// As [`agglomerate`].
#[cfg(any(test, feature = "twins"))]
pub fn agglomerate_naive(boxes: &[Aabb]) -> Agglomerated {
    let (dendrogram, work) = naive::naive(boxes);
    finished(boxes, &dendrogram, work)
}

fn finished(boxes: &[Aabb], dendrogram: &dendrogram::Dendrogram, work: ClusteringWork) -> Agglomerated {
    let (bvh, rebalanced) = rebalance::into_tree(dendrogram, boxes);
    Agglomerated { bvh, work, rebalanced }
}

/// The distance of two clusters: the half area of their union.
#[cfg(any(test, feature = "twins"))]
fn distance(a: &Aabb, b: &Aabb) -> f32 {
    a.union(b).half_area()
}

/// The box that stands for a given one in clustering: never empty, and small enough that no extent
/// overflows, so that a distance is never NaN (it may be infinite).
///
/// A box without a point is replaced by the origin. The tree gets the given boxes; this one is used
/// for choosing merges only.
fn clamped(given: &Aabb) -> Aabb {
    /// Extents of boxes within plus and minus this stay finite.
    const LIMIT: f32 = f32::MAX / 2.0;

    if !given.has_point() {
        return Aabb::new([0.0; 3], [0.0; 3]);
    }
    // Adding zero makes zeros positive, so that no extent is -0 and equal distances have equal
    // bits.
    let clamp = |x: f32| x.clamp(-LIMIT, LIMIT) + 0.0;
    Aabb::new(given.min.map(clamp), given.max.map(clamp))
}
