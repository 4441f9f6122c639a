//! A tree over triangles, by the builder that suits the quality.

use super::{BuildOptions, Quality, binned};
use crate::geometry::Triangles;
use crate::tree::Bvh;

/// A tree over all triangles. The same tree for any number of threads.
pub fn triangles(triangles: &Triangles, options: &BuildOptions) -> Bvh {
    match options.quality {
        Quality::Fastest | Quality::Fast | Quality::Balanced | Quality::Best => {
            binned(triangles.len(), |triangle| triangles.bounds_of(triangle), options)
        }
    }
}
