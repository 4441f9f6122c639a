//! The result of dividing a set of references, and the trait of the algorithms that choose it.

use super::reference::{Reference, bounds_of};
use crate::geometry::Aabb;
use crate::threads::Threads;

/// What a [`Chooser`] does with a set of references.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Cut {
    /// Makes a leaf.
    Leaf,
    /// Divides the set in two. The references have been reordered: the left side comes first, the
    /// right side follows. There are more of them than before if a plane has split some.
    Sides([Side; 2]),
}

/// One side of a divided set: at least one reference.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    pub(crate) count: usize,
    /// The box around them.
    pub(crate) bounds: Aabb,
}

impl Side {
    pub(crate) fn of(references: &[Reference]) -> Self {
        Self { count: references.len(), bounds: bounds_of(references, &Threads::one()) }
    }
}

/// Chooses how to divide a set of references; implemented by binned and spatial splitting.
pub(crate) trait Chooser: Sync {
    /// Divides at least two references, whose box is `bounds`. May reorder them.
    fn choose(&self, references: &mut [Reference], bounds: &Aabb, threads: &Threads) -> Cut;

    /// As [`Self::choose`], for the first `count` references. The slots after them are free:
    /// references may be split as long as all fit.
    fn choose_with_spare(&self, references: &mut [Reference], count: usize, bounds: &Aabb, threads: &Threads) -> Cut {
        self.choose(&mut references[..count], bounds, threads)
    }
}

/// Splits at the median, along the axis of the largest extent of the centres. For sets that a
/// heuristic cannot divide, and for paths that are too long.
pub(crate) fn median(references: &mut [Reference]) -> Cut {
    let spread = Aabb::from_points(references.iter().map(|reference| [0, 1, 2].map(|axis| reference.center(axis))));
    let axis = spread.largest_axis();
    let left = references.len() / 2;
    references.select_nth_unstable_by(left, |a, b| a.center(axis).total_cmp(&b.center(axis)).then(a.id.cmp(&b.id)));
    let (left, right) = references.split_at(left);
    Cut::Sides([left, right].map(Side::of))
}
