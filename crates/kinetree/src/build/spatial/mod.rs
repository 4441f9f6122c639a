//! Spatial splits: a plane may divide a set of triangles, and triangles that it crosses are
//! referenced from both sides.
//!
//! The box of a long diagonal triangle is nearly empty. Without splits, such boxes overlap heavily;
//! spatial splits bound each part tightly, at the price of more references than triangles. The
//! number of references is chosen beforehand ([`budget`]), by how much of the boxes is empty; in
//! the worst scenes, triangles are also split before the build.
//!
//! Stich, Friedrich and Dietrich 2009, "Spatial Splits in Bounding Volume Hierarchies".

mod budget;
mod chooser;
mod divide;
mod clipper;
mod planes;

use super::BuildOptions;
use super::grow::grow_with_spare;
use super::reference::references;
use crate::geometry::Triangles;
use crate::tree::Bvh;
use budget::Budget;
use chooser::SpatialChooser;
use clipper::TriangleClipper;

/// Builds a tree over all triangles, some of which may be in several leaves. The tree does not
/// depend on the number of threads.
///
/// # Panics
/// When there are more triangles than 2^27.
pub fn build_spatial(triangles: &Triangles, options: &BuildOptions) -> Bvh {
    let threads = &options.threads;
    let clipper = TriangleClipper::of(triangles);
    let usual = Budget::usual(triangles.len());
    let whole = references(triangles.len(), usual, &|triangle| triangles.bounds_of(triangle), threads);
    let distinct = whole.len();
    let budget = Budget::of(&whole, triangles, threads);
    let (references, spare) = budget.pre_split(whole, &clipper, triangles, threads);
    let chooser = SpatialChooser::new(&references, clipper, options);
    grow_with_spare(references, distinct, spare, &chooser, options)
}
