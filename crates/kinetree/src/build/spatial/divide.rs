//! Dividing a set of references by a plane: spatial splits with unsplitting.

use glam::{BVec3A, Vec3A};

use super::clipper::TriangleClipper;
use super::planes::{Plane, halves};
use crate::build::cost::tests;
use crate::build::cut::Side;
use crate::build::fast_box::FastBox;
use crate::build::reference::Reference;
use crate::geometry::Aabb;
use crate::threads::Threads;

/// References per parallel task of clipping, which takes a few hundred nanoseconds per reference.
const CUT_GRAIN: usize = 512;

/// Divides the first `count` references by a plane, if that costs less than `to_beat`: those below
/// come first, those above follow. The slots after `count` are free and limit the number of
/// references. A reference is not split if it costs less as a whole on one side ("unsplitting",
/// Stich et al. 2009). If the result is `None`, the references are unchanged, but may be reordered.
pub(super) fn divide(
    references: &mut [Reference],
    count: usize,
    plane: &Plane,
    to_beat: f32,
    clipper: &TriangleClipper<'_>,
    threads: &Threads,
) -> Option<[Side; 2]> {
    if plane.cost >= to_beat {
        return None;
    }
    let spare = references.len() - count;
    let sorted = Sorted::by(plane, &mut references[..count]);
    let crossed = sorted.below.count..sorted.below.count + sorted.crossed;
    if plane.is_estimate && sorted.cost(&references[crossed.clone()], plane, spare, clipper, threads)? >= to_beat {
        return None;
    }
    let mut straddlers: Vec<Straddler> = references[crossed.clone()].iter().map(Straddler::of).collect();
    threads.for_each(&mut straddlers, CUT_GRAIN, &|_, straddler| {
        straddler.sides = clipper.sides(&straddler.whole, plane.axis, plane.position);
    });
    unsplit(&mut straddlers, &sorted, spare);
    let mut sides = [sorted.below, sorted.above];
    for straddler in &straddlers {
        for (side, part) in sides.iter_mut().zip(&straddler.sides) {
            side.add(part);
        }
    }
    if sides.iter().any(|side| side.count == 0) {
        return None;
    }
    // The left parts replace the straddlers, then the right parts; the remaining right parts go to
    // the end.
    let parts = |side: usize| {
        let is_present = move |straddler: &Straddler| !straddler.sides[side].is_empty();
        straddlers
            .iter()
            .filter(move |straddler| is_present(straddler))
            .map(move |straddler| Reference::new(straddler.sides[side], straddler.whole.id))
    };
    let slots = crossed.chain(count..count + spare);
    for (slot, part) in slots.zip(parts(0).chain(parts(1))) {
        references[slot] = part;
    }
    Some(sides.map(|side| Side { count: side.count, bounds: side.bounds.into() }))
}

/// The references on one side of a plane.
#[derive(Clone, Copy)]
struct Half {
    count: usize,
    bounds: FastBox,
}

impl Half {
    fn cost(&self) -> f32 {
        self.bounds.half_area() * tests(self.count as u32)
    }

    /// Adds a reference, if its box is not empty.
    fn add(&mut self, bounds: &Aabb) {
        if !bounds.is_empty() {
            *self = Self { count: self.count + 1, bounds: self.bounds.union(&bounds.into()) };
        }
    }

    /// With one of the counted references as a whole.
    fn with(&self, whole: &Aabb) -> Self {
        Self { bounds: self.bounds.union(&whole.into()), ..*self }
    }

    fn without_one(&self) -> Self {
        Self { count: self.count.saturating_sub(1), ..*self }
    }
}

/// References partitioned into those below the plane, crossed by it, and above it.
struct Sorted {
    below: Half,
    crossed: usize,
    above: Half,
}

impl Sorted {
    fn by(plane: &Plane, references: &mut [Reference]) -> Self {
        let Plane { axis, position, .. } = *plane;
        let (below, bounds_below, _) = partition(references, |reference| reference.bounds.max[axis] <= position);
        let rest = &mut references[below..];
        let (crossed, _, bounds_above) = partition(rest, |reference| reference.bounds.min[axis] < position);
        let above = rest.len() - crossed;
        Self {
            below: Half { count: below, bounds: bounds_below },
            crossed,
            above: Half { count: above, bounds: bounds_above },
        }
    }

    /// The cost of splitting all crossed references; `None` if there are not enough free slots, or
    /// if one side would be empty.
    fn cost(
        &self,
        crossed: &[Reference],
        plane: &Plane,
        spare: usize,
        clipper: &TriangleClipper<'_>,
        threads: &Threads,
    ) -> Option<f32> {
        let around = |slice: &[Reference]| {
            let mut sides = [FastBox::EMPTY; 2];
            for reference in slice {
                let bounds = FastBox::of(reference);
                let halves = halves(plane.position, plane.axis, &clipper.triangles().get(reference.id));
                for (side, half) in sides.iter_mut().zip(halves.unwrap_or([bounds; 2])) {
                    *side = side.union(&half.intersection(&bounds));
                }
            }
            sides
        };
        let both = |a: [FastBox; 2], b: [FastBox; 2]| [a[0].union(&b[0]), a[1].union(&b[1])];
        let parts = threads.reduce(crossed, CUT_GRAIN, &around, &both);
        let side =
            |half: &Half, parts: &FastBox| Half { count: half.count + crossed.len(), bounds: half.bounds.union(parts) };
        let (below, above) = (side(&self.below, &parts[0]), side(&self.above, &parts[1]));
        let cost = below.cost() + above.cost();
        (crossed.len() <= spare && below.count > 0 && above.count > 0 && cost.is_finite()).then_some(cost)
    }
}

/// Moves the references for which `is_first` holds to the front, without a branch that could be
/// mispredicted. Returns their number, their box, and the box of the others.
#[inline(always)]
fn partition(references: &mut [Reference], is_first: impl Fn(&Reference) -> bool) -> (usize, FastBox, FastBox) {
    let (mut first, mut around, mut bounds_of_others) = (0, FastBox::EMPTY, FastBox::EMPTY);
    for i in 0..references.len() {
        let is = is_first(&references[i]);
        let (bounds, mask) = (FastBox::of(&references[i]), BVec3A::splat(is));
        let masked = |mask: BVec3A| FastBox {
            min: Vec3A::select(mask, bounds.min, Vec3A::INFINITY),
            max: Vec3A::select(mask, bounds.max, Vec3A::NEG_INFINITY),
        };
        around = around.union(&masked(mask));
        bounds_of_others = bounds_of_others.union(&masked(!mask));
        references.swap(i, first);
        first += usize::from(is);
    }
    (first, around, bounds_of_others)
}

/// A reference that the plane crosses.
struct Straddler {
    whole: Reference,
    /// The boxes of its parts on both sides; empty where there is none.
    sides: [Aabb; 2],
}

impl Straddler {
    fn of(whole: &Reference) -> Self {
        Self { whole: *whole, sides: [Aabb::EMPTY; 2] }
    }
}

/// Chooses for each straddler whether it is split or goes to one side as a whole.
fn unsplit(straddlers: &mut [Straddler], sorted: &Sorted, mut spare: usize) {
    // Both sides, if all remaining straddlers are split.
    let mut halves = [sorted.below, sorted.above];
    for straddler in &*straddlers {
        halves.iter_mut().zip(&straddler.sides).for_each(|(half, part)| half.add(part));
    }
    for Straddler { whole, sides } in straddlers {
        let [below, above] = &halves;
        let is_empty = [sides[0].is_empty(), sides[1].is_empty()];
        if is_empty[0] != is_empty[1] {
            continue;
        }
        let both = below.cost() + above.cost();
        let left_only = below.with(&whole.bounds).cost() + above.without_one().cost();
        let right_only = below.without_one().cost() + above.with(&whole.bounds).cost();
        if spare > 0 && !is_empty[0] && both <= left_only && both <= right_only {
            spare -= 1;
        } else if left_only <= right_only {
            halves = [below.with(&whole.bounds), above.without_one()];
            *sides = [whole.bounds, Aabb::EMPTY];
        } else {
            halves = [below.without_one(), above.with(&whole.bounds)];
            *sides = [Aabb::EMPTY, whole.bounds];
        }
    }
}
