//! How a set of references is divided.

use super::reference::{Reference, bounds_of};
use crate::geometry::Aabb;
use crate::threads::Threads;

/// What a chooser decides.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Cut {
    /// Not at all.
    Leaf,
    /// In two. The left side is the first references, as now ordered; the right side follows. When a plane has cut some references in two, there are more than
    /// before.
    Sides([Side; 2]),
}

/// Some references, at least one.
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

/// Who decides.
pub(crate) trait Chooser: Sync {
    /// Divides at least two references, whose box is `bounds`; may put them into another order.
    fn choose(&self, references: &mut [Reference], bounds: &Aabb, threads: &Threads) -> Cut;

    /// The same for the first `count`, when there is room behind them: references may be cut in two as long as all fit.
    fn choose_with_room(&self, references: &mut [Reference], count: usize, bounds: &Aabb, threads: &Threads) -> Cut {
        self.choose(&mut references[..count], bounds, threads)
    }
}

/// Half of the references on each side of the middle, along the axis on which their centres are spread most. For sets that a
/// heuristic cannot divide, and for paths that have grown too long.
pub(crate) fn median(references: &mut [Reference]) -> Cut {
    let spread = Aabb::from_points(references.iter().map(|reference| [0, 1, 2].map(|axis| reference.center(axis))));
    let axis = spread.largest_axis();
    let left = references.len() / 2;
    references.select_nth_unstable_by(left, |a, b| a.center(axis).total_cmp(&b.center(axis)).then(a.id.cmp(&b.id)));
    let (left, right) = references.split_at(left);
    Cut::Sides([left, right].map(Side::of))
}
