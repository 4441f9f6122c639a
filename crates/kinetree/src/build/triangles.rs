//! A tree over triangles, by the builder that suits the quality.

use super::cluster::clustered_from_branches;
use super::reinsert::reinsert;
use super::{BuildOptions, Quality, build_clustered, build_spatial};
use crate::geometry::Triangles;
use crate::tree::Bvh;

/// Shares of all nodes that reinsertion tries to move, batch by batch. It is the largest nodes that matter; how rays fare depends more on how many batches there
/// are than on their sizes (page 13 of the decisions).
const BATCHES_OF_THE_FAST: [f32; 2] = [0.04; 2];
const BATCHES: [f32; 4] = [0.1; 4];
const BATCHES_OF_THE_BEST: [f32; 5] = [0.1, 0.06, 0.06, 0.06, 0.04];

/// A tree over all triangles, some of which may stand in several leaves when the best is asked for. The same tree for any number of threads.
///
/// # Panics
/// When there are more triangles than 2^27.
pub fn build_triangles(triangles: &Triangles, options: &BuildOptions) -> Bvh {
    // Leaves as large as a block of the wide tree, where a box costs more than the tests behind it: half the nodes to be moved and collapsed.
    let full = BuildOptions { max_leaf: 4, node_cost: 4.0, ..options.clone() };
    let bounds_of = |triangle| triangles.bounds_of(triangle);
    let clustered = || build_clustered(triangles.len(), bounds_of, &full);
    match options.quality {
        Quality::Fastest => clustered_from_branches(triangles.len(), bounds_of, &full),
        Quality::Fast => reinsert(clustered(), &BATCHES_OF_THE_FAST, &options.threads),
        Quality::Balanced => reinsert(clustered(), &BATCHES, &options.threads),
        Quality::Best => reinsert(build_spatial(triangles, &full), &BATCHES_OF_THE_BEST, &options.threads),
    }
}
