//! The clusters that are alive, sixteen side by side, and the linear search among them.

use super::clamped;
use crate::geometry::Aabb;

/// How many clusters stand side by side in a block.
pub(super) const LANES: usize = 16;

/// Stands for no leaf, where a block has a vacancy. Larger than every leaf, so it loses every tie.
pub(super) const NOBODY: u32 = u32::MAX;

/// The cluster that a best match is sought for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    /// Its box.
    pub(super) bounds: Aabb,
    /// Its smallest leaf.
    pub(super) leaf: u32,
}

/// A partner for the cluster of a query.
///
/// The pairs that a fixed cluster makes with two others are ordered, at equal distance, as the smallest leaves of
/// those two are, on whichever side of the fixed one they lie. So the order of [`super::dendrogram::Pair`] comes
/// down to these two fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Match {
    /// Half area of the joint box.
    pub(super) distance: f32,
    /// Smallest leaf of the partner.
    pub(super) leaf: u32,
}

impl Match {
    /// Loses to every partner there is.
    pub(super) const NONE: Self = Self { distance: f32::INFINITY, leaf: NOBODY };

    /// Whether this partner comes before the other.
    pub(super) fn beats(&self, other: &Self) -> bool {
        self.key() < other.key()
    }

    /// A number that is smaller for a better partner. The bits of floats that are neither negative (zeros included)
    /// nor NaN are ordered as the floats are, and distances are such.
    #[inline(always)]
    fn key(&self) -> u64 {
        u64::from(self.distance.to_bits()) << 32 | u64::from(self.leaf)
    }

    #[inline(always)]
    fn from_key(key: u64) -> Self {
        Self { distance: f32::from_bits((key >> 32) as u32), leaf: key as u32 }
    }
}

/// Sixteen places for clusters, axis by axis.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    pub(super) min: [[f32; LANES]; 3],
    pub(super) max: [[f32; LANES]; 3],
    pub(super) leaf: [u32; LANES],
}

impl Block {
    /// A vacancy is everywhere, so that its distance is as large as can be.
    const VACANT: Self =
        Self { min: [[f32::NEG_INFINITY; LANES]; 3], max: [[f32::INFINITY; LANES]; 3], leaf: [NOBODY; LANES] };

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

    /// What `distance` says of each cluster here: the same operations in the same order, sixteen at a step.
    #[inline(always)]
    fn distances(&self, to: &Aabb) -> [f32; LANES] {
        let mut distances = [0.0; LANES];
        for lane in 0..LANES {
            let extent =
                |axis: usize| larger(self.max[axis][lane], to.max[axis]) - smaller(self.min[axis][lane], to.min[axis]);
            let (x, y, z) = (extent(0), extent(1), extent(2));
            distances[lane] = x * y + y * z + z * x;
        }
        distances
    }

    /// The better of `best` and the best match here.
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

/// `f32::min` without its care for NaN, of which there is none here: one instruction.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// `f32::max`, likewise.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The clusters that are alive. Each has a place, which may change; its smallest leaf is its name.
#[derive(Debug)]
pub(super) struct Clusters {
    blocks: Vec<Block>,
    /// Places that are or were in use.
    places: usize,
    alive: usize,
    /// Where the cluster with this smallest leaf is.
    place_of: Vec<u32>,
}

impl Clusters {
    /// Each box a cluster of its own, in the order given.
    pub(super) fn new(boxes: &[Aabb]) -> Self {
        let mut clusters = Self { blocks: Vec::new(), places: 0, alive: 0, place_of: vec![NOBODY; boxes.len()] };
        clusters.refill((0u32..).zip(boxes.iter().map(clamped)));
        clusters
    }

    /// Replaces all clusters by these, which then stand side by side without vacancies in this order.
    pub(super) fn refill(&mut self, clusters: impl Iterator<Item = (u32, Aabb)>) {
        self.blocks.clear();
        self.places = 0;
        for (leaf, bounds) in clusters {
            if self.places.is_multiple_of(LANES) {
                self.blocks.push(Block::VACANT);
            }
            self.put(self.places, &bounds, leaf);
            self.places += 1;
        }
        self.alive = self.places;
    }

    pub(super) fn alive(&self) -> usize {
        self.alive
    }

    pub(super) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// The clusters that are alive, as they stand.
    pub(super) fn iter(&self) -> impl Iterator<Item = (u32, Aabb)> + '_ {
        let lanes = self.blocks.iter().flat_map(|block| (0..LANES).map(move |lane| (block, lane)));
        lanes
            .filter(|(block, lane)| block.leaf[*lane] != NOBODY)
            .map(|(block, lane)| (block.leaf[lane], block.bounds(lane)))
    }

    /// Where a living cluster is.
    pub(super) fn place(&self, leaf: u32) -> usize {
        self.place_of[leaf as usize] as usize
    }

    /// The box of a living cluster.
    pub(super) fn bounds(&self, leaf: u32) -> Aabb {
        let place = self.place(leaf);
        self.blocks[place / LANES].bounds(place % LANES)
    }

    /// Puts a cluster into a place, over what was there.
    pub(super) fn put(&mut self, place: usize, bounds: &Aabb, leaf: u32) {
        self.blocks[place / LANES].set(place % LANES, bounds, leaf);
        self.place_of[leaf as usize] = place as u32;
    }

    /// Leaves a place vacant. The others stay where they are.
    pub(super) fn vacate(&mut self, place: usize) {
        let everywhere = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
        self.blocks[place / LANES].set(place % LANES, &everywhere, NOBODY);
        self.alive -= 1;
    }

    /// Leaves a place vacant and moves the last cluster there; for use without vacancies.
    pub(super) fn swap_remove(&mut self, place: usize) {
        debug_assert_eq!(self.alive, self.places);
        let last = self.places - 1;
        let (block, lane) = (&self.blocks[last / LANES], last % LANES);
        let (bounds, leaf) = (block.bounds(lane), block.leaf[lane]);
        self.vacate(last);
        self.places = last;
        if place != last {
            self.put(place, &bounds, leaf);
        }
        if last.is_multiple_of(LANES) {
            self.blocks.pop();
        }
    }

    /// The better of `best` and the best match in one block.
    #[inline]
    pub(super) fn scan_block(&self, block: usize, probe: &Probe, best: &mut Match) {
        self.blocks[block].scan(probe, best);
    }

    /// The better of `best` and the best match of all.
    pub(super) fn scan_all(&self, probe: &Probe, best: &mut Match) {
        for block in &self.blocks {
            block.scan(probe, best);
        }
    }
}
