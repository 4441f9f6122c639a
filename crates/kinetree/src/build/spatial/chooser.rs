//! The choice between object splits and spatial splits.

use super::clipper::TriangleClipper;
use super::divide::divide;
use super::planes::best_plane;
use crate::build::BuildOptions;
use crate::build::cost::tests;
use crate::build::cut::{Chooser, Cut};
use crate::build::object_cut::ObjectCut;
use crate::build::reference::{Reference, bounds_of};
use crate::geometry::Aabb;
use crate::threads::Threads;

/// Spatial splits are tried where the sides of the best object split overlap by more than this
/// fraction of the root's area.
///
/// The value is that of Stich et al. 2009.
const MIN_OVERLAP: f32 = 1e-5;

/// Sets of at most this many references have no spatial splits: among so few, they are seldom
/// chosen (in one set of a hundred, without gain for rays), but would take more than half of the
/// build time.
const MAX_UNSPLIT_SET: usize = 128;

pub(super) struct SpatialChooser<'a> {
    clipper: TriangleClipper<'a>,
    /// Square metres.
    min_overlap: f32,
    node_cost: f32,
    leaf_limit: usize,
}

impl<'a> SpatialChooser<'a> {
    pub(super) fn new(references: &[Reference], clipper: TriangleClipper<'a>, options: &BuildOptions) -> Self {
        let root = bounds_of(references, &options.threads).half_area();
        Self {
            clipper,
            min_overlap: root * MIN_OVERLAP,
            node_cost: options.node_cost,
            leaf_limit: options.leaf_limit(),
        }
    }

    fn cut(&self, references: &mut [Reference], count: usize, bounds: &Aabb, threads: &Threads) -> Cut {
        // A node visit costs more than all the tests in it.
        if count <= self.leaf_limit && tests(count as u32) <= self.node_cost {
            return Cut::Leaf;
        }
        let spare = references.len() - count;
        let area = bounds.half_area();
        let object = ObjectCut::best(&mut references[..count], &tests, threads);
        let as_leaf =
            if count <= self.leaf_limit { area * (tests(count as u32) - self.node_cost) } else { f32::INFINITY };
        let to_beat = object.as_ref().map_or(as_leaf, |object| object.cost.min(as_leaf));
        let overlaps = object.as_ref().is_none_or(|object| object.overlap() > self.min_overlap);
        if spare > 0
            && (count > MAX_UNSPLIT_SET && overlaps && area.is_finite())
            && let Some(plane) = best_plane(&references[..count], bounds, spare, &self.clipper)
            && let Some(sides) = divide(references, count, &plane, to_beat, &self.clipper, threads)
        {
            return Cut::Sides(sides);
        }
        match object {
            Some(object) if object.cost < as_leaf => object.apply(&mut references[..count]),
            _ => Cut::Leaf,
        }
    }
}

impl Chooser for SpatialChooser<'_> {
    fn choose(&self, references: &mut [Reference], bounds: &Aabb, threads: &Threads) -> Cut {
        let count = references.len();
        self.cut(references, count, bounds, threads)
    }

    fn choose_with_spare(&self, references: &mut [Reference], count: usize, bounds: &Aabb, threads: &Threads) -> Cut {
        self.cut(references, count, bounds, threads)
    }
}
