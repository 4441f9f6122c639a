//! A tree over triangles, by the builder that suits the quality.

use super::reinsert::reinsert;
use super::{BuildOptions, Quality, binned, spatial};
use crate::geometry::Triangles;
use crate::tree::Bvh;

/// A tree over all triangles. The same tree for any number of threads.
pub fn triangles(triangles: &Triangles, options: &BuildOptions) -> Bvh {
    let whole = || binned(triangles.len(), |triangle| triangles.bounds_of(triangle), options);
    let var = |n: &str| {
        std::env::var(n).unwrap_or_default().split(',').filter_map(|x| x.parse::<f32>().ok()).collect::<Vec<_>>()
    };
    match options.quality {
        Quality::Fastest | Quality::Fast => whole(),
        Quality::Balanced => {
            let w = whole();
            reinsert(&w, &var("RB"), &options.threads).unwrap_or(w)
        }
        Quality::Best => {
            let w = spatial(triangles, options);
            reinsert(&w, &var("RS"), &options.threads).unwrap_or(w)
        }
    }
}
