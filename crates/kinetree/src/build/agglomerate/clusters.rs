//! The clusters that are alive, in blocks of sixteen, and the linear search among them.

use super::clamped;
use crate::geometry::{Aabb, fast_max, fast_min};

/// Clusters per block.
pub(super) const LANES: usize = 16;

/// The leaf of a vacant lane. Larger than every leaf, so it loses every tie.
pub(super) const NO_LEAF: u32 = u32::MAX;

/// The cluster whose best match is searched for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    /// Its box.
    pub(super) bounds: Aabb,
    /// Its smallest leaf.
    pub(super) leaf: u32,
}

/// A partner for the probe.
///
/// At equal distance, the pairs of a fixed cluster with two others are ordered as the smallest
/// leaves of those two are, whether these are smaller or larger than the fixed one's. So these two
/// fields give the order of [`super::dendrogram::Pair`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Match {
    /// Half area of the joint box.
    pub(super) distance: f32,
    /// Smallest leaf of the partner.
    pub(super) leaf: u32,
}

impl Match {
    /// No partner: loses to every other match.
    pub(super) const NONE: Self = Self { distance: f32::INFINITY, leaf: NO_LEAF };

    /// Whether this match comes before the other.
    pub(super) fn beats(&self, other: &Self) -> bool {
        self.key() < other.key()
    }

    /// A number that is smaller for a better match. Distances are neither negative (zero included)
    /// nor NaN, so their bits are ordered as the floats are.
    #[inline(always)]
    fn key(&self) -> u64 {
        u64::from(self.distance.to_bits()) << 32 | u64::from(self.leaf)
    }

    #[inline(always)]
    fn from_key(key: u64) -> Self {
        Self { distance: f32::from_bits((key >> 32) as u32), leaf: key as u32 }
    }
}

/// Sixteen lanes for clusters, as a structure of arrays.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    pub(super) min: [[f32; LANES]; 3],
    pub(super) max: [[f32; LANES]; 3],
    pub(super) leaf: [u32; LANES],
}

impl Block {
    /// A vacant lane has an infinite box, so that its distance is infinite.
    const VACANT: Self =
        Self { min: [[f32::NEG_INFINITY; LANES]; 3], max: [[f32::INFINITY; LANES]; 3], leaf: [NO_LEAF; LANES] };

    fn bounds(&self, lane: usize) -> Aabb {
        Aabb::new(self.min.map(|axis| axis[lane]), self.max.map(|axis| axis[lane]))
    }

    fn set(&mut self, lane: usize, bounds: &Aabb, leaf: u32) {
        for axis in 0..3 {
            self.min[axis][lane] = bounds.min[axis];
            self.max[axis][lane] = bounds.max[axis];
        }
        self.leaf[lane] = leaf;
    }

    /// The `distance` of each cluster of the block: the same operations in the same order, sixteen
    /// at a time.
    #[inline(always)]
    fn distances(&self, to: &Aabb) -> [f32; LANES] {
        let mut distances = [0.0; LANES];
        for lane in 0..LANES {
            let extent = |axis: usize| {
                fast_max(self.max[axis][lane], to.max[axis]) - fast_min(self.min[axis][lane], to.min[axis])
            };
            let (x, y, z) = (extent(0), extent(1), extent(2));
            distances[lane] = x * y + y * z + z * x;
        }
        distances
    }

    /// Updates `best` with the best match in this block.
    #[inline(always)]
    fn scan(&self, probe: &Probe, best: &mut Match) {
        let distances = self.distances(&probe.bounds);
        let mut promising = 0;
        for lane in 0..LANES {
            promising |= u32::from(distances[lane] <= best.distance);
        }
        if promising != 0 {
            self.settle(&distances, probe.leaf, best);
        }
    }

    fn settle(&self, distances: &[f32; LANES], own: u32, best: &mut Match) {
        let mut key = best.key();
        for lane in 0..LANES {
            let candidate = Match { distance: distances[lane], leaf: self.leaf[lane] }.key();
            key = key.min(if self.leaf[lane] == own { u64::MAX } else { candidate });
        }
        *best = Match::from_key(key);
    }
}

/// The clusters that are alive. Each has a slot, which may change, and is identified by its
/// smallest leaf.
#[derive(Debug)]
pub(super) struct Clusters {
    blocks: Vec<Block>,
    /// The number of slots, vacant ones included.
    slots: usize,
    alive: usize,
    /// For each leaf, the slot of the cluster whose smallest leaf it is.
    slot_of: Vec<u32>,
}

impl Clusters {
    /// Makes each box a cluster, in the order given.
    pub(super) fn new(boxes: &[Aabb]) -> Self {
        let mut clusters = Self { blocks: Vec::new(), slots: 0, alive: 0, slot_of: vec![NO_LEAF; boxes.len()] };
        clusters.refill((0u32..).zip(boxes.iter().map(clamped)));
        clusters
    }

    /// Replaces all clusters by these, in this order and without vacancies.
    pub(super) fn refill(&mut self, clusters: impl Iterator<Item = (u32, Aabb)>) {
        self.blocks.clear();
        self.slots = 0;
        for (leaf, bounds) in clusters {
            if self.slots.is_multiple_of(LANES) {
                self.blocks.push(Block::VACANT);
            }
            self.put(self.slots, &bounds, leaf);
            self.slots += 1;
        }
        self.alive = self.slots;
    }

    pub(super) fn alive(&self) -> usize {
        self.alive
    }

    pub(super) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// The clusters that are alive, in the order of their slots.
    pub(super) fn iter(&self) -> impl Iterator<Item = (u32, Aabb)> + '_ {
        let lanes = self.blocks.iter().flat_map(|block| (0..LANES).map(move |lane| (block, lane)));
        lanes
            .filter(|(block, lane)| block.leaf[*lane] != NO_LEAF)
            .map(|(block, lane)| (block.leaf[lane], block.bounds(lane)))
    }

    /// The slot of a living cluster.
    pub(super) fn slot(&self, leaf: u32) -> usize {
        self.slot_of[leaf as usize] as usize
    }

    /// The box of a living cluster.
    pub(super) fn bounds(&self, leaf: u32) -> Aabb {
        let slot = self.slot(leaf);
        self.blocks[slot / LANES].bounds(slot % LANES)
    }

    /// Writes a cluster to a slot.
    pub(super) fn put(&mut self, slot: usize, bounds: &Aabb, leaf: u32) {
        self.blocks[slot / LANES].set(slot % LANES, bounds, leaf);
        self.slot_of[leaf as usize] = slot as u32;
    }

    /// Makes a slot vacant. The other clusters keep their slots.
    pub(super) fn vacate(&mut self, slot: usize) {
        let everywhere = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
        self.blocks[slot / LANES].set(slot % LANES, &everywhere, NO_LEAF);
        self.alive -= 1;
    }

    /// Removes a cluster and moves the last one to its slot. There must be no vacant slots.
    pub(super) fn swap_remove(&mut self, slot: usize) {
        debug_assert_eq!(self.alive, self.slots);
        let last = self.slots - 1;
        let (block, lane) = (&self.blocks[last / LANES], last % LANES);
        let (bounds, leaf) = (block.bounds(lane), block.leaf[lane]);
        self.vacate(last);
        self.slots = last;
        if slot != last {
            self.put(slot, &bounds, leaf);
        }
        if last.is_multiple_of(LANES) {
            self.blocks.pop();
        }
    }

    /// Updates `best` with the best match in one block.
    #[inline]
    pub(super) fn scan_block(&self, block: usize, probe: &Probe, best: &mut Match) {
        self.blocks[block].scan(probe, best);
    }

    /// Updates `best` with the best match of all clusters.
    pub(super) fn scan_all(&self, probe: &Probe, best: &mut Match) {
        for block in &self.blocks {
            block.scan(probe, best);
        }
    }
}
