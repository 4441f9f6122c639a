//! Cutting a set of references with a plane.

use super::cost::tests;
use super::parts::Parts;
use crate::build::fast_box::FastBox;
use crate::build::reference::{Reference, bounds_of};
use crate::geometry::Aabb;
use crate::threads::Threads;

/// Fewer references than this are cut by one thread: cutting one takes a few hundred nanoseconds.
const CUT_GRAIN: usize = 512;

/// A reference on both sides of the plane.
#[derive(Clone, Copy)]
struct Straddler {
    whole: Reference,
    sides: [Aabb; 2],
}

/// What a side will hold, if all straddlers that have not been decided on are cut.
struct Side {
    bounds: FastBox,
    count: u32,
}

impl Side {
    fn cost(&self) -> f32 {
        self.bounds.half_area() * tests(self.count)
    }

    /// One of the references that are counted comes whole.
    fn with(&self, whole: &Aabb) -> Self {
        Self { bounds: self.bounds.union(&FastBox::from(whole)), count: self.count }
    }

    fn without_one(&self) -> Self {
        Self { bounds: self.bounds, count: self.count.saturating_sub(1) }
    }
}

/// Brings what is below the plane to the front and what is above it behind, and says how many each are. The first `count` references are cut; behind them
/// there is room for more, and no more are made. A reference for which standing on both sides would cost more than standing whole on one of them is
/// not cut ("unsplitting").
pub(super) fn divide(
    references: &mut [Reference],
    count: usize,
    (axis, position): (usize, f32),
    parts: &Parts<'_>,
    threads: &Threads,
) -> (usize, usize) {
    let (mut right, mut straddlers) = (Vec::new(), Vec::new());
    let mut left = 0;
    for i in 0..count {
        let whole = references[i];
        if whole.bounds.max[axis] <= position {
            references[left] = whole;
            left += 1;
        } else if whole.bounds.min[axis] >= position {
            right.push(whole);
        } else {
            straddlers.push(Straddler { whole, sides: [Aabb::EMPTY; 2] });
        }
    }
    threads.for_each(&mut straddlers, CUT_GRAIN, &|_, one| one.sides = parts.sides(&one.whole, axis, position));
    let pieces = |side: usize| straddlers.iter().fold(FastBox::EMPTY, |all, one| all.union(&(&one.sides[side]).into()));
    let side = |whole: &[Reference], side: usize| Side {
        bounds: FastBox::from(&bounds_of(whole, threads)).union(&pieces(side)),
        count: (whole.len() + straddlers.iter().filter(|one| !one.sides[side].is_empty()).count()) as u32,
    };
    let mut sides = [side(&references[..left], 0), side(&right, 1)];
    let mut room = references.len() - count;
    for Straddler { whole, sides: [below, above] } in straddlers {
        let (to_left, to_right) = match (below.is_empty(), above.is_empty()) {
            (false, true) => (Some(below), None),
            (true, false) => (None, Some(above)),
            _ => {
                let [here, there] = &sides;
                let both = here.cost() + there.cost();
                let left_only = here.with(&whole.bounds).cost() + there.without_one().cost();
                let right_only = here.without_one().cost() + there.with(&whole.bounds).cost();
                if room > 0 && !below.is_empty() && both <= left_only && both <= right_only {
                    room -= 1;
                    (Some(below), Some(above))
                } else if left_only <= right_only {
                    sides = [here.with(&whole.bounds), there.without_one()];
                    (Some(whole.bounds), None)
                } else {
                    sides = [here.without_one(), there.with(&whole.bounds)];
                    (None, Some(whole.bounds))
                }
            }
        };
        if let Some(bounds) = to_left {
            references[left] = Reference { bounds, ..whole };
            left += 1;
        }
        if let Some(bounds) = to_right {
            right.push(Reference { bounds, ..whole });
        }
    }
    references[left..left + right.len()].copy_from_slice(&right);
    (left, right.len())
}
