//! How a set of references is divided.

use super::reference::Reference;
use crate::geometry::Aabb;
use crate::threads::Threads;

/// What a chooser decides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Cut {
    /// Not at all.
    Leaf,
    /// The first `left` references, as now ordered, and the rest. Neither is empty.
    Object { left: usize },
    /// A plane has cut some references in two, so there are more now: the first `left`, and the `right` ones that follow. Neither is none.
    Spatial { left: usize, right: usize },
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
    Cut::Object { left }
}
