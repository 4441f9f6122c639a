//! The best plane for a spatial split.
//!
//! Space is divided into equal slabs along each axis. Each reference is clipped at all planes
//! between slabs in one pass: corners extend the box of the slab that contains them, and where an
//! edge crosses a plane it extends the boxes on both sides. Sweeps over the slabs then give the
//! boxes and counts of both sides for every plane.

use std::ops::Range;

use glam::Vec3A;

use super::clipper::TriangleClipper;
use crate::build::cost::tests;
use crate::build::fast_box::FastBox;
use crate::build::reference::Reference;
use crate::geometry::{Aabb, Triangle};

/// Slabs per axis.
const BINS: usize = 16;

/// Larger sets are sampled at a regular stride, with at least this many references: enough to find
/// the plane. The cost is then an estimate.
const MIN_SAMPLE: usize = 1024;

/// A plane and the cost of splitting there.
pub(super) struct Plane {
    /// The sum over both sides of the number of primitive tests times the half area.
    pub(super) cost: f32,
    /// Whether the cost is an estimate from a sample. Samples miss some of the few large
    /// references, so it tends to be too low.
    pub(super) is_estimate: bool,
    pub(super) axis: usize,
    pub(super) position: f32,
}

/// The plane of least cost that adds at most `spare` references.
pub(super) fn best_plane(
    references: &[Reference],
    bounds: &Aabb,
    spare: usize,
    clipper: &TriangleClipper<'_>,
) -> Option<Plane> {
    let slabs = Slabs::of(bounds);
    let stride = (references.len() / MIN_SAMPLE).max(1);
    let mut bins = Bins::default();
    references.iter().step_by(stride).for_each(|reference| bins.add(&slabs, reference, clipper));
    let sample_count = references.len().div_ceil(stride);
    let best = (0..3).filter(|&axis| slabs.scale[axis] > 0.0).filter_map(|axis| {
        let (cost, bin) = bins.axes[axis].best_plane(sample_count + spare / stride)?;
        Some(Plane { cost: cost * stride as f32, is_estimate: stride > 1, axis, position: slabs.plane(axis, bin) })
    });
    best.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Equal slabs of space along each axis.
struct Slabs {
    start: [f32; 3],
    width: [f32; 3],
    /// Slabs per metre; zero for an axis that is not divided.
    scale: [f32; 3],
}

impl Slabs {
    fn of(bounds: &Aabb) -> Self {
        let width = bounds.extent().map(|length| length / BINS as f32);
        let scale = width.map(|width| if width.is_normal() && width.recip().is_normal() { width.recip() } else { 0.0 });
        Self { start: bounds.min, width, scale }
    }

    #[inline(always)]
    fn bin(&self, axis: usize, x: f32) -> usize {
        (((x - self.start[axis]) * self.scale[axis]) as usize).min(BINS - 1)
    }

    /// The lower plane of a slab.
    #[inline(always)]
    fn plane(&self, axis: usize, bin: usize) -> f32 {
        self.start[axis] + self.width[axis] * bin as f32
    }
}

struct Bins {
    axes: [Axis; 3],
    /// Scratch space: the parts of the triangle that is being clipped.
    parts: [FastBox; BINS],
}

/// The slabs along an axis.
struct Axis {
    bounds: [FastBox; BINS],
    /// The number of references whose first part is in this slab.
    first: [u32; BINS],
    /// The number of references whose last part is in this slab.
    last: [u32; BINS],
}

impl Default for Bins {
    fn default() -> Self {
        let axis = || Axis { bounds: [FastBox::EMPTY; BINS], first: [0; BINS], last: [0; BINS] };
        Self { axes: [axis(), axis(), axis()], parts: [FastBox::EMPTY; BINS] }
    }
}

impl Bins {
    #[inline(always)]
    fn add(&mut self, slabs: &Slabs, reference: &Reference, clipper: &TriangleClipper<'_>) {
        let bounds = FastBox::of(reference);
        let triangle = clipper.triangles().get(reference.id);
        for axis in 0..3 {
            let first = slabs.bin(axis, reference.bounds.min[axis]);
            let last = slabs.bin(axis, reference.bounds.max[axis]);
            let bins = &mut self.axes[axis];
            if first == last {
                bins.add_whole(first, &bounds);
            } else if last == first + 1
                && let Some(halves) = halves(slabs.plane(axis, last), axis, &triangle)
            {
                bins.add_clipped(first, &halves, &bounds);
            } else {
                let parts = &mut self.parts;
                parts[first..=last].fill(FastBox::EMPTY);
                clip_to_slabs(&triangle, axis, slabs, first..last, parts);
                bins.add_clipped(first, &parts[first..=last], &bounds);
            }
        }
    }
}

/// Extends the boxes of the slabs next to `planes` by the parts of a triangle in them; each plane
/// is the upper one of its slab. Other boxes may be extended too.
fn clip_to_slabs(triangle: &Triangle, axis: usize, slabs: &Slabs, planes: Range<usize>, parts: &mut [FastBox; BINS]) {
    let corners = triangle.corners;
    for i in 0..3 {
        let (mut from, mut to) = (corners[i], corners[(i + 1) % 3]);
        if from[axis] > to[axis] {
            std::mem::swap(&mut from, &mut to);
        }
        let (begin, end) = (slabs.bin(axis, from[axis]), slabs.bin(axis, to[axis]));
        let (height, length) = (from[axis], to[axis] - from[axis]);
        let (from, to) = (Vec3A::from(from), Vec3A::from(to));
        parts[begin].extend(from);
        parts[end].extend(to);
        if begin < end {
            let step = (to - from) / length;
            for bin in begin.max(planes.start)..end.min(planes.end) {
                let crossing = from + step * (slabs.plane(axis, bin + 1) - height);
                parts[bin].extend(crossing);
                parts[bin + 1].extend(crossing);
            }
        }
    }
}

impl Axis {
    #[inline(always)]
    fn add_whole(&mut self, bin: usize, bounds: &FastBox) {
        self.bounds[bin] = self.bounds[bin].union(bounds);
        self.first[bin] += 1;
        self.last[bin] += 1;
    }

    /// Adds the parts of one reference, in slabs from `first` on, clipped by its box.
    #[inline(always)]
    fn add_clipped(&mut self, first: usize, parts: &[FastBox], bounds: &FastBox) {
        let last = first + parts.len() - 1;
        let (mut from, mut to) = (usize::MAX, 0);
        for (bin, part) in (first..).zip(parts) {
            let part = part.intersection(bounds);
            if !part.is_empty() {
                self.bounds[bin] = self.bounds[bin].union(&part);
                from = from.min(bin);
                to = bin;
            }
        }
        // Rounding may leave nothing of a thin triangle: then the whole box counts.
        if from == usize::MAX {
            (from, to) = (first, last);
            self.bounds[first] = self.bounds[first].union(bounds);
            self.bounds[last] = self.bounds[last].union(bounds);
        }
        self.first[from] += 1;
        self.last[to] += 1;
    }

    /// The cost of the best plane, and the slab above it.
    fn best_plane(&self, limit: usize) -> Option<(f32, usize)> {
        let mut above = [(0.0, 0); BINS];
        let (mut bounds, mut count) = (FastBox::EMPTY, 0);
        for bin in (1..BINS).rev() {
            bounds = bounds.union(&self.bounds[bin]);
            count += self.last[bin];
            above[bin] = (bounds.half_area() * tests(count), count);
        }
        let mut best: Option<(f32, usize)> = None;
        let (mut bounds, mut count) = (FastBox::EMPTY, 0);
        for bin in 1..BINS {
            bounds = bounds.union(&self.bounds[bin - 1]);
            count += self.first[bin - 1];
            let cost = bounds.half_area() * tests(count) + above[bin].0;
            let divides = count > 0 && above[bin].1 > 0 && (count + above[bin].1) as usize <= limit;
            if divides && cost.is_finite() && best.is_none_or(|best| cost < best.0) {
                best = Some((cost, bin));
            }
        }
        best
    }
}

/// The boxes of the parts of a triangle below and above a plane; `None` if all corners are on one
/// side. A corner in the plane counts as below.
#[inline(always)]
pub(super) fn halves(plane: f32, axis: usize, triangle: &Triangle) -> Option<[FastBox; 2]> {
    // The corner that is alone on its side, indexed by the set of corners below.
    const ALONE: [usize; 8] = [0, 0, 1, 2, 2, 1, 0, 0];
    let height = |corner: usize| triangle.corners[corner][axis];
    let is_below = |corner: usize| usize::from(height(corner) <= plane);
    let below = is_below(0) | is_below(1) << 1 | is_below(2) << 2;
    if below == 0 || below == 7 {
        return None;
    }
    let alone = ALONE[below];
    let tip = Vec3A::from(triangle.corners[alone]);
    let (mut tip_side, mut other_side) = (FastBox::EMPTY, FastBox::EMPTY);
    tip_side.extend(tip);
    for step in 1..3 {
        let other = Vec3A::from(triangle.corners[(alone + step) % 3]);
        let along = (plane - height(alone)) / (height((alone + step) % 3) - height(alone));
        let crossing = tip + (other - tip) * along;
        other_side.extend(other);
        tip_side.extend(crossing);
        other_side.extend(crossing);
    }
    Some(if below >> alone & 1 == 1 { [tip_side, other_side] } else { [other_side, tip_side] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_halves_end_at_the_plane_and_cover_the_triangle() {
        let corners = [[0.0, 0.0, 5.0], [4.0, 4.0, 5.0], [4.0, 0.0, 7.0]];
        for turn in 0..3 {
            let triangle = Triangle { corners: [0, 1, 2].map(|corner| corners[(corner + turn) % 3]) };
            let [below, above] = halves(1.0, 0, &triangle).expect("the plane lies between the corners");
            assert_eq!((below.min, below.max), (Vec3A::new(0.0, 0.0, 5.0), Vec3A::new(1.0, 1.0, 5.5)));
            assert_eq!((above.min, above.max), (Vec3A::new(1.0, 0.0, 5.0), Vec3A::new(4.0, 4.0, 7.0)));
            assert!(halves(4.0, 0, &triangle).is_none() && halves(-1.0, 0, &triangle).is_none());
        }
    }
}
