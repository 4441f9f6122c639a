//! Top-down construction by the surface area heuristic, on a few planes per axis.
//!
//! The centres of the references are sorted into equal bins along each axis; cuts are tried between bins. Building costs a few passes over the
//! references per level, and the trees are nearly as good as those of a full sweep.
//!
//! Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies".

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

const BINS: usize = 16;

struct Binned {
    node_cost: f32,
}

impl Chooser for Binned {
    fn choose(&self, references: &mut [Reference], bounds: &Aabb, threads: &Threads) -> Cut {
        let centers = |piece: &[Reference]| {
            Aabb::from_points(piece.iter().map(|reference| [0, 1, 2].map(|axis| reference.center(axis))))
        };
        let binning = Binning::over(&threads.reduce(references, GRAIN, &centers, &|a, b| a.union(&b)));
        let fill = |piece: &[Reference]| {
            let mut bins = Bins::default();
            piece.iter().for_each(|reference| bins.add(&binning, reference));
            bins
        };
        let bins = threads.reduce(references, GRAIN, &fill, &Bins::merged);
        let Some(best) = (0..3).filter_map(|axis| bins.best_plane(axis)).min_by(|a, b| a.cost.total_cmp(&b.cost))
        else {
            return Cut::Leaf;
        };
        let area = bounds.half_area();
        let as_leaf = area * references.len() as f32;
        if best.cost + self.node_cost * area >= as_leaf {
            return Cut::Leaf;
        }
        let left = partition(references, |reference| binning.bin(reference, best.axis) < best.bin);
        Cut::Object { left }
    }
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

    #[inline]
    fn bin(&self, reference: &Reference, axis: usize) -> usize {
        let place = (reference.center(axis) - self.start[axis]) * self.scale[axis];
        (place as usize).min(BINS - 1)
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: u32,
}

#[derive(Clone)]
struct Bins([[Bin; BINS]; 3]);

impl Default for Bins {
    fn default() -> Self {
        Self([[Bin { bounds: Aabb::EMPTY, count: 0 }; BINS]; 3])
    }
}

/// Bins below `bin` on one side, the others on the other.
struct Plane {
    axis: usize,
    bin: usize,
    /// Primitive tests of both sides, each times its area.
    cost: f32,
}

impl Bins {
    #[inline]
    fn add(&mut self, binning: &Binning, reference: &Reference) {
        for axis in 0..3 {
            let bin = &mut self.0[axis][binning.bin(reference, axis)];
            bin.bounds = bin.bounds.union(&reference.bounds);
            bin.count += 1;
        }
    }

    fn merged(mut self, other: Self) -> Self {
        for (bin, more) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            bin.bounds = bin.bounds.union(&more.bounds);
            bin.count += more.count;
        }
        self
    }

    /// The cheapest plane of an axis, if one divides the references.
    fn best_plane(&self, axis: usize) -> Option<Plane> {
        let bins = &self.0[axis];
        let total: u32 = bins.iter().map(|bin| bin.count).sum();
        // From above: what each plane leaves on its upper side.
        let mut above = [0.0; BINS];
        let mut side = Bin { bounds: Aabb::EMPTY, count: 0 };
        for bin in (1..BINS).rev() {
            side = Bin { bounds: side.bounds.union(&bins[bin].bounds), count: side.count + bins[bin].count };
            above[bin] = side.bounds.half_area() * side.count as f32;
        }
        let mut best: Option<Plane> = None;
        let mut side = Bin { bounds: Aabb::EMPTY, count: 0 };
        for bin in 1..BINS {
            side = Bin { bounds: side.bounds.union(&bins[bin - 1].bounds), count: side.count + bins[bin - 1].count };
            let cost = side.bounds.half_area() * side.count as f32 + above[bin];
            let divides = side.count > 0 && side.count < total;
            if divides && cost.is_finite() && best.as_ref().is_none_or(|best| cost < best.cost) {
                best = Some(Plane { axis, bin, cost });
            }
        }
        best
    }
}

/// Brings what belongs to the left to the front, and says how many that are.
fn partition(references: &mut [Reference], is_left: impl Fn(&Reference) -> bool) -> usize {
    let mut left = 0;
    for i in 0..references.len() {
        if is_left(&references[i]) {
            references.swap(i, left);
            left += 1;
        }
    }
    left
}
