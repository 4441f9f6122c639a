//! A tree over the living clusters, which prunes most of them in a search for the best match.
//!
//! Clusters are sorted into blocks along a Morton curve; very large ones come last, since they
//! would enlarge the boxes of all entries above them. Blocks are grouped by eight, groups again by
//! eight, and so on. Each entry has the union of the boxes below, their smallest extents, and the
//! smallest leaf. A merge updates the entries above it; when half the clusters are gone, the index
//! is rebuilt.
//!
//! A pruned cluster can neither be nearer than the best match so far nor win a tie, so the result
//! is that of a linear search.

use super::ClusteringWork;
use super::clusters::{Block, Clusters, LANES, Match, NO_LEAF, Probe};
use crate::build::morton::Curve;
use crate::geometry::Aabb;

/// Entries in a group.
const WIDTH: usize = 8;

/// Bounds on a set of clusters.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Summary {
    min: [f32; 3],
    max: [f32; 3],
    /// Per axis, the smallest extent of a box.
    min_extent: [f32; 3],
    /// The smallest leaf of all, [`NO_LEAF`] when no cluster is alive.
    first_leaf: u32,
}

impl Summary {
    const EMPTY: Self = Self {
        min: [f32::INFINITY; 3],
        max: [f32::NEG_INFINITY; 3],
        min_extent: [f32::INFINITY; 3],
        first_leaf: NO_LEAF,
    };

    fn of_block(block: &Block) -> Self {
        let mut summary = Self::EMPTY;
        for lane in 0..LANES {
            if block.leaf[lane] == NO_LEAF {
                continue;
            }
            for axis in 0..3 {
                let (min, max) = (block.min[axis][lane], block.max[axis][lane]);
                summary.min[axis] = summary.min[axis].min(min);
                summary.max[axis] = summary.max[axis].max(max);
                summary.min_extent[axis] = summary.min_extent[axis].min(max - min);
            }
            summary.first_leaf = summary.first_leaf.min(block.leaf[lane]);
        }
        summary
    }
}

/// Eight summaries, as a structure of arrays.
#[derive(Clone, Debug)]
#[repr(align(64))]
struct Group {
    min: [[f32; WIDTH]; 3],
    max: [[f32; WIDTH]; 3],
    min_extent: [[f32; WIDTH]; 3],
    first_leaf: [u32; WIDTH],
}

impl Group {
    const EMPTY: Self = Self {
        min: [[f32::INFINITY; WIDTH]; 3],
        max: [[f32::NEG_INFINITY; WIDTH]; 3],
        min_extent: [[f32::INFINITY; WIDTH]; 3],
        first_leaf: [NO_LEAF; WIDTH],
    };

    fn get(&self, entry: usize) -> Summary {
        Summary {
            min: self.min.map(|axis| axis[entry]),
            max: self.max.map(|axis| axis[entry]),
            min_extent: self.min_extent.map(|axis| axis[entry]),
            first_leaf: self.first_leaf[entry],
        }
    }

    fn set(&mut self, entry: usize, summary: &Summary) {
        for axis in 0..3 {
            self.min[axis][entry] = summary.min[axis];
            self.max[axis][entry] = summary.max[axis];
            self.min_extent[axis][entry] = summary.min_extent[axis];
        }
        self.first_leaf[entry] = summary.first_leaf;
    }

    fn summary(&self) -> Summary {
        let mut summary = Summary::EMPTY;
        for entry in 0..WIDTH {
            for axis in 0..3 {
                summary.min[axis] = summary.min[axis].min(self.min[axis][entry]);
                summary.max[axis] = summary.max[axis].max(self.max[axis][entry]);
                summary.min_extent[axis] = summary.min_extent[axis].min(self.min_extent[axis][entry]);
            }
            summary.first_leaf = summary.first_leaf.min(self.first_leaf[entry]);
        }
        summary
    }

    /// For each entry, a lower bound on the distances of the clusters below.
    ///
    /// A joint box is at least as wide as the probe and as the thinnest cluster; where there is a
    /// gap between the probe and all clusters, it spans probe, gap and cluster.
    ///
    /// Rounded down, in units of the roundoff 2^-24: an extent here is up to 4 units above the
    /// exact bound, a product of two 8 units; the product and the sums add 3 on either side, and
    /// the scaling 1. That is 15, and 16 are subtracted. The error of subnormal numbers is not
    /// relative, so the smallest normal number is subtracted too; and an area may overflow here
    /// although the distance does not, hence the clamp to `f32::MAX`.
    #[inline(always)]
    fn bounds(&self, probe: &Aabb) -> [f32; WIDTH] {
        const DOWN: f32 = 1.0 - 16.0 / (1 << 24) as f32;
        let mut bounds = [0.0; WIDTH];
        for entry in 0..WIDTH {
            let extent = |axis: usize| {
                let own = probe.max[axis] - probe.min[axis];
                let min_extent = self.min_extent[axis][entry];
                let above = self.min[axis][entry] - probe.max[axis];
                let below = probe.min[axis] - self.max[axis][entry];
                let gap = if above > below { above } else { below };
                let joint = if gap > 0.0 { own + gap + min_extent } else { own };
                let joint = if joint > min_extent { joint } else { min_extent };
                if joint < f32::MAX { joint } else { f32::MAX }
            };
            let (x, y, z) = (extent(0), extent(1), extent(2));
            let area = x * y + y * z + z * x;
            let area = if area < f32::MAX { area } else { f32::MAX };
            let bound = area * DOWN - f32::MIN_POSITIVE;
            bounds[entry] = if bound > 0.0 { bound } else { 0.0 };
        }
        bounds
    }

    fn lies_within(&self, entry: usize, probe: &Aabb) -> bool {
        (0..3).all(|axis| probe.min[axis] <= self.min[axis][entry] && self.max[axis][entry] <= probe.max[axis])
    }
}

/// A part of the index that a search has not visited yet.
#[derive(Clone, Copy, Debug)]
struct Pending {
    bound: f32,
    first_leaf: u32,
    /// Zero for a block, otherwise the level of the group plus one.
    height: u32,
    /// The index of the block or group.
    at: u32,
}

impl Pending {
    /// Whether no cluster below can beat `best`: all are farther, or none is nearer and all lose
    /// ties.
    fn is_beaten(&self, best: &Match) -> bool {
        self.bound > best.distance || (self.bound == best.distance && self.first_leaf > best.leaf)
    }
}

/// The tree over the blocks of [`Clusters`].
#[derive(Debug)]
pub(super) struct Index {
    /// From the groups over blocks up to the single group at the top.
    levels: Vec<Vec<Group>>,
    /// The number of clusters when the index was built.
    built_over: usize,
    /// The traversal stack, kept between searches to reuse its memory.
    stack: Vec<Pending>,
}

impl Index {
    /// Sorts the clusters and builds the index over them.
    pub(super) fn new(clusters: &mut Clusters) -> Self {
        sort(clusters);
        let mut levels = Vec::new();
        let mut below: Vec<Summary> = clusters.blocks().iter().map(Summary::of_block).collect();
        loop {
            let groups: Vec<Group> = below.chunks(WIDTH).map(group_of).collect();
            below = groups.iter().map(Group::summary).collect();
            levels.push(groups);
            if below.len() <= 1 {
                break;
            }
        }
        Self { levels, built_over: clusters.alive(), stack: Vec::new() }
    }

    /// Whether half of the clusters are gone since the index was built.
    pub(super) fn is_half_gone(&self, clusters: &Clusters) -> bool {
        clusters.alive() * 2 <= self.built_over
    }

    /// Updates the entries above a block.
    pub(super) fn update(&mut self, clusters: &Clusters, block: usize) {
        let mut at = block;
        let mut summary = Summary::of_block(&clusters.blocks()[block]);
        for level in &mut self.levels {
            let group = &mut level[at / WIDTH];
            if group.get(at % WIDTH) == summary {
                return;
            }
            group.set(at % WIDTH, &summary);
            summary = group.summary();
            at /= WIDTH;
        }
    }

    /// Updates `best` with the best match of all clusters.
    pub(super) fn best_match(
        &mut self,
        clusters: &Clusters,
        probe: &Probe,
        best: &mut Match,
        work: &mut ClusteringWork,
    ) {
        // The block of the probe gives a good initial bound.
        let own_block = (clusters.slot(probe.leaf) / LANES) as u32;
        clusters.scan_block(own_block as usize, probe, best);
        work.distances += LANES as u64;

        self.stack.clear();
        self.stack.push(Pending { bound: 0.0, first_leaf: 0, height: self.levels.len() as u32, at: 0 });
        while let Some(next) = self.stack.pop() {
            if next.is_beaten(best) {
                continue;
            }
            if next.height > 0 {
                work.bounds += WIDTH as u64;
                self.open(next, probe, best);
            } else if next.at != own_block {
                work.distances += LANES as u64;
                clusters.scan_block(next.at as usize, probe, best);
            }
        }
    }

    /// Pushes the entries of a group that may contain the best match, the nearest on top.
    fn open(&mut self, group: Pending, probe: &Probe, best: &mut Match) {
        let height = group.height - 1;
        let entries = &self.levels[height as usize][group.at as usize];
        let bounds = entries.bounds(&probe.bounds);
        let bottom = self.stack.len();
        for entry in 0..WIDTH {
            let at = group.at * WIDTH as u32 + entry as u32;
            let pending = Pending { bound: bounds[entry], first_leaf: entries.first_leaf[entry], height, at };
            if pending.is_beaten(best) || pending.first_leaf == NO_LEAF {
                continue;
            }
            // All clusters within the probe's box have the same distance, so the smallest leaf
            // wins, unless it is the probe's own.
            if pending.first_leaf != probe.leaf && entries.lies_within(entry, &probe.bounds) {
                let within = Match { distance: probe.bounds.half_area(), leaf: pending.first_leaf };
                if within.beats(best) {
                    *best = within;
                }
                continue;
            }
            let nearer = self.stack[bottom..].iter().rev().take_while(|other| other.bound < pending.bound).count();
            self.stack.insert(self.stack.len() - nearer, pending);
        }
    }
}

fn group_of(summaries: &[Summary]) -> Group {
    let mut group = Group::EMPTY;
    for (entry, summary) in summaries.iter().enumerate() {
        group.set(entry, summary);
    }
    group
}

/// Sorts clusters along a Morton curve, very large ones last. The order affects how well the index
/// prunes, not its results.
fn sort(clusters: &mut Clusters) {
    let mut sorted: Vec<(u64, u32, Aabb)> = clusters.iter().map(|(leaf, bounds)| (0, leaf, bounds)).collect();
    let centers = Aabb::from_points(sorted.iter().map(|(_, _, bounds)| bounds.center()));
    let curve = Curve::through(&centers, CODE_BITS).tabled();
    let mean = sorted.iter().map(|(_, _, bounds)| f64::from(longest_edge(bounds))).sum::<f64>() / sorted.len() as f64;
    let very_large = (mean * VERY_LARGE) as f32;
    for (key, _, bounds) in &mut sorted {
        *key = u64::from(longest_edge(bounds) > very_large) << CODE_BITS | curve.code(bounds.center());
    }
    sorted.sort_unstable_by_key(|(key, leaf, _)| (*key, *leaf));
    clusters.refill(sorted.into_iter().map(|(_, leaf, bounds)| (leaf, bounds)));
}

/// A box is very large if its longest edge exceeds the mean of all by this factor. Measured on
/// 100,000 boxes, 2 % of them thirty times as large as the rest: factors from 3 to 8 make the build
/// a fifth faster than no distinction; without such boxes there is no difference. Size classes
/// within a factor of four cost more than they saved.
const VERY_LARGE: f64 = 8.0;

/// Bits of a Morton code.
const CODE_BITS: u32 = 54;

fn longest_edge(bounds: &Aabb) -> f32 {
    (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(0.0, f32::max)
}

#[cfg(test)]
mod tests {
    use super::super::{clamped, distance};
    use super::*;
    use crate::test_random::Random;

    /// A box whose edges have any order of magnitude between the two exponents.
    fn brick(random: &mut Random, exponents: [f32; 2]) -> Aabb {
        let mut length = || 10.0_f32.powf(exponents[0] + random.unit() * (exponents[1] - exponents[0]));
        let mut points = [[0.0; 3]; 2];
        for axis in 0..3 {
            let (low, edge) = (length(), length());
            points[0][axis] = low;
            points[1][axis] = low + edge;
        }
        clamped(&Aabb::new(points[0], points[1]))
    }

    /// An entry with a single cluster that does not overlap the probe: the bound must not exceed
    /// the distance.
    fn assert_bounded(probe: &Aabb, cluster: &Aabb, what: &str) {
        let mut group = Group::EMPTY;
        let min_extent = std::array::from_fn(|axis| cluster.max[axis] - cluster.min[axis]);
        group.set(0, &Summary { min: cluster.min, max: cluster.max, min_extent, first_leaf: 0 });
        let (bound, distance) = (group.bounds(probe)[0], distance(probe, cluster));
        assert!(bound <= distance, "{what}: {bound:e} is above {distance:e}");
    }

    #[test]
    fn no_bound_is_above_a_distance_for_any_rounding() {
        let ranges = [[-1.0, 1.0], [-8.0, 8.0], [-24.0, -18.0], [-30.0, 30.0], [18.0, 20.0], [0.0, 39.0]];
        for exponents in ranges {
            let mut random = Random(17);
            for round in 0..200_000 {
                let (probe, cluster) = (brick(&mut random, exponents), brick(&mut random, exponents));
                assert_bounded(&probe, &cluster, &format!("{exponents:?}, seed 17, round {round}"));
            }
        }
    }

    #[test]
    fn a_bound_that_overflows_is_not_above_a_distance_that_does_not() {
        const LIMIT: f32 = f32::MAX / 2.0;
        let mut random = Random(18);
        for round in 0..200_000 {
            let what = format!("seed 18, round {round}");
            let (inner, outer) = (random.unit() * LIMIT, random.unit() * LIMIT);
            let (low, high) = ((inner - outer).min(0.0), (inner - outer).max(0.0));
            // Maximal width, and thin.
            let thin = 1e-30;
            assert_bounded(
                &Aabb::new([-LIMIT, 0.0, 0.0], [low, thin, thin]),
                &Aabb::new([high, 0.0, 0.0], [LIMIT, thin, thin]),
                &what,
            );
            // The largest finite area, or just above.
            let width = 2.0 + random.unit();
            let height = f32::MAX / width;
            let (left, right) = (width * 0.4 * random.unit(), width * (0.5 + 0.4 * random.unit()));
            assert_bounded(
                &Aabb::new([0.0; 3], [left, height, 0.0]),
                &Aabb::new([right, 0.0, 0.0], [width, height, 0.0]),
                &what,
            );
        }
    }
}
