//! Clustering a stretch of the curve: every branch of the tree that the codes make is merged down to a few clusters before its parent is.

use super::active_clusters::{ActiveClusters, FEW, FULL, Merger, NEAR, RADIUS};
use super::pair::{Cluster, Kind, Pair};
use crate::build::fast_box::FastBox;
use crate::geometry::Aabb;
use crate::simd::{Isa, Kernel, Level};

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
    /// How many primitives a leaf may have before anything is compared.
    pub(super) first_leaf: u32,
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
        let leaves = task.level.run(FirstLeaves { keys: self.keys, task });
        self.pairs.reserve(leaves.clusters.len());
        let mut work = Work {
            task,
            leaves: &leaves,
            chains: self.keys,
            pairs: &mut self.pairs,
            active: ActiveClusters::new(),
            waiting: Vec::new(),
        };
        work.branch(0, leaves.clusters.len());
        self.clusters = work.waiting;
    }
}

/// What clustering begins with, in the order of the curve.
struct Leaves {
    clusters: Vec<Cluster>,
    /// The first key of each.
    keys: Vec<u64>,
}

/// Makes leaves of whole branches that are small enough, and links of chains of their keys.
struct FirstLeaves<'a, 'b> {
    keys: &'a mut [u64],
    task: &'a Task<'b>,
}

/// How far clusters look when leaves were branches: the leaves, then the others. Further makes no better trees, on the whole.
const OF_BRANCHES: (usize, usize) = (3, 5);

/// How far ahead boxes are asked for, in keys.
const AHEAD: usize = 16;

impl Kernel for FirstLeaves<'_, '_> {
    type Output = Leaves;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Leaves {
        let Self { keys, task } = self;
        let room = if task.first_leaf > 1 { keys.len() / 2 } else { keys.len() };
        let mut leaves = Leaves { clusters: Vec::with_capacity(room), keys: Vec::with_capacity(room) };
        let mut start = 0;
        let mut before = 0;
        while start < keys.len() {
            let (count, after) = branch_at(keys, start, before, task.first_leaf as usize);
            leaves.keys.push(keys[start]);
            let mut bounds = FastBox::EMPTY;
            for place in start..start + count {
                if let Some(ahead) = keys.get(place + AHEAD) {
                    isa.prefetch(task.boxes, (ahead & task.primitive_mask) as usize);
                }
                let primitive = keys[place] & task.primitive_mask;
                bounds = bounds.union(&FastBox::from(&task.boxes[primitive as usize]));
                let next = if place + 1 < start + count { place + 1 } else { 0 };
                keys[place] = primitive | (next as u64) << 32;
            }
            let bounds = Aabb::new(bounds.min.into(), bounds.max.into());
            leaves.clusters.push(Cluster { bounds, kind: Kind::leaf(start, count) });
            (start, before) = (start + count, after);
        }
        leaves
    }
}

/// How many keys the largest branch that begins at `start` has, if it may have `most`; and how many leading bits the last of them has in common with the one
/// behind it. `before` are those that the first has in common with the one in front of it.
#[inline(always)]
fn branch_at(keys: &[u64], start: usize, before: u32, most: usize) -> (usize, u32) {
    // Keys are different, so nobody has all 64 in common; and past the ends there is nobody to have any in common with.
    let common = |last: usize| match keys.get(last + 1) {
        Some(next) => (keys[last] ^ next).leading_zeros(),
        None => 0,
    };
    let mut after = common(start);
    let (mut found, mut inside) = ((1, after), 64);
    for count in 2..=most.min(keys.len() - start) {
        inside = after.min(inside);
        after = common(start + count - 1);
        if inside > before.max(after) || count == keys.len() {
            found = (count, after);
        }
    }
    found
}

struct Work<'a> {
    task: &'a Task<'a>,
    leaves: &'a Leaves,
    chains: &'a mut [u64],
    pairs: &'a mut Vec<Pair>,
    active: ActiveClusters,
    /// Clusters of branches whose parents are still to come.
    waiting: Vec<Cluster>,
}

impl Work<'_> {
    /// Leaves the clusters of a branch, given its first leaves, at the end of `waiting`.
    fn branch(&mut self, start: usize, end: usize) {
        let reach = if self.task.first_leaf > 1 { OF_BRANCHES } else { (NEAR, RADIUS) };
        let before = self.waiting.len();
        self.active.clear();
        let radius = if end - start <= FULL {
            self.leaves.clusters[start..end].iter().for_each(|leaf| self.active.push(leaf));
            reach.0
        } else {
            let middle = start + fork(&self.leaves.keys[start..end]);
            self.branch(start, middle);
            self.branch(middle, end);
            if self.waiting.len() - before <= FEW {
                return;
            }
            self.active.clear();
            self.waiting.drain(before..).for_each(|cluster| self.active.push(&cluster));
            reach.1
        };
        let Task { leaf_limit, node_cost, level, .. } = *self.task;
        let mut merger = Merger { pairs: self.pairs, chains: self.chains, leaf_limit, node_cost };
        self.active.reduce(FEW, radius, level, &mut merger);
        self.waiting.extend(self.active.clusters());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same by the definition: a branch is all the keys that begin with the same bits.
    fn brute_force(keys: &[u64], start: usize, most: usize) -> usize {
        let of_branch = |bits: u32| {
            let same = |key: &&u64| key.checked_shr(bits) == keys[start].checked_shr(bits);
            (keys.iter().position(|key| same(&key)), keys.iter().filter(same).count())
        };
        (0..=64)
            .map(of_branch)
            .filter(|&(first, count)| first == Some(start) && count <= most)
            .map(|it| it.1)
            .max()
            .unwrap()
    }

    #[test]
    fn first_leaves_are_the_largest_branches_that_fit() {
        let mut state = 5_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 33
        };
        for size in [1, 2, 3, 4, 5, 9, 300] {
            for bits in [9, 12, 31] {
                let mut keys: Vec<u64> = (0..size).map(|_| random() & ((1 << bits) - 1)).collect();
                keys.push(u64::MAX);
                keys.sort_unstable();
                keys.dedup();
                for most in 1..=4 {
                    let (mut start, mut before) = (0, 0);
                    while start < keys.len() {
                        let (count, after) = branch_at(&keys, start, before, most);
                        assert_eq!(count, brute_force(&keys, start, most), "{keys:?}, {start}, {most}");
                        (start, before) = (start + count, after);
                    }
                }
            }
        }
    }
}
