//! The number of references per triangle, and pre-splitting of the triangles that waste most area.
//!
//! Splitting a diagonal triangle into k equal slabs along its longest edge reduces the total area
//! of its boxes to about a k-th. So the summed area is smallest if the number of slabs is
//! proportional to the square root of the area that a reference wastes.

use super::clipper::TriangleClipper;
use crate::build::reference::{GRAIN, Reference};
use crate::geometry::{Aabb, Triangles};
use crate::threads::Threads;
use crate::tree::Node;

/// The usual number of references per triangle, and the largest, for scenes of long diagonal
/// triangles.
const USUAL_FACTOR: f64 = 1.3;
const MAX_FACTOR: f64 = 6.0;

/// Waste is the summed half area of the boxes over the area of the triangles; it is 2 for triangles
/// in axis-aligned planes. Up to the first value the usual number of references suffices; from the
/// second on the largest is used.
const LITTLE_WASTE: f64 = 4.0;
const MUCH_WASTE: f64 = 20.0;

/// The most memory for references beyond one per triangle during a build, in bytes; each needs two
/// nodes as well.
const MAX_BYTES: usize = 2 << 30;
const BYTES_EACH: usize = size_of::<Reference>() + 2 * size_of::<Node>();

/// From this need on, a part of the additional references is spent on pre-splitting; this fraction
/// of them at the greatest need. Measured on 200,000 random long diagonals: without pre-splitting,
/// rays visit four times as many nodes, and with twice the fraction a fifth more. With less waste,
/// pre-splitting does harm.
const PRE_SPLIT_NEED: f64 = 0.6;
const PRE_SPLIT_FRACTION: f64 = 0.3;

/// The largest number of slabs per triangle in pre-splitting.
const MAX_SLABS: f64 = 64.0;

pub(super) struct Budget {
    /// Additional references, beyond one per triangle.
    additional: usize,
    /// The part of these for pre-splitting.
    pre_splits: usize,
}

impl Budget {
    /// The number of additional references in scenes of little waste.
    pub(super) fn usual(triangles: usize) -> usize {
        (triangles as f64 * (USUAL_FACTOR - 1.0)) as usize
    }

    pub(super) fn of(references: &[Reference], triangles: &Triangles, threads: &Threads) -> Self {
        let areas = |slice: &[Reference]| {
            slice.iter().fold([0.0; 2], |[boxes, surfaces], reference| {
                let surface = f64::from(triangles.get(reference.id).area());
                [boxes + f64::from(reference.bounds.half_area()), surfaces + surface]
            })
        };
        let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let [boxes, surfaces] = threads.reduce(references, GRAIN, &areas, &sum);
        let waste = boxes / surfaces;
        // All triangles are degenerate: the ratio is meaningless.
        let need = if waste.is_finite() {
            ((waste - LITTLE_WASTE) / (MUCH_WASTE - LITTLE_WASTE)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let factor = USUAL_FACTOR + (MAX_FACTOR - USUAL_FACTOR) * need;
        let additional = ((references.len() as f64 * (factor - 1.0)) as usize).min(MAX_BYTES / BYTES_EACH);
        let pre_split = ((need - PRE_SPLIT_NEED) / (1.0 - PRE_SPLIT_NEED)).max(0.0);
        Self { additional, pre_splits: (additional as f64 * PRE_SPLIT_FRACTION * pre_split) as usize }
    }

    /// Pre-splits the references, and returns them with the number that may still be added.
    pub(super) fn pre_split(
        &self,
        references: Vec<Reference>,
        clipper: &TriangleClipper<'_>,
        triangles: &Triangles,
        threads: &Threads,
    ) -> (Vec<Reference>, usize) {
        let count = references.len();
        if self.pre_splits == 0 {
            return (references, self.additional);
        }
        let mut weights = vec![0.0_f64; count];
        threads.for_each(&mut weights, GRAIN, &|i, weight| {
            let reference = &references[i];
            let needed = 2.0 * f64::from(triangles.get(reference.id).area());
            let wasted = f64::from(reference.bounds.half_area()) - needed;
            *weight = if wasted.is_finite() { wasted.max(0.0).sqrt() } else { 0.0 };
        });
        let scale = self.scale_of(&weights, threads);
        let slab_count = |weight: f64| (weight * scale).clamp(1.0, MAX_SLABS) as u32;
        let mut slabs: Vec<(Reference, u32, u32)> = references
            .iter()
            .zip(&weights)
            .flat_map(|(&reference, &weight)| {
                let count = slab_count(weight);
                (0..count).map(move |slab| (reference, slab, count))
            })
            .collect();
        threads.for_each(&mut slabs, GRAIN / 16, &|_, (reference, slab, count)| {
            if *count > 1 {
                reference.bounds = slab_of(reference, *slab, *count, clipper);
            }
        });
        slabs.retain(|(reference, ..)| !reference.bounds.is_empty());
        let cut: Vec<Reference> = slabs.into_iter().map(|(reference, ..)| reference).collect();
        let spare = (count + self.additional).saturating_sub(cut.len());
        (cut, spare)
    }

    /// The factor from weights to numbers of slabs at which all slabs together use up the budget.
    fn scale_of(&self, weights: &[f64], threads: &Threads) -> f64 {
        let total = threads.reduce(weights, GRAIN, &|slice| slice.iter().sum::<f64>(), &|a, b| a + b);
        let (mut low, mut high) = (0.0, (weights.len() + self.pre_splits) as f64 / total);
        if !high.is_finite() {
            return 0.0;
        }
        let additional = |scale: f64| {
            let more = |slice: &[f64]| -> u64 {
                slice.iter().map(|weight| (weight * scale).clamp(1.0, MAX_SLABS) as u64 - 1).sum()
            };
            threads.reduce(weights, GRAIN, &more, &|a, b| a + b)
        };
        // Rounding down leaves some unused, so the result is a little above the plain ratio.
        high *= 2.0;
        for _ in 0..24 {
            let middle = 0.5 * (low + high);
            if additional(middle) <= self.pre_splits as u64 {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }
}

/// The box of the part of a reference in one of `count` equal slabs along its longest edge.
fn slab_of(whole: &Reference, slab: u32, count: u32, clipper: &TriangleClipper<'_>) -> Aabb {
    let axis = whole.bounds.largest_axis();
    let (start, length) = (whole.bounds.min[axis], whole.bounds.extent()[axis]);
    // Adjacent slabs compute the same plane.
    let plane = |i: u32| start + length * (i as f32 / count as f32);
    let mut region = whole.bounds;
    if slab > 0 {
        region.min[axis] = plane(slab);
    }
    if slab + 1 < count {
        region.max[axis] = plane(slab + 1);
    }
    clipper.within(whole, &region)
}
