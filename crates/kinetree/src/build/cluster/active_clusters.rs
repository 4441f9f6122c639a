//! A few dozen clusters in the order of the curve, ready to be merged.
//!
//! Each looks a few places to both sides for the partner with which it makes the smallest box, eight clusters at a step; the box around two is measured once,
//! for both. Those that choose each other merge, all at the same time, until few enough are left.

use super::pair::{Cluster, Kind, Pair};
use crate::geometry::Aabb;
use crate::simd::{Isa, Kernel, Level};

/// How many clusters a front has room for.
pub(super) const FULL: usize = 64;

/// How many it is merged down to before it is joined with its neighbour.
pub(super) const FEW: usize = FULL / 2;

/// How far a cluster looks to each side, at most.
pub(super) const RADIUS: usize = 6;

/// How far a single primitive looks. Further has not made better trees.
pub(super) const NEAR: usize = 4;

const LANES: usize = 8;

/// Room on both sides, so that looking sideways needs no bounds.
const MARGIN: usize = 16;
const ROOM: usize = MARGIN + FULL + MARGIN;

const _: () = assert!(RADIUS + LANES <= MARGIN && FULL % LANES == 0);

/// The last bits of an area make room for the place of a neighbour: from 1 for the leftmost to twice the radius for the rightmost.
const PLACE_MASK: u32 = 15;
const _: () = assert!(2 * RADIUS as u32 <= PLACE_MASK);

/// No neighbour at all: before every one with an area beyond measure.
const ALONE: u32 = f32::INFINITY.to_bits();

/// Clusters, their boxes one plane at a time.
pub(super) struct ActiveClusters {
    len: usize,
    min: [[f32; ROOM]; 3],
    max: [[f32; ROOM]; 3],
    kinds: [Kind; FULL],
    /// `areas[distance - 1][left]`: the bits of the area around two that stand so far apart, but for the last ones.
    areas: [[u32; ROOM]; RADIUS],
}

/// What merging clusters needs to know, and where it writes to.
pub(super) struct Merger<'a> {
    pub(super) pairs: &'a mut Vec<Pair>,
    /// Primitives, each with the place of the next one in its leaf.
    pub(super) chains: &'a mut [u64],
    pub(super) leaf_limit: u32,
    pub(super) node_cost: f32,
}

impl ActiveClusters {
    pub(super) fn new() -> Self {
        // Who is everywhere is nobody's best partner.
        Self {
            len: 0,
            min: [[f32::NEG_INFINITY; ROOM]; 3],
            max: [[f32::INFINITY; ROOM]; 3],
            kinds: [Kind::default(); FULL],
            areas: [[ALONE; ROOM]; RADIUS],
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

    /// Merges until no more than `few` are left; each looks at most `radius` places to both sides.
    pub(super) fn reduce(&mut self, few: usize, radius: usize, level: Level, merger: &mut Merger<'_>) {
        if self.len > few {
            level.run(Reduce { active: self, few, radius, merger });
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

    /// The best partner of each cluster; of equal ones the first. A cluster without any is its own.
    ///
    /// Of all pairs with the least area, the first one chooses each other, so there is always something to merge unless all areas are beyond measure.
    #[inline(always)]
    fn partners(&mut self, radius: usize) -> [u32; FULL] {
        let radius = radius.min(RADIUS);
        for first in (0..self.len).step_by(LANES) {
            let own = lanes(&self.min, &self.max, MARGIN + first);
            for distance in 1..=radius {
                let areas = joint_areas(&own, &lanes(&self.min, &self.max, MARGIN + first + distance));
                let place = &mut self.areas[distance - 1][MARGIN + first..][..LANES];
                for lane in 0..LANES {
                    place[lane] = areas[lane].to_bits() & !PLACE_MASK;
                }
            }
        }
        let mut partners = [0; FULL];
        for first in (0..self.len).step_by(LANES) {
            let mut best = [ALONE; LANES];
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
                let place = best[lane] & PLACE_MASK;
                let skips_own = u32::from(place > RADIUS as u32);
                let step = if place == 0 { RADIUS as u32 + 1 } else { place + skips_own };
                partners[first + lane] = (first + lane) as u32 + step - (RADIUS as u32 + 1);
            }
        }
        partners
    }

    /// Merges those who chose each other.
    #[inline(always)]
    fn merge(&mut self, partners: &[u32; FULL], merger: &mut Merger<'_>) {
        // Without a branch per cluster: who stays, with whom, and which of them are merged.
        let mut stays = [[0_u32; 2]; FULL];
        let mut merged = [0_u32; FULL];
        let (mut left, mut merges) = (0, 0);
        for at in 0..self.len {
            let partner = partners[at] as usize % FULL;
            let mutual = partners[partner] as usize == at && partner != at;
            stays[left] = [at as u32, if mutual { partner as u32 } else { at as u32 }];
            merged[merges] = left as u32;
            merges += usize::from(mutual && at < partner);
            left += usize::from(!(mutual && partner < at));
        }
        for &stay in &merged[..merges] {
            let [one, other] = stays[stay as usize % FULL].map(|at| at as usize % FULL);
            self.kinds[one] = merger.join(self, one, other);
        }
        for stay in 0..left {
            let [one, other] = stays[stay].map(|at| at as usize % FULL);
            for axis in 0..3 {
                let min = &mut self.min[axis];
                min[MARGIN + stay] = lesser(min[MARGIN + one], min[MARGIN + other]);
                let max = &mut self.max[axis];
                max[MARGIN + stay] = greater(max[MARGIN + one], max[MARGIN + other]);
            }
            self.kinds[stay] = self.kinds[one];
        }
        self.shorten(left);
    }
}

/// The boxes of eight clusters in a row: lower planes, then upper ones.
#[inline(always)]
fn lanes<'a>(min: &'a [[f32; ROOM]; 3], max: &'a [[f32; ROOM]; 3], from: usize) -> [&'a [f32; LANES]; 6] {
    [
        eight(&min[0], from),
        eight(&min[1], from),
        eight(&min[2], from),
        eight(&max[0], from),
        eight(&max[1], from),
        eight(&max[2], from),
    ]
}

/// Eight in a row.
#[inline(always)]
fn eight(plane: &[f32; ROOM], from: usize) -> &[f32; LANES] {
    plane[from..].first_chunk().expect("the margin is as wide as the radius and the lanes")
}

#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Half areas of the boxes around two, eight at a time.
#[inline(always)]
fn joint_areas(a: &[&[f32; LANES]; 6], b: &[&[f32; LANES]; 6]) -> [f32; LANES] {
    std::array::from_fn(|lane| {
        let extent = |axis: usize| greater(a[3 + axis][lane], b[3 + axis][lane]) - lesser(a[axis][lane], b[axis][lane]);
        let (x, y, z) = (extent(0), extent(1), extent(2));
        x * y + z * (x + y)
    })
}

impl Merger<'_> {
    /// Two leaves that are small enough become one if that is cheaper; others become the children of a node.
    #[inline(always)]
    fn join(&mut self, active: &ActiveClusters, left: usize, right: usize) -> Kind {
        let (one, other) = (active.kinds[left], active.kinds[right]);
        let primitives = one.primitives + other.primitives;
        let may_be_leaf = one.height == 1 && other.height == 1 && primitives <= self.leaf_limit;
        if may_be_leaf && self.is_cheaper_as_leaf(primitives, || [left, right].map(|at| active.cluster(at))) {
            return one.chained(&other, self.chains);
        }
        let link = self.pairs.len() as u32;
        self.pairs.push(Pair {
            bounds: [active.bounds(left), active.bounds(right)],
            links: [one.link, other.link],
            heights: [one.height, other.height],
        });
        Kind { link, primitives, leaves: one.leaves + other.leaves, height: one.height.max(other.height) + 1 }
    }

    #[inline(always)]
    fn is_cheaper_as_leaf(&self, primitives: u32, pair: impl Fn() -> [Cluster; 2]) -> bool {
        // A box costs more than all the tests behind it.
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
    few: usize,
    radius: usize,
    merger: &'a mut Merger<'b>,
}

impl Kernel for Reduce<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, _: I) {
        let Self { active, few, radius, merger } = self;
        while active.len > few {
            let before = active.len;
            let partners = active.partners(radius);
            active.merge(&partners, merger);
            if active.len == before {
                // Areas beyond measure: neighbours.
                active
                    .merge(&std::array::from_fn(|at| if at | 1 < before { at as u32 ^ 1 } else { at as u32 }), merger);
            }
        }
    }
}
