//! Cutting a set of references with a plane.

use glam::{BVec3A, Vec3A};

use super::clipper::TriangleClipper;
use super::cost::tests;
use super::planes::{Plane, halves};
use crate::build::cut::Side;
use crate::build::fast_box::FastBox;
use crate::build::reference::Reference;
use crate::geometry::Aabb;
use crate::threads::Threads;

/// Fewer references than this are cut by one thread: cutting one takes a few hundred nanoseconds.
const CUT_GRAIN: usize = 512;

/// Cuts the first `count` references with a plane, if that costs less than `to_beat`: what is below comes to the front, what is above stands behind. No more
/// references are made than there is room for behind them. A reference for which standing on both sides would cost more than standing whole on one of
/// them is not cut ("unsplitting"). If nothing comes of it, the references are what they were, in another order.
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
    let room = references.len() - count;
    let sorted = Sorted::by(plane, &mut references[..count]);
    let crossed = sorted.below.count..sorted.below.count + sorted.crossed;
    if plane.is_guess && sorted.cost(&references[crossed.clone()], plane, room, clipper, threads)? >= to_beat {
        return None;
    }
    let mut straddlers: Vec<Straddler> = references[crossed.clone()].iter().map(Straddler::of).collect();
    threads.for_each(&mut straddlers, CUT_GRAIN, &|_, one| {
        one.sides = clipper.sides(&one.whole, plane.axis, plane.position);
    });
    unsplit(&mut straddlers, &sorted, room);
    let mut sides = [sorted.below, sorted.above];
    for straddler in &straddlers {
        for (side, piece) in sides.iter_mut().zip(&straddler.sides) {
            side.add(piece);
        }
    }
    if sides.iter().any(|side| side.count == 0) {
        return None;
    }
    // Where the straddlers stood there is place for the left pieces, then for right ones; further right ones go behind all.
    let pieces = |side: usize| {
        let stands = move |one: &Straddler| !one.sides[side].is_empty();
        straddlers.iter().filter(move |one| stands(one)).map(move |one| Reference::new(one.sides[side], one.whole.id))
    };
    let places = crossed.chain(count..count + room);
    for (place, piece) in places.zip(pieces(0).chain(pieces(1))) {
        references[place] = piece;
    }
    Some(sides.map(|side| Side { count: side.count, bounds: side.bounds.into() }))
}

/// What stands on a side of a plane.
#[derive(Clone, Copy)]
struct Half {
    count: usize,
    bounds: FastBox,
}

impl Half {
    fn cost(&self) -> f32 {
        self.bounds.half_area() * tests(self.count as u32)
    }

    /// One more, if it is not empty.
    fn add(&mut self, bounds: &Aabb) {
        if !bounds.is_empty() {
            *self = Self { count: self.count + 1, bounds: self.bounds.union(&bounds.into()) };
        }
    }

    /// One of the references that are counted comes whole.
    fn with(&self, whole: &Aabb) -> Self {
        Self { bounds: self.bounds.union(&whole.into()), ..*self }
    }

    fn without_one(&self) -> Self {
        Self { count: self.count.saturating_sub(1), ..*self }
    }
}

/// References in the order: below the plane, crossed by it, above it.
struct Sorted {
    below: Half,
    crossed: usize,
    above: Half,
}

impl Sorted {
    fn by(plane: &Plane, references: &mut [Reference]) -> Self {
        let Plane { axis, position, .. } = *plane;
        let (below, around_below, _) = partition(references, |one| one.bounds.max[axis] <= position);
        let rest = &mut references[below..];
        let (crossed, _, around_above) = partition(rest, |one| one.bounds.min[axis] < position);
        let above = rest.len() - crossed;
        Self {
            below: Half { count: below, bounds: around_below },
            crossed,
            above: Half { count: above, bounds: around_above },
        }
    }

    /// What it costs to cut all that are crossed; nothing if there is not enough room for that, or if nothing would be divided.
    fn cost(
        &self,
        crossed: &[Reference],
        plane: &Plane,
        room: usize,
        clipper: &TriangleClipper<'_>,
        threads: &Threads,
    ) -> Option<f32> {
        let around = |piece: &[Reference]| {
            let mut sides = [FastBox::EMPTY; 2];
            for one in piece {
                let bounds = FastBox::of(one);
                let halves = halves(plane.position, plane.axis, &clipper.triangles().get(one.id));
                for (side, half) in sides.iter_mut().zip(halves.unwrap_or([bounds; 2])) {
                    *side = side.union(&half.intersection(&bounds));
                }
            }
            sides
        };
        let both = |a: [FastBox; 2], b: [FastBox; 2]| [a[0].union(&b[0]), a[1].union(&b[1])];
        let pieces = threads.reduce(crossed, CUT_GRAIN, &around, &both);
        let side = |half: &Half, pieces: &FastBox| Half {
            count: half.count + crossed.len(),
            bounds: half.bounds.union(pieces),
        };
        let (below, above) = (side(&self.below, &pieces[0]), side(&self.above, &pieces[1]));
        let cost = below.cost() + above.cost();
        (crossed.len() <= room && below.count > 0 && above.count > 0 && cost.is_finite()).then_some(cost)
    }
}

/// Brings those that are to stand first to the front, without a branch that could be guessed wrongly; says how many they are, and what boxes are around them and
/// around the others.
#[inline(always)]
fn partition(references: &mut [Reference], is_first: impl Fn(&Reference) -> bool) -> (usize, FastBox, FastBox) {
    let (mut first, mut around, mut around_others) = (0, FastBox::EMPTY, FastBox::EMPTY);
    for i in 0..references.len() {
        let is = is_first(&references[i]);
        let (bounds, mask) = (FastBox::of(&references[i]), BVec3A::splat(is));
        let masked = |mask: BVec3A| FastBox {
            min: Vec3A::select(mask, bounds.min, Vec3A::INFINITY),
            max: Vec3A::select(mask, bounds.max, Vec3A::NEG_INFINITY),
        };
        around = around.union(&masked(mask));
        around_others = around_others.union(&masked(!mask));
        references.swap(i, first);
        first += usize::from(is);
    }
    (first, around, around_others)
}

/// A reference on both sides of the plane.
struct Straddler {
    whole: Reference,
    /// What stands on either side; empty where nothing does.
    sides: [Aabb; 2],
}

impl Straddler {
    fn of(whole: &Reference) -> Self {
        Self { whole: *whole, sides: [Aabb::EMPTY; 2] }
    }
}

/// Decides for each whether it is cut or stands whole on one side.
fn unsplit(straddlers: &mut [Straddler], sorted: &Sorted, mut room: usize) {
    // What either side will hold, if all that have not been decided on are cut.
    let mut halves = [sorted.below, sorted.above];
    for one in &*straddlers {
        halves.iter_mut().zip(&one.sides).for_each(|(half, piece)| half.add(piece));
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
        if room > 0 && !is_empty[0] && both <= left_only && both <= right_only {
            room -= 1;
        } else if left_only <= right_only {
            halves = [below.with(&whole.bounds), above.without_one()];
            *sides = [whole.bounds, Aabb::EMPTY];
        } else {
            halves = [below.without_one(), above.with(&whole.bounds)];
            *sides = [Aabb::EMPTY, whole.bounds];
        }
    }
}
