//! Best matches among clusters that keep merging: a linear search while they are few, an index above.

use super::ClusteringWork;
use super::clusters::{Clusters, LANES, Match, Probe};
use super::index::Index;
use crate::geometry::Aabb;

/// The living clusters, and what helps to find best matches among them.
#[derive(Debug)]
pub(super) struct Search {
    clusters: Clusters,
    index: Option<Index>,
    /// Up to this many clusters, looking at each is faster.
    linear_up_to: usize,
    work: ClusteringWork,
}

impl Search {
    /// Each box a cluster of its own.
    pub(super) fn new(boxes: &[Aabb], linear_up_to: usize) -> Self {
        let mut search =
            Self { clusters: Clusters::new(boxes), index: None, linear_up_to, work: ClusteringWork::default() };
        search.rebuild_index();
        search
    }

    /// How many clusters are left.
    pub(super) fn alive(&self) -> usize {
        self.clusters.alive()
    }

    /// What has been done so far.
    pub(super) fn work(&self) -> ClusteringWork {
        self.work
    }

    /// The best match of a cluster, which must not be the only one. `known` is a partner that is known already, or
    /// [`Match::NONE`].
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

    /// Makes one cluster of two.
    pub(super) fn merge(&mut self, a: u32, b: u32) {
        let (box_a, box_b) = (self.clusters.bounds(a), self.clusters.bounds(b));
        // The larger box stays where it is: there the joint box is least of a surprise.
        let (stays, goes) = if box_a.half_area() < box_b.half_area() { (b, a) } else { (a, b) };
        let (stays, goes) = (self.clusters.place(stays), self.clusters.place(goes));
        self.clusters.put(stays, &box_a.union(&box_b), a.min(b));
        match &mut self.index {
            Some(index) => {
                self.clusters.vacate(goes);
                index.update(&self.clusters, stays / LANES);
                index.update(&self.clusters, goes / LANES);
                if index.is_half_gone(&self.clusters) {
                    self.rebuild_index();
                }
            }
            None => self.clusters.swap_remove(goes),
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
