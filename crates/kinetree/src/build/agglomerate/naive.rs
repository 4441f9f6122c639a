//! The slow twin of [`chain`](super::chain): finds the pair of smallest joint area, merges it,
//! repeats. Cubic.

use super::dendrogram::{Dendrogram, Pair};
use super::{ClusteringWork, clamped, distance};
use crate::geometry::Aabb;

/// Merges the closest pair of all until one cluster is left.
pub(super) fn naive(boxes: &[Aabb]) -> (Dendrogram, ClusteringWork) {
    let mut dendrogram = Dendrogram::new(boxes.len());
    let mut work = ClusteringWork::default();
    // Each cluster is at the index of its smallest leaf.
    let mut clusters: Vec<Option<Aabb>> = boxes.iter().map(|given| Some(clamped(given))).collect();

    while let Some(pair) = smallest_pair(&clusters, &mut work) {
        let (left, right) = (pair.left as usize, pair.right as usize);
        if let (Some(a), Some(b)) = (clusters[left], clusters[right].take()) {
            clusters[left] = Some(a.union(&b));
        }
        dendrogram.merges.push(pair);
    }
    (dendrogram, work)
}

/// The first of all pairs in their total order; `None` when fewer than two clusters are left.
fn smallest_pair(clusters: &[Option<Aabb>], work: &mut ClusteringWork) -> Option<Pair> {
    let mut smallest: Option<Pair> = None;
    for (a, box_a) in (0u32..).zip(clusters) {
        let Some(box_a) = box_a else { continue };
        for (b, box_b) in (0u32..).zip(clusters).skip(a as usize + 1) {
            let Some(box_b) = box_b else { continue };
            work.distances += 1;
            let pair = Pair::new(distance(box_a, box_b), a, b);
            if smallest.is_none_or(|so_far| pair < so_far) {
                smallest = Some(pair);
            }
        }
    }
    smallest
}
