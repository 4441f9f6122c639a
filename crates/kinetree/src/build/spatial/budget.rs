//! How many more references than triangles there may be, and cutting the worst of them beforehand.
//!
//! Cutting one box along its longest edge into k equal slabs leaves a diagonal triangle with about a k-th of its box area in all. So the summed area is least
//! when a reference gets pieces in proportion to the root of the area that it wastes.

use super::clipper::TriangleClipper;
use crate::build::reference::{GRAIN, Reference};
use crate::geometry::{Aabb, Triangles};
use crate::threads::Threads;
use crate::tree::Node;

/// The usual number of references per triangle, and the one for scenes of long diagonal triangles.
const USUAL: f64 = 1.3;
const MOST: f64 = 6.0;

/// With a waste up to the first the usual number suffices; from the second on the most are made. 2 is the waste of triangles that lie in axis-parallel planes.
const LITTLE_WASTE: f64 = 4.0;
const MUCH_WASTE: f64 = 20.0;

/// Bytes that references beyond one per triangle may take while the tree is built (each comes with room for two nodes).
const MOST_BYTES: usize = 2 << 30;
const BYTES_EACH: usize = size_of::<Reference>() + 2 * size_of::<Node>();

/// From this need on, some of the further references go to the worst beforehand; this share of them at the greatest need. On 200 000 random long diagonals no cut
/// further down makes up for it: without it, rays met four times as many nodes; twice the share met a fifth more. With less waste it does harm.
const NEED_OF_THE_WORST: f64 = 0.6;
const SHARE_FOR_THE_WORST: f64 = 0.3;

/// A reference is cut into this many pieces beforehand, at most.
const MOST_PIECES: f64 = 64.0;

pub(super) struct Budget {
    /// References beyond one per triangle.
    further: usize,
    /// Of these, for the worst ones beforehand.
    beforehand: usize,
}

impl Budget {
    /// How many further references there are where little is wasted.
    pub(super) fn usual(triangles: usize) -> usize {
        (triangles as f64 * (USUAL - 1.0)) as usize
    }

    pub(super) fn of(references: &[Reference], triangles: &Triangles, threads: &Threads) -> Self {
        let areas = |piece: &[Reference]| {
            piece.iter().fold([0.0; 2], |[boxes, surfaces], one| {
                let surface = f64::from(triangles.get(one.id).area());
                [boxes + f64::from(one.bounds.half_area()), surfaces + surface]
            })
        };
        let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let [boxes, surfaces] = threads.reduce(references, GRAIN, &areas, &sum);
        let waste = boxes / surfaces;
        // Nothing but lines and points: the boxes say nothing.
        let need = if waste.is_finite() {
            ((waste - LITTLE_WASTE) / (MUCH_WASTE - LITTLE_WASTE)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let factor = USUAL + (MOST - USUAL) * need;
        let further = ((references.len() as f64 * (factor - 1.0)) as usize).min(MOST_BYTES / BYTES_EACH);
        let of_the_worst = ((need - NEED_OF_THE_WORST) / (1.0 - NEED_OF_THE_WORST)).max(0.0);
        Self { further, beforehand: (further as f64 * SHARE_FOR_THE_WORST * of_the_worst) as usize }
    }

    /// Cuts the worst, and says for how many more references there is room.
    pub(super) fn pre_split(
        &self,
        references: Vec<Reference>,
        clipper: &TriangleClipper<'_>,
        triangles: &Triangles,
        threads: &Threads,
    ) -> (Vec<Reference>, usize) {
        let count = references.len();
        if self.beforehand == 0 {
            return (references, self.further);
        }
        let mut shares = vec![0.0_f64; count];
        threads.for_each(&mut shares, GRAIN, &|i, share| {
            let one = &references[i];
            let needed = 2.0 * f64::from(triangles.get(one.id).area());
            let wasted = f64::from(one.bounds.half_area()) - needed;
            *share = if wasted.is_finite() { wasted.max(0.0).sqrt() } else { 0.0 };
        });
        let scale = self.scale_of(&shares, threads);
        let pieces = |share: f64| (share * scale).clamp(1.0, MOST_PIECES) as u32;
        let mut slabs: Vec<(Reference, u32, u32)> = references
            .iter()
            .zip(&shares)
            .flat_map(|(&one, &share)| {
                let count = pieces(share);
                (0..count).map(move |slab| (one, slab, count))
            })
            .collect();
        threads.for_each(&mut slabs, GRAIN / 16, &|_, (one, slab, count)| {
            if *count > 1 {
                one.bounds = slab_of(one, *slab, *count, clipper);
            }
        });
        slabs.retain(|(one, ..)| !one.bounds.is_empty());
        let cut: Vec<Reference> = slabs.into_iter().map(|(one, ..)| one).collect();
        let room = (count + self.further).saturating_sub(cut.len());
        (cut, room)
    }

    /// Pieces for a share of one, so that the pieces of all use up what there is.
    fn scale_of(&self, shares: &[f64], threads: &Threads) -> f64 {
        let total = threads.reduce(shares, GRAIN, &|piece| piece.iter().sum::<f64>(), &|a, b| a + b);
        let (mut low, mut high) = (0.0, (shares.len() + self.beforehand) as f64 / total);
        if !high.is_finite() {
            return 0.0;
        }
        let further = |scale: f64| {
            let more = |piece: &[f64]| -> u64 {
                piece.iter().map(|share| (share * scale).clamp(1.0, MOST_PIECES) as u64 - 1).sum()
            };
            threads.reduce(shares, GRAIN, &more, &|a, b| a + b)
        };
        // Rounding down leaves some over: so the limit lies a little above the plain ratio.
        high *= 2.0;
        for _ in 0..24 {
            let middle = 0.5 * (low + high);
            if further(middle) <= self.beforehand as u64 {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }
}

/// The piece of a reference in one of `count` equal slabs along its longest edge.
fn slab_of(whole: &Reference, slab: u32, count: u32, clipper: &TriangleClipper<'_>) -> Aabb {
    let axis = whole.bounds.largest_axis();
    let (start, length) = (whole.bounds.min[axis], whole.bounds.extent()[axis]);
    // Neighbours compute the same plane.
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
