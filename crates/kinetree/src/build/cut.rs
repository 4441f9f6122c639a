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
}

/// Who decides.
pub(crate) trait Chooser: Sync {
    /// Divides at least two references, whose box is `bounds`; may put them into another order.
    fn choose(&self, references: &mut [Reference], bounds: &Aabb, threads: &Threads) -> Cut;
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
