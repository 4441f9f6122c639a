//! The merges that a clustering made, and the order that decides between equally good ones.

use std::cmp::Ordering;

use crate::tree::Link;

/// Two clusters that may be merged, or were. A cluster is known by the smallest number among its leaves, which no
/// other cluster shares while it lives, and which does not depend on the order in which merges were made.
///
/// Pairs are ordered by distance, then by the smaller leaf, then by the larger one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// Half area of the joint box; not NaN.
    pub(super) distance: f32,
    /// Smallest leaf of the one cluster.
    pub(super) left: u32,
    /// Smallest leaf of the other, larger than `left`.
    pub(super) right: u32,
}

impl Pair {
    /// The pair of two different clusters, named in any order.
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

/// All merges of a clustering, `leaves - 1` of them unless there are no leaves. Merges come in the order they were
/// made, so what is merged stands before the merge that uses it.
#[derive(Clone, Debug)]
pub(super) struct Dendrogram {
    /// How many boxes there were.
    pub(super) leaves: usize,
    /// Which clusters were merged.
    pub(super) merges: Vec<Pair>,
}

impl Dendrogram {
    /// Nothing merged yet.
    ///
    /// # Panics
    /// When a tree over so many leaves would have more nodes than a link can number.
    pub(super) fn new(leaves: usize) -> Self {
        assert!(leaves <= Link::MAX_INDEX as usize / 2, "a tree has no room for {leaves} leaves");
        Self { leaves, merges: Vec::with_capacity(leaves.saturating_sub(1)) }
    }

    /// The merges from small to large. Two clusterings that made the same merges give the same list, in whatever
    /// order they made them.
    #[cfg(test)]
    pub(super) fn sorted(&self) -> Vec<Pair> {
        let mut merges = self.merges.clone();
        merges.sort_unstable();
        merges
    }
}
