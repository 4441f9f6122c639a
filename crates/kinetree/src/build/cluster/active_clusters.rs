//! A window of clusters along the curve, and their merging.
//!
//! Each cluster searches its neighbours on both sides for the one with which its joint box is
//! smallest, eight clusters at a time; the area of a joint box is computed once, for both. Mutual
//! nearest neighbours merge, all in the same pass, until few enough are left.

use super::pair::{Cluster, Kind, Pair};
use crate::geometry::{Aabb, fast_max, fast_min};
use crate::simd::{Isa, Kernel, Level};

/// The capacity of [`ActiveClusters`].
pub(super) const CAPACITY: usize = 64;

/// The number of clusters that a branch is merged down to before it is joined with its neighbour.
pub(super) const REDUCED: usize = CAPACITY / 2;

/// The largest search radius, in clusters to each side.
pub(super) const RADIUS: usize = 6;

/// The search radius of single primitives. A larger one did not make better trees.
pub(super) const LEAF_RADIUS: usize = 4;

const LANES: usize = 8;

/// Unused entries on both sides, so that the search needs no bounds checks.
const MARGIN: usize = 16;
const PADDED: usize = MARGIN + CAPACITY + MARGIN;

const _: () = assert!(RADIUS + LANES <= MARGIN && CAPACITY % LANES == 0);

/// The low bits of an area are replaced by the position of the neighbour: from 1 for the leftmost
/// to twice the radius for the rightmost. So a minimum over areas also gives the neighbour.
const POSITION_MASK: u32 = 15;
const _: () = assert!(2 * RADIUS as u32 <= POSITION_MASK);

/// No neighbour: less than any neighbour whose joint area is infinite or NaN.
const NO_NEIGHBOUR: u32 = f32::INFINITY.to_bits();

/// Clusters in the order of the curve, as a structure of arrays.
pub(super) struct ActiveClusters {
    len: usize,
    min: [[f32; PADDED]; 3],
    max: [[f32; PADDED]; 3],
    kinds: [Kind; CAPACITY],
    /// `areas[distance - 1][left]`: the half area of the joint box of two clusters `distance`
    /// apart, as bits, without the low ones.
    areas: [[u32; PADDED]; RADIUS],
}

/// The parameters of merging, and its output.
pub(super) struct Merger<'a> {
    pub(super) pairs: &'a mut Vec<Pair>,
    /// Linked lists of the primitives of each leaf: see [`Kind::chained`].
    pub(super) chains: &'a mut [u64],
    pub(super) leaf_limit: u32,
    pub(super) node_cost: f32,
}

impl ActiveClusters {
    pub(super) fn new() -> Self {
        // Unused entries have an infinite box, so they are never the nearest neighbour.
        Self {
            len: 0,
            min: [[f32::NEG_INFINITY; PADDED]; 3],
            max: [[f32::INFINITY; PADDED]; 3],
            kinds: [Kind::default(); CAPACITY],
            areas: [[NO_NEIGHBOUR; PADDED]; RADIUS],
        }
    }

    pub(super) fn clear(&mut self) {
        self.shorten(0);
    }

    #[inline(always)]
    pub(super) fn push(&mut self, cluster: &Cluster) {
        for axis in 0..3 {
            self.min[axis][MARGIN + self.len] = cluster.bounds.min[axis];
            self.max[axis][MARGIN + self.len] = cluster.bounds.max[axis];
        }
        self.kinds[self.len] = cluster.kind;
        self.len += 1;
    }

    pub(super) fn clusters(&self) -> impl Iterator<Item = Cluster> + '_ {
        (0..self.len).map(|at| self.cluster(at))
    }

    /// Merges until at most `target` clusters are left, with the given search radius.
    pub(super) fn reduce(&mut self, target: usize, radius: usize, level: Level, merger: &mut Merger<'_>) {
        if self.len > target {
            level.run(Reduce { active: self, target, radius, merger });
        }
    }

    #[inline(always)]
    fn cluster(&self, at: usize) -> Cluster {
        Cluster { bounds: self.bounds(at), kind: self.kinds[at] }
    }

    #[inline(always)]
    fn bounds(&self, at: usize) -> Aabb {
        let at = MARGIN + at;
        Aabb::new([0, 1, 2].map(|axis| self.min[axis][at]), [0, 1, 2].map(|axis| self.max[axis][at]))
    }

    #[inline(always)]
    fn shorten(&mut self, len: usize) {
        for axis in 0..3 {
            self.min[axis][MARGIN + len..MARGIN + self.len].fill(f32::NEG_INFINITY);
            self.max[axis][MARGIN + len..MARGIN + self.len].fill(f32::INFINITY);
        }
        self.len = len;
    }

    /// The nearest neighbour of each cluster, the first of equal ones. A cluster without neighbours
    /// is its own.
    ///
    /// The first pair of least area is mutual, so at least one pair merges unless all areas are
    /// infinite or NaN.
    #[inline(always)]
    fn partners(&mut self, radius: usize) -> [u32; CAPACITY] {
        let radius = radius.min(RADIUS);
        for first in (0..self.len).step_by(LANES) {
            let own = lanes(&self.min, &self.max, MARGIN + first);
            for distance in 1..=radius {
                let areas = joint_areas(&own, &lanes(&self.min, &self.max, MARGIN + first + distance));
                let slot = &mut self.areas[distance - 1][MARGIN + first..][..LANES];
                for lane in 0..LANES {
                    slot[lane] = areas[lane].to_bits() & !POSITION_MASK;
                }
            }
        }
        let mut partners = [0; CAPACITY];
        for first in (0..self.len).step_by(LANES) {
            let mut best = [NO_NEIGHBOUR; LANES];
            for distance in 1..=radius {
                let areas = &self.areas[distance - 1];
                let on_the_left = &areas[MARGIN + first - distance..][..LANES];
                let on_the_right = &areas[MARGIN + first..][..LANES];
                for lane in 0..LANES {
                    let left = on_the_left[lane] | (RADIUS + 1 - distance) as u32;
                    let right = on_the_right[lane] | (RADIUS + distance) as u32;
                    best[lane] = best[lane].min(left).min(right);
                }
            }
            for lane in 0..LANES {
                let position = best[lane] & POSITION_MASK;
                let skips_own = u32::from(position > RADIUS as u32);
                let step = if position == 0 { RADIUS as u32 + 1 } else { position + skips_own };
                partners[first + lane] = (first + lane) as u32 + step - (RADIUS as u32 + 1);
            }
        }
        partners
    }

    /// Merges mutual nearest neighbours.
    #[inline(always)]
    fn merge(&mut self, partners: &[u32; CAPACITY], merger: &mut Merger<'_>) {
        // Without a branch per cluster: the clusters that stay, their partners, and which of them
        // merge.
        let mut kept = [[0_u32; 2]; CAPACITY];
        let mut merged = [0_u32; CAPACITY];
        let (mut left, mut merges) = (0, 0);
        for at in 0..self.len {
            let partner = partners[at] as usize % CAPACITY;
            let mutual = partners[partner] as usize == at && partner != at;
            kept[left] = [at as u32, if mutual { partner as u32 } else { at as u32 }];
            merged[merges] = left as u32;
            merges += usize::from(mutual && at < partner);
            left += usize::from(!(mutual && partner < at));
        }
        for &at_kept in &merged[..merges] {
            let [a, b] = kept[at_kept as usize % CAPACITY].map(|at| at as usize % CAPACITY);
            self.kinds[a] = merger.join(self, a, b);
        }
        for at_kept in 0..left {
            let [a, b] = kept[at_kept].map(|at| at as usize % CAPACITY);
            for axis in 0..3 {
                let min = &mut self.min[axis];
                min[MARGIN + at_kept] = fast_min(min[MARGIN + a], min[MARGIN + b]);
                let max = &mut self.max[axis];
                max[MARGIN + at_kept] = fast_max(max[MARGIN + a], max[MARGIN + b]);
            }
            self.kinds[at_kept] = self.kinds[a];
        }
        self.shorten(left);
    }
}

/// The boxes of eight consecutive clusters: lower planes, then upper ones.
#[inline(always)]
fn lanes<'a>(min: &'a [[f32; PADDED]; 3], max: &'a [[f32; PADDED]; 3], from: usize) -> [&'a [f32; LANES]; 6] {
    [
        eight(&min[0], from),
        eight(&min[1], from),
        eight(&min[2], from),
        eight(&max[0], from),
        eight(&max[1], from),
        eight(&max[2], from),
    ]
}

/// Eight consecutive values.
#[inline(always)]
fn eight(plane: &[f32; PADDED], from: usize) -> &[f32; LANES] {
    plane[from..].first_chunk().expect("the margin is as wide as the radius and the lanes")
}

/// The half areas of the joint boxes of eight pairs.
#[inline(always)]
fn joint_areas(a: &[&[f32; LANES]; 6], b: &[&[f32; LANES]; 6]) -> [f32; LANES] {
    std::array::from_fn(|lane| {
        let extent =
            |axis: usize| fast_max(a[3 + axis][lane], b[3 + axis][lane]) - fast_min(a[axis][lane], b[axis][lane]);
        let (x, y, z) = (extent(0), extent(1), extent(2));
        x * y + z * (x + y)
    })
}

impl Merger<'_> {
    /// Merges two clusters: two small leaves become one leaf if that costs less; others become the
    /// children of a node.
    #[inline(always)]
    fn join(&mut self, active: &ActiveClusters, left: usize, right: usize) -> Kind {
        let (a, b) = (active.kinds[left], active.kinds[right]);
        let primitives = a.primitives + b.primitives;
        let may_be_leaf = a.height == 1 && b.height == 1 && primitives <= self.leaf_limit;
        if may_be_leaf && self.is_cheaper_as_leaf(primitives, || [left, right].map(|at| active.cluster(at))) {
            return a.chained(&b, self.chains);
        }
        let link = self.pairs.len() as u32;
        self.pairs.push(Pair {
            bounds: [active.bounds(left), active.bounds(right)],
            links: [a.link, b.link],
            heights: [a.height, b.height],
        });
        Kind { link, primitives, leaves: a.leaves + b.leaves, height: a.height.max(b.height) + 1 }
    }

    #[inline(always)]
    fn is_cheaper_as_leaf(&self, primitives: u32, pair: impl Fn() -> [Cluster; 2]) -> bool {
        // A node visit costs more than all the tests in it.
        if primitives as f32 <= self.node_cost {
            return true;
        }
        let pair = pair();
        let area = pair[0].bounds.union(&pair[1].bounds).half_area();
        let tests = |cluster: &Cluster| cluster.kind.primitives as f32 * cluster.bounds.half_area();
        area * primitives as f32 <= self.node_cost * area + tests(&pair[0]) + tests(&pair[1])
    }
}

struct Reduce<'a, 'b> {
    active: &'a mut ActiveClusters,
    target: usize,
    radius: usize,
    merger: &'a mut Merger<'b>,
}

impl Kernel for Reduce<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, _: I) {
        let Self { active, target, radius, merger } = self;
        while active.len > target {
            let before = active.len;
            let partners = active.partners(radius);
            active.merge(&partners, merger);
            if active.len == before {
                // All areas are infinite or NaN: merge adjacent clusters.
                active
                    .merge(&std::array::from_fn(|at| if at | 1 < before { at as u32 ^ 1 } else { at as u32 }), merger);
            }
        }
    }
}
