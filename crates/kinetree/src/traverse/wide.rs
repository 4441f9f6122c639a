//! The walk through an eight-way tree, for one ray: a step tests eight boxes. The nearest child is
//! visited first; in any-hit queries, the one whose subtree is expected to cost least.

use std::ops::ControlFlow;

use super::choose::{choose, choose_in_order, next};
use super::{Boxes, Tally};
use crate::geometry::AT_MOST;
use crate::memory::StackBuffer;
use crate::simd::Isa;
use crate::wide::{WideBvh, WideLink};

/// A query that a walk is compiled for.
pub(crate) trait WideVisitor<I: Isa, T: Tally> {
    /// Whether any hit will do: children are then visited in the order of their lanes.
    fn wants_any(&self) -> bool;

    /// Boxes that are entered beyond this do not matter (any more). Not negative.
    fn t_max(&self) -> f32;

    /// The items of a leaf. `Break` ends the walk.
    fn leaf(&mut self, isa: I, link: WideLink, tally: &mut T) -> ControlFlow<()>;
}

/// Visits the leaves whose boxes are entered. The root's own box is not tested: its lanes are.
#[inline(always)]
pub(crate) fn walk_wide<I: Isa, T: Tally, V: WideVisitor<I, T>>(
    isa: I,
    tree: &WideBvh,
    boxes: impl Boxes<I>,
    visitor: &mut V,
    tally: &mut T,
) {
    let Some(rows) = tree.rows() else { return };
    let mut room = StackBuffer::new();
    let mut stack = room.stack();
    let mut limit = isa.splat(after(visitor.t_max() * AT_MOST));
    let mut link = WideLink::node(0);
    loop {
        let node = rows.at(link.offset());
        tally.node();
        let (entry, exit) = boxes.enter(isa, node, limit);
        // The first is taken at once, the others wait.
        let first = if visitor.wants_any() {
            choose_in_order(isa, entry, exit, node.links(), &mut stack)
        } else {
            choose(isa, entry, exit, node.links(), &mut stack)
        };
        link = match first {
            Some(first) => first,
            None => match next(&mut stack, visitor.t_max() * AT_MOST) {
                Some(next) => next,
                None => return,
            },
        };
        while link.is_leaf() {
            tally.leaf();
            if visitor.leaf(isa, link, tally).is_break() {
                return;
            }
            let farthest = visitor.t_max() * AT_MOST;
            limit = isa.splat(after(farthest));
            match next(&mut stack, farthest) {
                Some(next) => link = next,
                None => return,
            }
        }
    }
}

/// What comes right after a distance that is not negative, by its bits; after infinity no number.
#[inline(always)]
fn after(t: f32) -> f32 {
    f32::from_bits(t.to_bits() + 1)
}
