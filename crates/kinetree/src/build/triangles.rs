//! Trees over triangles: the builder for each quality.

use super::cluster::clustered_from_branches;
use super::reinsert::reinsert;
use super::small::{MAX_SMALL, build_small};
use super::{BuildOptions, Quality, build_clustered, build_spatial};
use crate::geometry::Triangles;
use crate::tree::Bvh;
use crate::wide::Costs;

/// The fraction of all nodes that reinsertion tries to move in each batch. The largest nodes matter
/// most; the cost of rays depends more on the number of batches than on their sizes (decision 13).
const FAST_BATCHES: [f32; 2] = [0.04; 2];
const BALANCED_BATCHES: [f32; 4] = [0.1; 4];
const BEST_BATCHES: [f32; 5] = [0.1, 0.06, 0.06, 0.06, 0.04];

/// Builds a tree over all triangles. With [`Quality::Best`] a triangle may be in several leaves.
/// The tree does not depend on the number of threads.
///
/// # Panics
/// When there are more triangles than 2^27.
pub fn build_triangles(triangles: &Triangles, options: &BuildOptions) -> Bvh {
    // Leaves are as large as a block of the wide tree, whose test costs no more than a node: this
    // halves the number of nodes to reinsert and collapse.
    let costs = Costs::TRIANGLES;
    let (max_leaf, node_cost) = (costs.item_size as u32, costs.node_in_primitives());
    let full = BuildOptions { max_leaf, node_cost, ..options.clone() };
    let bounds_of = |triangle| triangles.bounds_of(triangle);
    let clustered = || build_clustered(triangles.len(), bounds_of, &full);
    match options.quality {
        Quality::Fastest if triangles.len() <= MAX_SMALL => build_small(triangles),
        Quality::Fastest => clustered_from_branches(triangles.len(), bounds_of, &full),
        Quality::Fast => reinsert(clustered(), &FAST_BATCHES, &options.threads),
        Quality::Balanced => reinsert(clustered(), &BALANCED_BATCHES, &options.threads),
        Quality::Best => reinsert(build_spatial(triangles, &full), &BEST_BATCHES, &options.threads),
    }
}
