//! Top-down construction by the surface area heuristic, on a few planes per axis.
//!
//! A build takes a few passes over the references per level, and the trees are nearly as good as
//! those of a full sweep. Small sets are swept.
//!
//! Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies".

use super::BuildOptions;
use super::cut::{Chooser, Cut};
use super::grow::grow;
use super::object_cut::ObjectCut;
use super::reference::{Reference, references};
use crate::geometry::Aabb;
use crate::threads::Threads;
use crate::tree::Bvh;

/// Builds a tree over primitives 0 to `count - 1`, whose boxes `bounds_of` returns. Primitives with
/// an empty box are left out. The tree does not depend on the number of threads.
///
/// # Panics
/// When there are more primitives than 2^27.
pub fn build_binned(count: usize, bounds_of: impl Fn(u32) -> Aabb + Sync, options: &BuildOptions) -> Bvh {
    let references = references(count, 0, &bounds_of, &options.threads);
    grow(references, &Binned { node_cost: options.node_cost }, options)
}

struct Binned {
    node_cost: f32,
}

impl Chooser for Binned {
    fn choose(&self, references: &mut [Reference], bounds: &Aabb, threads: &Threads) -> Cut {
        let area = bounds.half_area();
        let as_leaf = area * references.len() as f32;
        match ObjectCut::best(references, &|count| count as f32, threads) {
            Some(cut) if cut.cost + self.node_cost * area < as_leaf => cut.apply(references),
            _ => Cut::Leaf,
        }
    }
}
