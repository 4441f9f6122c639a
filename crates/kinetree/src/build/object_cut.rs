//! The best way of sharing whole references out to two sides.
//!
//! The centres of the references are sorted into equal bins along each axis, and cuts are tried between bins. Few references are swept: sorted along each axis,
//! and every place between two of them is tried.
//!
//! Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies".

use glam::Vec3A;

use super::cut::{Cut, Side};
use super::fast_box::FastBox;
use super::reference::{GRAIN, Reference};
use crate::simd::{Isa, Kernel, Level};
use crate::threads::Threads;

/// Sets up to this size are swept.
const SWEPT: usize = 8;

/// A way of sharing out, and what it would cost.
pub(super) struct ObjectCut {
    /// Primitive tests of both sides, each times its area.
    pub(super) cost: f32,
    /// The boxes around both sides.
    sides: [FastBox; 2],
    place: Place,
}

enum Place {
    /// As many on the left, as now ordered.
    Sorted(usize),
    /// Bins below this one are on the left.
    Bin { axis: usize, bin: usize, binning: Binning },
}

impl ObjectCut {
    /// The cheapest, when so many primitives take `tests` of them; none if nothing divides the references. They may come out in another order.
    pub(super) fn best(references: &mut [Reference], tests: &impl Fn(u32) -> f32, threads: &Threads) -> Option<Self> {
        if references.len() <= SWEPT { sweep(references, tests) } else { best_plane(references, tests, threads) }
    }

    /// Area that both sides have in common.
    pub(super) fn overlap(&self) -> f32 {
        self.sides[0].common_area(&self.sides[1])
    }

    /// Brings the left side to the front. The references stand as `best` has left them, or in another order if they are more than a few.
    pub(super) fn carry_out(&self, references: &mut [Reference]) -> Cut {
        let left = match &self.place {
            Place::Sorted(left) => *left,
            Place::Bin { axis, bin, binning } => {
                let place = binning.along(*axis);
                partition(references, |one| place.bin(one) < *bin)
            }
        };
        let counts = [left, references.len() - left];
        Cut::Sides([0, 1].map(|side| Side { count: counts[side], bounds: self.sides[side].into() }))
    }
}

/// Tries every place between references sorted along each axis, and leaves them sorted along the best.
fn sweep(references: &mut [Reference], tests: &impl Fn(u32) -> f32) -> Option<ObjectCut> {
    let count = references.len();
    let mut best: Option<(f32, usize, usize)> = None;
    let mut above = [0.0; SWEPT];
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
    let around = |side: &[Reference]| side.iter().fold(FastBox::EMPTY, |all, one| all.union(&FastBox::of(one)));
    let (here, there) = references.split_at(left);
    Some(ObjectCut { cost, sides: [around(here), around(there)], place: Place::Sorted(left) })
}

/// By the middle along an axis, then by number.
fn sort(references: &mut [Reference], axis: usize) {
    let before = |a: &Reference, b: &Reference| {
        let (x, y) = (a.bounds.min[axis] + a.bounds.max[axis], b.bounds.min[axis] + b.bounds.max[axis]);
        x < y || (x == y && a.id < b.id)
    };
    for i in 1..references.len() {
        let one = references[i];
        let mut at = i;
        while at > 0 && before(&one, &references[at - 1]) {
            references[at] = references[at - 1];
            at -= 1;
        }
        references[at] = one;
    }
}

/// Most bins per axis.
const MOST_BINS: usize = 32;

/// Which bins a reference belongs to.
struct Binning {
    start: Vec3A,
    scale: Vec3A,
    count: usize,
}

impl Binning {
    fn over(references: &[Reference], threads: &Threads) -> Self {
        let around = |piece: &[Reference]| {
            piece.iter().fold(FastBox::EMPTY, |all, one| {
                let middle = middle(one);
                FastBox { min: all.min.min(middle), max: all.max.max(middle) }
            })
        };
        let middles = threads.reduce(references, GRAIN, &around, &|a, b| a.union(&b));
        let count = match references.len() {
            0..=256 => 8,
            257..=4096 => 16,
            _ => MOST_BINS,
        };
        let scale = (count as f32 * (1.0 - 1e-6)) / (middles.max - middles.min);
        // An axis without extent, or with an extent beyond all measure, puts all in one bin.
        let usable = scale.is_finite_mask() & (middles.max - middles.min).is_finite_mask();
        Self { start: middles.min, scale: Vec3A::select(usable, scale, Vec3A::ZERO), count }
    }

    /// One bin per axis.
    #[inline(always)]
    fn bins(&self, reference: &Reference) -> [usize; 3] {
        // Adding one and a half times 2^23 rounds to a whole number, which then stands in the lowest bits.
        let place = (middle(reference) - self.start) * self.scale + ROUNDS;
        let most = self.count - 1;
        place.to_array().map(|x| ((x.to_bits() & 63) as usize).min(most))
    }

    fn along(&self, axis: usize) -> BinsAlong {
        BinsAlong { axis, start: self.start[axis], scale: self.scale[axis], most: self.count - 1 }
    }
}

/// One and a half times 2^23, less a half.
const ROUNDS: f32 = 12_582_912.0 - 0.5;

/// The bins along one axis only.
struct BinsAlong {
    axis: usize,
    start: f32,
    scale: f32,
    most: usize,
}

impl BinsAlong {
    /// The same number as [`Binning::bins`] has for the axis.
    #[inline(always)]
    fn bin(&self, reference: &Reference) -> usize {
        let middle = reference.bounds.min[self.axis] + reference.bounds.max[self.axis];
        let place = (middle - self.start) * self.scale + ROUNDS;
        ((place.to_bits() & 63) as usize).min(self.most)
    }
}

/// Twice the middle of a reference's box.
#[inline(always)]
fn middle(reference: &Reference) -> Vec3A {
    Vec3A::from(reference.bounds.min) + Vec3A::from(reference.bounds.max)
}

/// A place between bins.
struct Cheapest {
    cost: f32,
    sides: [FastBox; 2],
    axis: usize,
    bin: usize,
}

/// A box that is extended in one step: its lower end with the other sign, then its upper end, then two numbers that mean nothing.
type Outward = [f32; 8];

const NOTHING: Outward = [f32::NEG_INFINITY; 8];

/// The signs that are changed.
const LOWER_END: [u32; 8] = [1 << 31, 1 << 31, 1 << 31, 0, 0, 0, 0, 0];

#[inline(always)]
fn inward(lanes: &Outward) -> FastBox {
    let [a, b, c, d, e, f, ..] = *lanes;
    FastBox { min: -Vec3A::new(a, b, c), max: Vec3A::new(d, e, f) }
}

#[derive(Clone, Copy)]
struct Bins {
    boxes: [[Outward; MOST_BINS]; 3],
    counts: [[u32; MOST_BINS]; 3],
}

impl Bins {
    const EMPTY: Self = Self { boxes: [[NOTHING; MOST_BINS]; 3], counts: [[0; MOST_BINS]; 3] };

    #[inline(always)]
    fn clear(&mut self, count: usize) {
        for axis in 0..3 {
            self.boxes[axis][..count].fill(NOTHING);
            self.counts[axis][..count].fill(0);
        }
    }

    #[inline(always)]
    fn add<I: Isa>(&mut self, isa: I, binning: &Binning, one: &Reference) {
        let bins = binning.bins(one);
        let outward = isa.xor_sign(isa.load8(one.lanes()), &LOWER_END);
        for axis in 0..3 {
            let bin = bins[axis] & (MOST_BINS - 1);
            let place = &mut self.boxes[axis][bin];
            *place = isa.store8(isa.max8(outward, isa.load8(place)));
            self.counts[axis][bin] += 1;
        }
    }

    /// The cheapest place that divides all the references, `total` of them.
    fn cheapest(&self, count: usize, total: usize, tests: &impl Fn(u32) -> f32) -> Option<Cheapest> {
        let mut best: Option<Cheapest> = None;
        for axis in 0..3 {
            let (boxes, counts) = (&self.boxes[axis], &self.counts[axis]);
            if counts[..count].iter().any(|&bin| bin as usize == total) {
                continue;
            }
            // From above: what each plane leaves on its upper side.
            let mut above = [(FastBox::EMPTY, 0.0); MOST_BINS];
            let (mut side, mut number) = (FastBox::EMPTY, 0);
            for bin in (1..count).rev() {
                side = side.union(&inward(&boxes[bin]));
                number += counts[bin];
                above[bin] = (side, side.half_area() * tests(number));
            }
            let (mut side, mut number) = (FastBox::EMPTY, 0);
            for bin in 1..count {
                side = side.union(&inward(&boxes[bin - 1]));
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

/// The cheapest place between bins, if one divides the references.
fn best_plane(references: &[Reference], tests: &impl Fn(u32) -> f32, threads: &Threads) -> Option<ObjectCut> {
    let binning = Binning::over(references, threads);
    let best = if references.len() > GRAIN {
        let fill = |piece: &[Reference]| {
            let mut bins = Box::new([Bins::EMPTY; 2]);
            fill(piece, &binning, &mut bins);
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
    Some(ObjectCut { cost, sides, place: Place::Bin { axis, bin, binning } })
}

thread_local! {
    /// Bins of small sets, which are filled too often to be made anew. Only as many as are in use are cleared.
    static SCRATCH: std::cell::RefCell<Box<[Bins; 2]>> =
        std::cell::RefCell::new(Box::new([Bins::EMPTY; 2]));
}

/// Fills the first of two sets of bins. Both are used in turn, so that neighbours that fall into the same bin need not wait for each other.
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
        for [one, other] in pairs {
            even.add(isa, binning, one);
            odd.add(isa, binning, other);
        }
        rest.iter().for_each(|one| even.add(isa, binning, one));
        even.merge(odd, binning.count);
    }
}

/// Brings what belongs to the left to the front, and says how many that are. Swaps always, so that there is no branch to guess wrongly.
fn partition(references: &mut [Reference], is_left: impl Fn(&Reference) -> bool) -> usize {
    let mut left = 0;
    for i in 0..references.len() {
        let goes_left = is_left(&references[i]);
        references.swap(i, left);
        left += usize::from(goes_left);
    }
    left
}
