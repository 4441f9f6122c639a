//! The search for best matches among merging clusters: linear for few, with an index for many.

use super::ClusteringWork;
use super::clusters::{Clusters, LANES, Match, Probe};
use super::index::Index;
use crate::geometry::Aabb;

/// The living clusters, and the index if there are many.
#[derive(Debug)]
pub(super) struct Search {
    clusters: Clusters,
    index: Option<Index>,
    /// Up to this many clusters, the search is linear.
    linear_up_to: usize,
    work: ClusteringWork,
}

impl Search {
    /// Makes each box a cluster.
    pub(super) fn new(boxes: &[Aabb], linear_up_to: usize) -> Self {
        let mut search =
            Self { clusters: Clusters::new(boxes), index: None, linear_up_to, work: ClusteringWork::default() };
        search.rebuild_index();
        search
    }

    /// The number of clusters that are left.
    pub(super) fn alive(&self) -> usize {
        self.clusters.alive()
    }

    /// The work so far.
    pub(super) fn work(&self) -> ClusteringWork {
        self.work
    }

    /// The best match of a cluster, which must not be the only one. `known` is a match that is
    /// already known, or [`Match::NONE`].
    pub(super) fn best_match(&mut self, leaf: u32, known: Match) -> Match {
        let probe = Probe { bounds: self.clusters.bounds(leaf), leaf };
        let mut best = known;
        self.work.queries += 1;
        match &mut self.index {
            Some(index) => index.best_match(&self.clusters, &probe, &mut best, &mut self.work),
            None => {
                self.work.distances += self.clusters.alive() as u64;
                self.clusters.scan_all(&probe, &mut best);
            }
        }
        best
    }

    /// Merges two clusters.
    pub(super) fn merge(&mut self, a: u32, b: u32) {
        let (box_a, box_b) = (self.clusters.bounds(a), self.clusters.bounds(b));
        // The union takes the slot of the larger box, where it changes the index least.
        let (kept, removed) = if box_a.half_area() < box_b.half_area() { (b, a) } else { (a, b) };
        let (kept, removed) = (self.clusters.slot(kept), self.clusters.slot(removed));
        self.clusters.put(kept, &box_a.union(&box_b), a.min(b));
        match &mut self.index {
            Some(index) => {
                self.clusters.vacate(removed);
                index.update(&self.clusters, kept / LANES);
                index.update(&self.clusters, removed / LANES);
                if index.is_half_gone(&self.clusters) {
                    self.rebuild_index();
                }
            }
            None => self.clusters.swap_remove(removed),
        }
    }

    fn rebuild_index(&mut self) {
        if self.clusters.alive() > self.linear_up_to {
            self.index = Some(Index::new(&mut self.clusters));
        } else if self.index.take().is_some() {
            let left: Vec<(u32, Aabb)> = self.clusters.iter().collect();
            self.clusters.refill(left.into_iter());
        }
    }
}
