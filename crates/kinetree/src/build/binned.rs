//! Top-down construction by the surface area heuristic, on a few planes per axis.
//!
//! The centres of the references are sorted into equal bins along each axis; cuts are tried between bins. Building costs a few passes over the
//! references per level, and the trees are nearly as good as those of a full sweep, which small sets get.
//!
//! Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies".

use glam::Vec3A;

use super::BuildOptions;
use super::cut::{Chooser, Cut};
use super::grow::grow;
use super::reference::{GRAIN, Reference, references};
use crate::geometry::Aabb;
use crate::threads::Threads;
use crate::tree::Bvh;

/// A tree over primitives 0, 1, ... below `count`, whose boxes `bounds_of` knows. Primitives with an empty box are left out. The same tree
/// for any number of threads.
///
/// # Panics
/// When there are more primitives than 2^27.
pub fn binned(count: usize, bounds_of: impl Fn(u32) -> Aabb + Sync, options: &BuildOptions) -> Bvh {
    let references = references(count, &bounds_of, &options.threads);
    grow(references, &Binned { node_cost: options.node_cost }, options)
}

/// Sets up to this size are swept: every place between two sorted references is tried.
const SWEPT: usize = 8;

struct Binned {
    node_cost: f32,
}

impl Chooser for Binned {
    fn choose(&self, references: &mut [Reference], bounds: &Aabb, threads: &Threads) -> Cut {
        let area = bounds.half_area();
        let as_leaf = area * references.len() as f32;
        let worth_it = |cost: f32| cost + self.node_cost * area < as_leaf;
        if references.len() <= SWEPT {
            return match sweep(references) {
                Some((cost, left)) if worth_it(cost) => Cut::Object { left },
                _ => Cut::Leaf,
            };
        }
        let binning = Binning::over(references, threads);
        match best_plane(references, &binning, threads) {
            Some(plane) if worth_it(plane.cost) => {
                Cut::Object { left: partition(references, |one| binning.bins(one)[plane.axis] < plane.bin) }
            }
            _ => Cut::Leaf,
        }
    }
}

/// A box in vector registers.
#[derive(Clone, Copy)]
struct Box4 {
    min: Vec3A,
    max: Vec3A,
}

impl Box4 {
    const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    #[inline(always)]
    fn of(reference: &Reference) -> Self {
        Self { min: reference.bounds.min.into(), max: reference.bounds.max.into() }
    }

    #[inline(always)]
    fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    #[inline(always)]
    fn half_area(self) -> f32 {
        let e = (self.max - self.min).max(Vec3A::ZERO);
        e.x * e.y + e.y * e.z + e.z * e.x
    }
}

/// Tries every place between references sorted along each axis; leaves them sorted along the best. The cost of both sides in primitive tests, each times its
/// area, and how many go to the left.
fn sweep(references: &mut [Reference]) -> Option<(f32, usize)> {
    let count = references.len();
    let mut best: Option<(f32, usize, usize)> = None;
    let mut above = [0.0; SWEPT];
    for axis in 0..3 {
        sort(references, axis);
        let mut side = Box4::EMPTY;
        for left in (1..count).rev() {
            side = side.union(Box4::of(&references[left]));
            above[left] = side.half_area() * (count - left) as f32;
        }
        let mut side = Box4::EMPTY;
        for left in 1..count {
            side = side.union(Box4::of(&references[left - 1]));
            let cost = side.half_area() * left as f32 + above[left];
            if cost.is_finite() && best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, left, axis));
            }
        }
    }
    let (cost, left, axis) = best?;
    if axis != 2 {
        sort(references, axis);
    }
    Some((cost, left))
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
            piece.iter().fold(Box4::EMPTY, |all, one| {
                let middle = middle(one);
                Box4 { min: all.min.min(middle), max: all.max.max(middle) }
            })
        };
        let middles = threads.reduce(references, GRAIN, &around, &|a, b| a.union(b));
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
        let place = (middle(reference) - self.start) * self.scale + (12_582_912.0 - 0.5);
        let most = self.count - 1;
        place.to_array().map(|x| ((x.to_bits() & 63) as usize).min(most))
    }
}

/// Twice the middle of a reference's box.
#[inline(always)]
fn middle(reference: &Reference) -> Vec3A {
    Vec3A::from(reference.bounds.min) + Vec3A::from(reference.bounds.max)
}

/// Bins below `bin` on one side, the others on the other.
struct Plane {
    axis: usize,
    bin: usize,
    /// Primitive tests of both sides, each times its area.
    cost: f32,
}

#[derive(Clone, Copy)]
struct Bins {
    boxes: [[Box4; MOST_BINS]; 3],
    counts: [[u32; MOST_BINS]; 3],
}

impl Bins {
    #[inline(always)]
    fn clear(&mut self, count: usize) {
        for axis in 0..3 {
            self.boxes[axis][..count].fill(Box4::EMPTY);
            self.counts[axis][..count].fill(0);
        }
    }

    #[inline(always)]
    fn add(&mut self, bins: [usize; 3], bounds: Box4) {
        for axis in 0..3 {
            let bin = bins[axis] & (MOST_BINS - 1);
            self.boxes[axis][bin] = self.boxes[axis][bin].union(bounds);
            self.counts[axis][bin] += 1;
        }
    }

    fn merge(&mut self, other: &Self, count: usize) {
        for axis in 0..3 {
            for bin in 0..count {
                self.boxes[axis][bin] = self.boxes[axis][bin].union(other.boxes[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
    }
}

/// The cheapest plane, if one divides the references.
fn best_plane(references: &[Reference], binning: &Binning, threads: &Threads) -> Option<Plane> {
    let empty = Bins { boxes: [[Box4::EMPTY; MOST_BINS]; 3], counts: [[0; MOST_BINS]; 3] };
    if references.len() > GRAIN {
        let fill = |piece: &[Reference]| {
            let mut bins = Box::new([empty; 2]);
            fill(piece, binning, &mut bins);
            bins
        };
        let merge = |mut one: Box<[Bins; 2]>, other: Box<[Bins; 2]>| {
            one[0].merge(&other[0], binning.count);
            one
        };
        return cheapest(&threads.reduce(references, GRAIN, &fill, &merge)[0], binning.count, references.len());
    }
    SCRATCH.with_borrow_mut(|bins| {
        fill(references, binning, bins);
        cheapest(&bins[0], binning.count, references.len())
    })
}

thread_local! {
    /// Bins of small sets, which are filled too often to be made anew. Only as many as are in use are cleared.
    static SCRATCH: std::cell::RefCell<Box<[Bins; 2]>> =
        std::cell::RefCell::new(Box::new([Bins { boxes: [[Box4::EMPTY; MOST_BINS]; 3], counts: [[0; MOST_BINS]; 3] }; 2]));
}

/// Fills the first of two sets of bins. Both are used in turn, so that neighbours that fall into the same bin need not wait for each other.
fn fill(references: &[Reference], binning: &Binning, bins: &mut [Bins; 2]) {
    bins.iter_mut().for_each(|bins| bins.clear(binning.count));
    let [even, odd] = bins;
    let (pairs, rest) = references.as_chunks::<2>();
    for [one, other] in pairs {
        even.add(binning.bins(one), Box4::of(one));
        odd.add(binning.bins(other), Box4::of(other));
    }
    rest.iter().for_each(|one| even.add(binning.bins(one), Box4::of(one)));
    even.merge(odd, binning.count);
}

fn cheapest(bins: &Bins, count: usize, total: usize) -> Option<Plane> {
    let mut best: Option<Plane> = None;
    for axis in 0..3 {
        let (boxes, counts) = (&bins.boxes[axis], &bins.counts[axis]);
        if counts[..count].iter().any(|&bin| bin as usize == total) {
            continue;
        }
        // From above: what each plane leaves on its upper side.
        let mut above = [0.0; MOST_BINS];
        let (mut side, mut number) = (Box4::EMPTY, 0);
        for bin in (1..count).rev() {
            side = side.union(boxes[bin]);
            number += counts[bin];
            above[bin] = side.half_area() * number as f32;
        }
        let (mut side, mut number) = (Box4::EMPTY, 0);
        for bin in 1..count {
            side = side.union(boxes[bin - 1]);
            number += counts[bin - 1];
            let cost = side.half_area() * number as f32 + above[bin];
            let divides = number > 0 && (number as usize) < total;
            if divides && cost.is_finite() && best.as_ref().is_none_or(|best| cost < best.cost) {
                best = Some(Plane { axis, bin, cost });
            }
        }
    }
    best
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
