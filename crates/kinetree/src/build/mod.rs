//! Building binary trees.
//!
//! [`build_clustered()`] is for trees that are built while the game runs, [`build_spatial()`] for
//! trees that are built once. The top level takes [`agglomerate()`], over the boxes of instances,
//! or [`build_binned()`] where there are many.

mod agglomerate;
mod binned;
mod cluster;
mod cost;
mod cut;
mod fast_box;
mod grow;
mod morton;
mod object_cut;
mod options;
mod radix_sort;
mod reference;
mod reinsert;
mod small;
mod spatial;
mod triangles;
mod with_progress;

pub use crate::build_progress::{BuildProgress, Cancelled};
#[cfg(any(test, feature = "twins"))]
#[doc(hidden)]
pub use agglomerate::agglomerate_naive;
pub use agglomerate::{Agglomerated, ClusteringWork, agglomerate};
pub use binned::build_binned;
pub use cluster::build_clustered;
pub use options::{BuildOptions, Quality};
pub use spatial::build_spatial;
pub use triangles::build_triangles;
pub use with_progress::build_with_progress;
