//! Object splits: the best partition of a set of references, none of which is split.
//!
//! The centres of the references are binned along each axis, and the planes between bins are
//! candidates. Small sets are swept: sorted along each axis, and every partition of the sorted list
//! is a candidate.
//!
//! Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies".

use glam::Vec3A;

use super::cut::{Cut, Side};
use super::fast_box::FastBox;
use super::reference::{GRAIN, Reference};
use crate::simd::{Isa, Kernel, Level};
use crate::threads::Threads;

/// The largest set that is swept instead of binned.
const MAX_SWEPT: usize = 8;

/// A partition and its cost.
pub(super) struct ObjectCut {
    /// The sum over both sides of the number of primitive tests times the half area.
    pub(super) cost: f32,
    /// The boxes of both sides.
    sides: [FastBox; 2],
    boundary: Boundary,
}

enum Boundary {
    /// The left side is this many references, in the order that `best` left.
    Sorted(usize),
    /// The left side is the bins below this one.
    Bin { axis: usize, bin: usize, binning: Binning },
}

impl ObjectCut {
    /// The partition of least cost, where `tests` is the cost of testing a number of primitives.
    /// `None` if the references cannot be divided. May reorder them.
    pub(super) fn best(references: &mut [Reference], tests: &impl Fn(u32) -> f32, threads: &Threads) -> Option<Self> {
        if references.len() <= MAX_SWEPT { sweep(references, tests) } else { best_plane(references, tests, threads) }
    }

    /// The half area of the intersection of both sides.
    pub(super) fn overlap(&self) -> f32 {
        self.sides[0].common_area(&self.sides[1])
    }

    /// Moves the left side to the front. Swept references must still be in the order that `best`
    /// left; binned ones may have been reordered.
    pub(super) fn apply(&self, references: &mut [Reference]) -> Cut {
        let left = match &self.boundary {
            Boundary::Sorted(left) => *left,
            Boundary::Bin { axis, bin, binning } => {
                let along = binning.along(*axis);
                partition(references, |reference| along.bin(reference) < *bin)
            }
        };
        let counts = [left, references.len() - left];
        Cut::Sides([0, 1].map(|side| Side { count: counts[side], bounds: self.sides[side].into() }))
    }
}

/// Tries every partition along each axis, and leaves the references sorted along the best axis.
fn sweep(references: &mut [Reference], tests: &impl Fn(u32) -> f32) -> Option<ObjectCut> {
    let count = references.len();
    let mut best: Option<(f32, usize, usize)> = None;
    let mut above = [0.0; MAX_SWEPT];
    for axis in 0..3 {
        sort(references, axis);
        let mut side = FastBox::EMPTY;
        for left in (1..count).rev() {
            side = side.union(&FastBox::of(&references[left]));
            above[left] = side.half_area() * tests((count - left) as u32);
        }
        let mut side = FastBox::EMPTY;
        for left in 1..count {
            side = side.union(&FastBox::of(&references[left - 1]));
            let cost = side.half_area() * tests(left as u32) + above[left];
            if cost.is_finite() && best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, left, axis));
            }
        }
    }
    let (cost, left, axis) = best?;
    if axis != 2 {
        sort(references, axis);
    }
    let around =
        |side: &[Reference]| side.iter().fold(FastBox::EMPTY, |all, reference| all.union(&FastBox::of(reference)));
    let (left_side, right_side) = references.split_at(left);
    Some(ObjectCut { cost, sides: [around(left_side), around(right_side)], boundary: Boundary::Sorted(left) })
}

/// Insertion sort by centre along an axis, then by index.
fn sort(references: &mut [Reference], axis: usize) {
    let before = |a: &Reference, b: &Reference| {
        let (x, y) = (a.bounds.min[axis] + a.bounds.max[axis], b.bounds.min[axis] + b.bounds.max[axis]);
        x < y || (x == y && a.id < b.id)
    };
    for i in 1..references.len() {
        let reference = references[i];
        let mut at = i;
        while at > 0 && before(&reference, &references[at - 1]) {
            references[at] = references[at - 1];
            at -= 1;
        }
        references[at] = reference;
    }
}

/// The largest number of bins per axis.
const MAX_BINS: usize = 32;

/// Maps references to bins along all axes.
struct Binning {
    start: Vec3A,
    scale: Vec3A,
    count: usize,
}

impl Binning {
    fn over(references: &[Reference], threads: &Threads) -> Self {
        let around = |slice: &[Reference]| {
            slice.iter().fold(FastBox::EMPTY, |all, reference| {
                let doubled_center = doubled_center(reference);
                FastBox { min: all.min.min(doubled_center), max: all.max.max(doubled_center) }
            })
        };
        let centers = threads.reduce(references, GRAIN, &around, &|a, b| a.union(&b));
        let count = match references.len() {
            0..=256 => 8,
            257..=4096 => 16,
            _ => MAX_BINS,
        };
        let scale = (count as f32 * (1.0 - 1e-6)) / (centers.max - centers.min);
        // An axis without extent, or whose extent overflows, has all references in one bin.
        let usable = scale.is_finite_mask() & (centers.max - centers.min).is_finite_mask();
        Self { start: centers.min, scale: Vec3A::select(usable, scale, Vec3A::ZERO), count }
    }

    /// The bin along each axis.
    #[inline(always)]
    fn bins(&self, reference: &Reference) -> [usize; 3] {
        // Adding 1.5 * 2^23 rounds to an integer in the lowest bits of the sum.
        let scaled = (doubled_center(reference) - self.start) * self.scale + ROUNDS;
        let last = self.count - 1;
        scaled.to_array().map(|x| ((x.to_bits() & 63) as usize).min(last))
    }

    fn along(&self, axis: usize) -> BinsAlong {
        BinsAlong { axis, start: self.start[axis], scale: self.scale[axis], last: self.count - 1 }
    }
}

/// 1.5 * 2^23 - 0.5, so that rounding to nearest becomes rounding down.
const ROUNDS: f32 = 12_582_912.0 - 0.5;

/// Maps references to bins along one axis.
struct BinsAlong {
    axis: usize,
    start: f32,
    scale: f32,
    last: usize,
}

impl BinsAlong {
    /// The same bin as [`Binning::bins`] gives for the axis.
    #[inline(always)]
    fn bin(&self, reference: &Reference) -> usize {
        let doubled_center = reference.bounds.min[self.axis] + reference.bounds.max[self.axis];
        let scaled = (doubled_center - self.start) * self.scale + ROUNDS;
        ((scaled.to_bits() & 63) as usize).min(self.last)
    }
}

/// Twice the centre of a reference's box.
#[inline(always)]
fn doubled_center(reference: &Reference) -> Vec3A {
    Vec3A::from(reference.bounds.min) + Vec3A::from(reference.bounds.max)
}

/// A plane between bins.
struct Cheapest {
    cost: f32,
    sides: [FastBox; 2],
    axis: usize,
    bin: usize,
}

/// A box as eight lanes, so that one `max` extends it: the negated lower corner, the upper corner,
/// and two unused lanes.
type BoxLanes = [f32; 8];

const EMPTY_LANES: BoxLanes = [f32::NEG_INFINITY; 8];

/// Flips the signs of the lower corner.
const LOWER_END: [u32; 8] = [1 << 31, 1 << 31, 1 << 31, 0, 0, 0, 0, 0];

#[inline(always)]
fn box_of(lanes: &BoxLanes) -> FastBox {
    let [a, b, c, d, e, f, ..] = *lanes;
    FastBox { min: -Vec3A::new(a, b, c), max: Vec3A::new(d, e, f) }
}

#[derive(Clone, Copy)]
struct Bins {
    boxes: [[BoxLanes; MAX_BINS]; 3],
    counts: [[u32; MAX_BINS]; 3],
}

impl Bins {
    const EMPTY: Self = Self { boxes: [[EMPTY_LANES; MAX_BINS]; 3], counts: [[0; MAX_BINS]; 3] };

    #[inline(always)]
    fn clear(&mut self, count: usize) {
        for axis in 0..3 {
            self.boxes[axis][..count].fill(EMPTY_LANES);
            self.counts[axis][..count].fill(0);
        }
    }

    #[inline(always)]
    fn add<I: Isa>(&mut self, isa: I, binning: &Binning, reference: &Reference) {
        let bins = binning.bins(reference);
        let lanes = isa.xor_sign(isa.load(reference.lanes()), &LOWER_END);
        for axis in 0..3 {
            let bin = bins[axis] & (MAX_BINS - 1);
            let slot = &mut self.boxes[axis][bin];
            *slot = isa.store(isa.max(lanes, isa.load(slot)));
            self.counts[axis][bin] += 1;
        }
    }

    /// The plane of least cost that divides the `total` references.
    fn cheapest(&self, count: usize, total: usize, tests: &impl Fn(u32) -> f32) -> Option<Cheapest> {
        let mut best: Option<Cheapest> = None;
        for axis in 0..3 {
            let (boxes, counts) = (&self.boxes[axis], &self.counts[axis]);
            if counts[..count].iter().any(|&bin| bin as usize == total) {
                continue;
            }
            // From the last bin down: the box and cost above each plane.
            let mut above = [(FastBox::EMPTY, 0.0); MAX_BINS];
            let (mut side, mut number) = (FastBox::EMPTY, 0);
            for bin in (1..count).rev() {
                side = side.union(&box_of(&boxes[bin]));
                number += counts[bin];
                above[bin] = (side, side.half_area() * tests(number));
            }
            let (mut side, mut number) = (FastBox::EMPTY, 0);
            for bin in 1..count {
                side = side.union(&box_of(&boxes[bin - 1]));
                number += counts[bin - 1];
                let (other, cost_above) = &above[bin];
                let cost = side.half_area() * tests(number) + cost_above;
                let divides = number > 0 && (number as usize) < total;
                if divides && cost.is_finite() && best.as_ref().is_none_or(|best| cost < best.cost) {
                    best = Some(Cheapest { cost, sides: [side, *other], axis, bin });
                }
            }
        }
        best
    }

    fn merge(&mut self, other: &Self, count: usize) {
        for axis in 0..3 {
            for bin in 0..count {
                for (lane, other) in self.boxes[axis][bin].iter_mut().zip(&other.boxes[axis][bin]) {
                    *lane = if *other > *lane { *other } else { *lane };
                }
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
    }
}

/// The plane between bins of least cost, if one divides the references.
fn best_plane(references: &[Reference], tests: &impl Fn(u32) -> f32, threads: &Threads) -> Option<ObjectCut> {
    let binning = Binning::over(references, threads);
    let best = if references.len() > GRAIN {
        let fill = |slice: &[Reference]| {
            let mut bins = Box::new([Bins::EMPTY; 2]);
            fill(slice, &binning, &mut bins);
            bins
        };
        let merge = |mut one: Box<[Bins; 2]>, other: Box<[Bins; 2]>| {
            one[0].merge(&other[0], binning.count);
            one
        };
        threads.reduce(references, GRAIN, &fill, &merge)[0].cheapest(binning.count, references.len(), tests)
    } else {
        SCRATCH.with_borrow_mut(|bins| {
            fill(references, &binning, bins);
            bins[0].cheapest(binning.count, references.len(), tests)
        })
    };
    let Cheapest { cost, sides, axis, bin } = best?;
    Some(ObjectCut { cost, sides, boundary: Boundary::Bin { axis, bin, binning } })
}

thread_local! {
    /// The bins of small sets, reused because initialising them takes long. Only those in use are
    /// cleared.
    static SCRATCH: std::cell::RefCell<Box<[Bins; 2]>> =
        std::cell::RefCell::new(Box::new([Bins::EMPTY; 2]));
}

/// Fills the first of two sets of bins. References alternate between the sets, so that successive
/// ones in the same bin do not depend on each other.
fn fill(references: &[Reference], binning: &Binning, bins: &mut [Bins; 2]) {
    Level::current().run(Fill { references, binning, bins });
}

struct Fill<'a> {
    references: &'a [Reference],
    binning: &'a Binning,
    bins: &'a mut [Bins; 2],
}

impl Kernel for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        let Self { references, binning, bins } = self;
        bins.iter_mut().for_each(|bins| bins.clear(binning.count));
        let [even, odd] = bins;
        let (pairs, rest) = references.as_chunks::<2>();
        for [first, second] in pairs {
            even.add(isa, binning, first);
            odd.add(isa, binning, second);
        }
        rest.iter().for_each(|one| even.add(isa, binning, one));
        even.merge(odd, binning.count);
    }
}

/// Moves the references of the left side to the front and returns their number. Always swaps, to
/// avoid a branch that would be mispredicted.
fn partition(references: &mut [Reference], is_left: impl Fn(&Reference) -> bool) -> usize {
    let mut left = 0;
    for i in 0..references.len() {
        let goes_left = is_left(&references[i]);
        references.swap(i, left);
        left += usize::from(goes_left);
    }
    left
}
