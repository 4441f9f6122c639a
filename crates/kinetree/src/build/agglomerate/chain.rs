//! Clustering along chains of best matches: from A to its best match B, to B's best match C, until two choose each
//! other. Those are merged, and the chain before them still stands, so that about three searches go with each merge.
//!
//! Walter et al. 2008; the chain is that of Benzécri 1982 and Juan 1982 for reducible distances.

use super::ClusteringWork;
use super::clusters::Match;
use super::dendrogram::{Dendrogram, Pair};
use super::search::Search;
use crate::geometry::Aabb;

/// Up to this many clusters, looking at each beats the index: for 1000 by a third, while from 1000 to 2000 as the
/// limit builds of 2000 to 10,000 take the same time.
pub(super) const LINEAR_UP_TO: usize = 1500;

/// The merges of the naive search, in another order. Best matches are found by comparing every cluster when there
/// are at most `linear_up_to`, which changes the work and nothing else.
pub(super) fn best_match_chain(boxes: &[Aabb], linear_up_to: usize) -> (Dendrogram, ClusteringWork) {
    let mut dendrogram = Dendrogram::new(boxes.len());
    let mut search = Search::new(boxes, linear_up_to);
    // Each link is a cluster, and the distance to the one before. Pairs of neighbours come ever earlier in the order
    // of pairs, so no cluster is met twice and the chain ends.
    let mut chain: Vec<Match> = Vec::new();
    let mut start = 0;

    while search.alive() > 1 {
        let Some(&last) = chain.last() else {
            chain.push(Match { distance: f32::INFINITY, leaf: start });
            continue;
        };
        let before = match chain.len() {
            0 | 1 => Match::NONE,
            length => Match { distance: last.distance, leaf: chain[length - 2].leaf },
        };
        let best = search.best_match(last.leaf, before);
        if best.leaf != before.leaf {
            chain.push(best);
            continue;
        }
        search.merge(before.leaf, last.leaf);
        let pair = Pair::new(best.distance, before.leaf, last.leaf);
        dendrogram.merges.push(pair);
        chain.truncate(chain.len() - 2);
        start = pair.left;
    }
    (dendrogram, search.work())
}
