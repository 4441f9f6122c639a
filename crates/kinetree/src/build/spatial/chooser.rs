//! Whole references to either side, or a plane through them?

use super::clipper::TriangleClipper;
use super::cost::tests;
use super::divide::divide;
use super::planes::best_plane;
use crate::build::BuildOptions;
use crate::build::cut::{Chooser, Cut};
use crate::build::object_cut::ObjectCut;
use crate::build::reference::{Reference, bounds_of};
use crate::geometry::Aabb;
use crate::threads::Threads;

/// Planes are looked for where the sides of the best cut between whole references overlap by more than this share of the root's area.
///
/// The value is that of Stich et al. 2009.
const OVERLAP_THAT_MATTERS: f32 = 1e-5;

/// Sets of at most this many are not cut: among so few, planes are seldom worth it (one set in a hundred is cut, and rays gain nothing), but would take more than
/// half of the time.
const TOO_FEW: usize = 128;

pub(super) struct Chosen<'a> {
    clipper: TriangleClipper<'a>,
    /// Square metres.
    overlap_that_matters: f32,
    node_cost: f32,
    leaf_limit: usize,
}

impl<'a> Chosen<'a> {
    pub(super) fn by(references: &[Reference], clipper: TriangleClipper<'a>, options: &BuildOptions) -> Self {
        let root = bounds_of(references, &options.threads).half_area();
        Self {
            clipper,
            overlap_that_matters: root * OVERLAP_THAT_MATTERS,
            node_cost: options.node_cost,
            leaf_limit: options.leaf_limit(),
        }
    }

    fn cut(&self, references: &mut [Reference], count: usize, bounds: &Aabb, threads: &Threads) -> Cut {
        // A box costs more than all the tests behind it.
        if count <= self.leaf_limit && tests(count as u32) <= self.node_cost {
            return Cut::Leaf;
        }
        let room = references.len() - count;
        let area = bounds.half_area();
        let object = ObjectCut::best(&mut references[..count], &tests, threads);
        let as_leaf =
            if count <= self.leaf_limit { area * (tests(count as u32) - self.node_cost) } else { f32::INFINITY };
        let to_beat = object.as_ref().map_or(as_leaf, |object| object.cost.min(as_leaf));
        let overlaps = object.as_ref().is_none_or(|object| object.overlap() > self.overlap_that_matters);
        if room > 0
            && (count > TOO_FEW && overlaps && area.is_finite())
            && let Some(plane) = best_plane(&references[..count], bounds, room, &self.clipper)
            && let Some(sides) = divide(references, count, &plane, to_beat, &self.clipper, threads)
        {
            return Cut::Sides(sides);
        }
        match object {
            Some(object) if object.cost < as_leaf => object.carry_out(&mut references[..count]),
            _ => Cut::Leaf,
        }
    }
}

impl Chooser for Chosen<'_> {
    fn choose(&self, references: &mut [Reference], bounds: &Aabb, threads: &Threads) -> Cut {
        let count = references.len();
        self.cut(references, count, bounds, threads)
    }

    fn choose_with_room(&self, references: &mut [Reference], count: usize, bounds: &Aabb, threads: &Threads) -> Cut {
        self.cut(references, count, bounds, threads)
    }
}
