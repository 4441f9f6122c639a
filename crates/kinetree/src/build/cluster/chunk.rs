//! Clustering one chunk of the curve: each branch of the radix tree over the codes is merged down
//! to a few clusters before its parent.

use super::active_clusters::{ActiveClusters, CAPACITY, LEAF_RADIUS, Merger, RADIUS, REDUCED};
use super::pair::{Cluster, Kind, Pair};
use crate::build::fast_box::FastBox;
use crate::geometry::Aabb;
use crate::simd::{Isa, Kernel, Level};

/// A chunk of the curve, and the result of its clustering.
pub(super) struct Chunk<'a> {
    /// Sorted keys, each with the index of a primitive in the lower bits. Clustering replaces them
    /// by links of chains (see [`Kind::chained`]).
    pub(super) keys: &'a mut [u64],
    pub(super) pairs: Vec<Pair>,
    /// The clusters that are left, at least one.
    pub(super) clusters: Vec<Cluster>,
}

/// The input that all chunks share.
pub(super) struct Task<'a> {
    pub(super) boxes: &'a [Aabb],
    /// The bits of a key that hold the index of the primitive.
    pub(super) primitive_mask: u64,
    pub(super) leaf_limit: u32,
    /// Branches of up to this many primitives become leaves without a comparison of costs.
    pub(super) first_leaf: u32,
    pub(super) node_cost: f32,
    pub(super) level: Level,
}

/// The number of keys in the left child of a radix-tree branch over sorted, distinct keys: those
/// that have a zero in the first bit that differs.
pub(super) fn fork(keys: &[u64]) -> usize {
    let (first, last) = (keys[0], keys[keys.len() - 1]);
    let bit = 63 - (first ^ last).leading_zeros();
    keys.partition_point(|key| key >> bit & 1 == 0)
}

impl Chunk<'_> {
    pub(super) fn cluster(&mut self, task: &Task<'_>) {
        let leaves = task.level.run(FirstLeaves { keys: self.keys, task });
        self.pairs.reserve(leaves.clusters.len());
        let mut clustering = Clustering {
            task,
            leaves: &leaves,
            chains: self.keys,
            pairs: &mut self.pairs,
            active: ActiveClusters::new(),
            waiting: Vec::new(),
        };
        clustering.branch(0, leaves.clusters.len());
        self.clusters = clustering.waiting;
    }
}

/// The initial clusters, in the order of the curve.
struct Leaves {
    clusters: Vec<Cluster>,
    /// The first key of each.
    keys: Vec<u64>,
}

/// Makes leaves of whole branches that are small enough, and replaces their keys by links of
/// chains.
struct FirstLeaves<'a, 'b> {
    keys: &'a mut [u64],
    task: &'a Task<'b>,
}

/// The search radius of leaves and of other clusters when leaves are branches. Larger ones do not
/// make better trees on average.
const BRANCH_RADII: (usize, usize) = (3, 5);

/// The prefetch distance for boxes, in keys.
const PREFETCH_DISTANCE: usize = 16;

impl Kernel for FirstLeaves<'_, '_> {
    type Output = Leaves;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Leaves {
        let Self { keys, task } = self;
        let capacity = if task.first_leaf > 1 { keys.len() / 2 } else { keys.len() };
        let mut leaves = Leaves { clusters: Vec::with_capacity(capacity), keys: Vec::with_capacity(capacity) };
        let mut start = 0;
        let mut before = 0;
        while start < keys.len() {
            let (count, after) = branch_at(keys, start, before, task.first_leaf as usize);
            leaves.keys.push(keys[start]);
            let mut bounds = FastBox::EMPTY;
            for index in start..start + count {
                if let Some(ahead) = keys.get(index + PREFETCH_DISTANCE) {
                    isa.prefetch(task.boxes, (ahead & task.primitive_mask) as usize);
                }
                let primitive = keys[index] & task.primitive_mask;
                bounds = bounds.union(&FastBox::from(&task.boxes[primitive as usize]));
                let next = if index + 1 < start + count { index + 1 } else { 0 };
                keys[index] = primitive | (next as u64) << 32;
            }
            let bounds = Aabb::new(bounds.min.into(), bounds.max.into());
            leaves.clusters.push(Cluster { bounds, kind: Kind::leaf(start, count) });
            (start, before) = (start + count, after);
        }
        leaves
    }
}

/// The size of the largest branch of at most `most` keys that begins at `start`, and the number of
/// leading bits that its last key has in common with the next key. `before` is the number of
/// leading bits that its first key has in common with the previous one.
#[inline(always)]
fn branch_at(keys: &[u64], start: usize, before: u32, limit: usize) -> (usize, u32) {
    // Keys are distinct, so fewer than 64 bits are common; past the ends there are none.
    let common = |last: usize| match keys.get(last + 1) {
        Some(next) => (keys[last] ^ next).leading_zeros(),
        None => 0,
    };
    let mut after = common(start);
    let (mut largest, mut inside) = ((1, after), 64);
    for count in 2..=limit.min(keys.len() - start) {
        inside = after.min(inside);
        after = common(start + count - 1);
        if inside > before.max(after) || count == keys.len() {
            largest = (count, after);
        }
    }
    largest
}

struct Clustering<'a> {
    task: &'a Task<'a>,
    leaves: &'a Leaves,
    chains: &'a mut [u64],
    pairs: &'a mut Vec<Pair>,
    active: ActiveClusters,
    /// A stack of clusters of branches whose parents have not been merged yet.
    waiting: Vec<Cluster>,
}

impl Clustering<'_> {
    /// Merges a branch, given the range of its leaves, and pushes its clusters on `waiting`.
    fn branch(&mut self, start: usize, end: usize) {
        let radii = if self.task.first_leaf > 1 { BRANCH_RADII } else { (LEAF_RADIUS, RADIUS) };
        let before = self.waiting.len();
        self.active.clear();
        let radius = if end - start <= CAPACITY {
            self.leaves.clusters[start..end].iter().for_each(|leaf| self.active.push(leaf));
            radii.0
        } else {
            let middle = start + fork(&self.leaves.keys[start..end]);
            self.branch(start, middle);
            self.branch(middle, end);
            if self.waiting.len() - before <= REDUCED {
                return;
            }
            self.active.clear();
            self.waiting.drain(before..).for_each(|cluster| self.active.push(&cluster));
            radii.1
        };
        let Task { leaf_limit, node_cost, level, .. } = *self.task;
        let mut merger = Merger { pairs: self.pairs, chains: self.chains, leaf_limit, node_cost };
        self.active.reduce(REDUCED, radius, level, &mut merger);
        self.waiting.extend(self.active.clusters());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_random::Random;

    /// The size of the branch by its definition: all the keys that begin with the same bits.
    fn brute_force(keys: &[u64], start: usize, limit: usize) -> usize {
        let of_branch = |bits: u32| {
            let same = |key: &&u64| key.checked_shr(bits) == keys[start].checked_shr(bits);
            (keys.iter().position(|key| same(&key)), keys.iter().filter(same).count())
        };
        (0..=64)
            .map(of_branch)
            .filter(|&(first, count)| first == Some(start) && count <= limit)
            .map(|it| it.1)
            .max()
            .unwrap()
    }

    #[test]
    fn first_leaves_are_the_largest_branches_that_fit() {
        let mut generator = Random(5);
        let mut random = || generator.next() >> 33;
        for size in [1, 2, 3, 4, 5, 9, 300] {
            for bits in [9, 12, 31] {
                let mut keys: Vec<u64> = (0..size).map(|_| random() & ((1 << bits) - 1)).collect();
                keys.push(u64::MAX);
                keys.sort_unstable();
                keys.dedup();
                for limit in 1..=4 {
                    let (mut start, mut before) = (0, 0);
                    while start < keys.len() {
                        let (count, after) = branch_at(&keys, start, before, limit);
                        assert_eq!(count, brute_force(&keys, start, limit), "{keys:?}, {start}, {limit}");
                        (start, before) = (start + count, after);
                    }
                }
            }
        }
    }
}
