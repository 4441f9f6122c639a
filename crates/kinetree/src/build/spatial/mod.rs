//! Spatial splits: a plane may cut a set of triangles in two, and triangles that it crosses stand on both sides.
//!
//! A long triangle that lies askew has a box that is nearly empty. A tree that keeps such boxes whole cannot tell neighbours apart; one that cuts them
//! bounds each piece tightly, at the price of more references than triangles. How many more is decided beforehand ([`budget`]), by how much
//! of the boxes is empty; the very worst are cut before all others.
//!
//! Stich, Friedrich and Dietrich 2009, "Spatial Splits in Bounding Volume Hierarchies".

mod budget;
mod chooser;
mod cost;
mod divide;
mod clipper;
mod planes;

use super::BuildOptions;
use super::grow::grow_with_room;
use super::reference::references;
use crate::geometry::Triangles;
use crate::tree::Bvh;
use budget::Budget;
use chooser::Chosen;
use clipper::TriangleClipper;

/// A tree over all triangles, some of which may stand in several leaves. The same tree for any number of threads.
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
    let (references, room) = budget.pre_split(whole, &clipper, triangles, threads);
    let chooser = Chosen::by(&references, clipper, options);
    grow_with_room(references, distinct, room, &chooser, options)
}
