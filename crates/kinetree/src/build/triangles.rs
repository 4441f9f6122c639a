//! A tree over triangles, by the builder that suits the quality.

use super::reinsert::reinsert;
use super::{BuildOptions, Quality, binned, clustered, spatial};
use crate::geometry::Triangles;
use crate::tree::Bvh;

/// Shares of all nodes that reinsertion tries to move, batch by batch.
const BATCHES_OF_THE_FAST: [f32; 1] = [0.05];
const BATCHES: [f32; 2] = [0.1, 0.05];
const BATCHES_OF_THE_BEST: [f32; 3] = [0.1, 0.05, 0.05];

/// A tree over all triangles, some of which may stand in several leaves when the best is asked for. The same tree for any number of threads.
///
/// # Panics
/// When there are more triangles than 2^27.
pub fn triangles(triangles: &Triangles, options: &BuildOptions) -> Bvh {
    let clustered = |options| clustered(triangles.len(), |triangle| triangles.bounds_of(triangle), options);
    match options.quality {
        // Leaves as large as a block of the wide tree, where a box costs more than the tests behind it.
        Quality::Fastest => clustered(&BuildOptions { max_leaf: 4, node_cost: 4.0, ..options.clone() }),
        Quality::Fast => reinsert(clustered(options), &BATCHES_OF_THE_FAST, &options.threads),
        Quality::Balanced => {
            let whole = binned(triangles.len(), |triangle| triangles.bounds_of(triangle), options);
            reinsert(whole, &BATCHES, &options.threads)
        }
        Quality::Best => reinsert(spatial(triangles, options), &BATCHES_OF_THE_BEST, &options.threads),
    }
}
