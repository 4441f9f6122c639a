//! The best way of sharing whole references out to two sides.
//!
//! Few references are swept: sorted along each axis, and every place between two of them is tried. Many are binned (Wald 2007).

use super::cost::tests;
use super::fast_box::FastBox;
use crate::build::reference::{GRAIN, Reference};
use crate::geometry::Aabb;
use crate::threads::Threads;

/// Sets up to this size are swept.
const SWEPT: usize = 24;

const BINS: usize = 32;

/// A way of sharing out, and what it would cost.
pub(super) struct ObjectCut {
    /// Primitive tests of both sides, each times its area.
    pub(super) cost: f32,
    /// Area that both sides have in common.
    pub(super) overlap: f32,
    axis: usize,
    place: Place,
}

enum Place {
    /// As many on the left, when sorted.
    Sorted(usize),
    /// Bins below this one are on the left.
    Bin(usize, Binning),
}

impl ObjectCut {
    pub(super) fn best(references: &[Reference], threads: &Threads) -> Option<Self> {
        if references.len() <= SWEPT { swept(references) } else { binned(references, threads) }
    }

    /// Brings the left side to the front, and says how many that are.
    pub(super) fn carry_out(&self, references: &mut [Reference]) -> usize {
        match &self.place {
            Place::Sorted(left) => {
                sort(references, self.axis);
                *left
            }
            Place::Bin(bin, binning) => {
                let mut left = 0;
                for i in 0..references.len() {
                    if binning.bin(&references[i], self.axis) < *bin {
                        references.swap(i, left);
                        left += 1;
                    }
                }
                left
            }
        }
    }
}

fn sort(references: &mut [Reference], axis: usize) {
    references.sort_unstable_by(|a, b| a.center(axis).total_cmp(&b.center(axis)).then(a.id.cmp(&b.id)));
}

fn swept(references: &[Reference]) -> Option<ObjectCut> {
    let count = references.len();
    let mut sorted = [Reference { bounds: Aabb::EMPTY, id: 0 }; SWEPT];
    let sorted = &mut sorted[..count];
    sorted.copy_from_slice(references);
    let mut above = [FastBox::EMPTY; SWEPT + 1];
    let mut best: Option<ObjectCut> = None;
    for axis in 0..3 {
        sort(sorted, axis);
        for i in (1..count).rev() {
            above[i] = above[i + 1].union(&FastBox::from(&sorted[i].bounds));
        }
        above[count] = FastBox::EMPTY;
        let mut below = FastBox::EMPTY;
        for left in 1..count {
            below = below.union(&FastBox::from(&sorted[left - 1].bounds));
            let cost = below.half_area() * tests(left as u32) + above[left].half_area() * tests((count - left) as u32);
            if cost.is_finite() && best.as_ref().is_none_or(|best| cost < best.cost) {
                let overlap = overlap(&below, &above[left]);
                best = Some(ObjectCut { cost, overlap, axis, place: Place::Sorted(left) });
            }
        }
    }
    best
}

fn overlap(one: &FastBox, other: &FastBox) -> f32 {
    let common = one.intersection(other);
    if common.is_empty() { 0.0 } else { common.half_area() }
}

/// Which bin a centre belongs to.
struct Binning {
    start: [f32; 3],
    scale: [f32; 3],
}

impl Binning {
    fn over(centers: &Aabb) -> Self {
        let extent = centers.extent();
        let scale = extent.map(|length| {
            let scale = BINS as f32 * (1.0 - 1e-6) / length;
            // An axis without extent, or with an extent beyond all measure, puts all in one bin.
            if scale.is_finite() && length.is_finite() { scale } else { 0.0 }
        });
        Self { start: centers.min, scale }
    }

    #[inline(always)]
    fn bin(&self, reference: &Reference, axis: usize) -> usize {
        let place = (reference.center(axis) - self.start[axis]) * self.scale[axis];
        (place as usize).min(BINS - 1)
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: FastBox,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self { bounds: FastBox::EMPTY, count: 0 };

    #[inline(always)]
    fn with(&self, other: &Self) -> Self {
        Self { bounds: self.bounds.union(&other.bounds), count: self.count + other.count }
    }
}

type Bins = [[Bin; BINS]; 3];

fn binned(references: &[Reference], threads: &Threads) -> Option<ObjectCut> {
    let centers = |piece: &[Reference]| {
        Aabb::from_points(piece.iter().map(|reference| [0, 1, 2].map(|axis| reference.center(axis))))
    };
    let binning = Binning::over(&threads.reduce(references, GRAIN, &centers, &|a, b| a.union(&b)));
    let fill = |piece: &[Reference]| {
        let mut bins: Bins = [[Bin::EMPTY; BINS]; 3];
        for reference in piece {
            let one = Bin { bounds: FastBox::from(&reference.bounds), count: 1 };
            for axis in 0..3 {
                let bin = &mut bins[axis][binning.bin(reference, axis)];
                *bin = bin.with(&one);
            }
        }
        bins
    };
    let merge = |mut one: Bins, other: Bins| {
        one.iter_mut().flatten().zip(other.iter().flatten()).for_each(|(bin, more)| *bin = bin.with(more));
        one
    };
    let bins = threads.reduce(references, GRAIN, &fill, &merge);
    let mut best: Option<(f32, f32, usize, usize)> = None;
    for axis in 0..3 {
        let mut above = [Bin::EMPTY; BINS + 1];
        for bin in (1..BINS).rev() {
            above[bin] = above[bin + 1].with(&bins[axis][bin]);
        }
        let mut below = Bin::EMPTY;
        for bin in 1..BINS {
            below = below.with(&bins[axis][bin - 1]);
            let above = &above[bin];
            if below.count == 0 || above.count == 0 {
                continue;
            }
            let cost = below.bounds.half_area() * tests(below.count) + above.bounds.half_area() * tests(above.count);
            if cost.is_finite() && best.is_none_or(|best| cost < best.0) {
                best = Some((cost, overlap(&below.bounds, &above.bounds), axis, bin));
            }
        }
    }
    best.map(|(cost, overlap, axis, bin)| ObjectCut { cost, overlap, axis, place: Place::Bin(bin, binning) })
}
