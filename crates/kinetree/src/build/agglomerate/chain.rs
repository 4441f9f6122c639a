//! Clustering along nearest-neighbour chains: from A to its best match B, to B's best match C,
//! until two choose each other. Those are merged, and the chain before them stays valid, so that a
//! merge takes about three searches.
//!
//! Walter et al. 2008; the chain is that of Benzécri 1982 and Juan 1982 for reducible distances.

use super::ClusteringWork;
use super::clusters::Match;
use super::dendrogram::{Dendrogram, Pair};
use super::search::Search;
use crate::geometry::Aabb;

/// Up to this many clusters, a linear search is faster than the index. Measured: by a third for
/// 1000; limits from 1000 to 2000 give the same time for builds of 2000 to 10,000.
pub(super) const LINEAR_UP_TO: usize = 1500;

/// Makes the merges of the naive search, in another order. With at most `linear_up_to` clusters,
/// best matches are found by a linear search, which changes the work but not the result.
pub(super) fn best_match_chain(boxes: &[Aabb], linear_up_to: usize) -> (Dendrogram, ClusteringWork) {
    let mut dendrogram = Dendrogram::new(boxes.len());
    let mut search = Search::new(boxes, linear_up_to);
    // Each element is a cluster and the distance to the previous one. The pairs of successive
    // clusters strictly decrease in the order of pairs, so no cluster occurs twice and the chain
    // ends.
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
