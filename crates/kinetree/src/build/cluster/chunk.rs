//! Clustering a stretch of the curve: every branch of the tree that the codes make is merged down to a few clusters before its parent is.

use super::front::{FEW, FULL, Front, Merger, NEAR, RADIUS};
use super::pair::{Cluster, Kind, Pair};
use crate::geometry::Aabb;
use crate::simd::Level;

/// A stretch of the curve, and what became of it.
pub(super) struct Chunk<'a> {
    /// Sorted. Each key holds a primitive in its lower bits; when the chunk is done they are links of chains (see [`Kind::chained`]).
    pub(super) keys: &'a mut [u64],
    pub(super) pairs: Vec<Pair>,
    /// What is left, at least one.
    pub(super) clusters: Vec<Cluster>,
}

/// What a build knows.
pub(super) struct Task<'a> {
    pub(super) boxes: &'a [Aabb],
    /// The bits of a key that hold the primitive.
    pub(super) primitive_mask: u64,
    pub(super) leaf_limit: u32,
    pub(super) node_cost: f32,
    pub(super) level: Level,
}

/// Where a branch of sorted, different keys parts in two: after the last key that has a zero at the first bit in which they differ.
pub(super) fn fork(keys: &[u64]) -> usize {
    let (first, last) = (keys[0], keys[keys.len() - 1]);
    let bit = 63 - (first ^ last).leading_zeros();
    keys.partition_point(|key| key >> bit & 1 == 0)
}

impl Chunk<'_> {
    pub(super) fn cluster(&mut self, task: &Task<'_>) {
        self.pairs.reserve(self.keys.len());
        let mut work = Work { task, keys: self.keys, pairs: &mut self.pairs, front: Front::new(), waiting: Vec::new() };
        work.branch(0, work.keys.len());
        self.clusters = work.waiting;
    }
}

struct Work<'a> {
    task: &'a Task<'a>,
    keys: &'a mut [u64],
    pairs: &'a mut Vec<Pair>,
    front: Front,
    /// Clusters of branches whose parents are still to come.
    waiting: Vec<Cluster>,
}

impl Work<'_> {
    /// Leaves the clusters of a branch at the end of `waiting`.
    fn branch(&mut self, start: usize, end: usize) {
        let before = self.waiting.len();
        self.front.clear();
        if end - start <= FULL {
            for place in start..end {
                let primitive = self.keys[place] & self.task.primitive_mask;
                self.keys[place] = primitive;
                self.front.push(&Cluster { bounds: self.task.boxes[primitive as usize], kind: Kind::single(place) });
            }
        } else {
            let middle = start + fork(&self.keys[start..end]);
            self.branch(start, middle);
            self.branch(middle, end);
            if self.waiting.len() - before <= FEW {
                return;
            }
            self.front.clear();
            self.waiting.drain(before..).for_each(|cluster| self.front.push(&cluster));
        }
        let Task { leaf_limit, node_cost, level, .. } = *self.task;
        let radius = if end - start <= FULL { NEAR } else { RADIUS };
        self.front.reduce(
            FEW,
            radius,
            level,
            &mut Merger { pairs: self.pairs, chains: self.keys, leaf_limit, node_cost },
        );
        self.waiting.extend(self.front.clusters());
    }
}
