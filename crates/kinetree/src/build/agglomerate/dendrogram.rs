//! The merges of a clustering, and the order that breaks ties.

use std::cmp::Ordering;

use crate::tree::Link;

/// Two clusters that may be merged, or were. A cluster is identified by its smallest leaf, which is
/// unique among the living clusters and does not depend on the order of merges.
///
/// Pairs are ordered by distance, then by the smaller leaf, then by the larger one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// Half area of the joint box; not NaN.
    pub(super) distance: f32,
    /// Smallest leaf of one cluster.
    pub(super) left: u32,
    /// Smallest leaf of the other, larger than `left`.
    pub(super) right: u32,
}

impl Pair {
    /// The pair of two distinct clusters, given in any order.
    pub(super) fn new(distance: f32, a: u32, b: u32) -> Self {
        Self { distance, left: a.min(b), right: a.max(b) }
    }
}

impl Ord for Pair {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_distance = self.distance.total_cmp(&other.distance);
        by_distance.then(self.left.cmp(&other.left)).then(self.right.cmp(&other.right))
    }
}

impl PartialOrd for Pair {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Pair {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Pair {}

/// All merges of a clustering, in the order in which they were made: `leaves - 1`, or none without
/// leaves.
#[derive(Clone, Debug)]
pub(super) struct Dendrogram {
    /// The number of boxes.
    pub(super) leaves: usize,
    /// The merged pairs.
    pub(super) merges: Vec<Pair>,
}

impl Dendrogram {
    /// No merges yet.
    ///
    /// # Panics
    /// When a tree over this many leaves would have more nodes than a link can address.
    pub(super) fn new(leaves: usize) -> Self {
        assert!(leaves <= Link::MAX_INDEX as usize / 2, "{leaves} leaves are more than a tree can have");
        Self { leaves, merges: Vec::with_capacity(leaves.saturating_sub(1)) }
    }

    /// The merges, sorted: the same list for two clusterings that made the same merges in different
    /// orders.
    #[cfg(test)]
    pub(super) fn sorted(&self) -> Vec<Pair> {
        let mut merges = self.merges.clone();
        merges.sort_unstable();
        merges
    }
}
