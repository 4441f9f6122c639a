//! The walk through an eight-way tree, for a packet: the child that may be entered first comes first.

use super::super::choose::Entry;
use super::interval::Interval;
use super::planes::PacketPlanes;
use super::rays::{Column, RayPacket};
use crate::arena::Stack;
use crate::simd::Isa;
use crate::wide::{LANES, WIDE_STACK, WideLink, WideTree};

/// A question that a walk is compiled for.
pub(crate) trait PacketVisitor<I: Isa> {
    /// For each ray: boxes that are entered beyond this do not matter (any more). A ray that wants nothing has it before everything.
    fn t_max(&self) -> &Column;

    /// The units of a leaf that these rays enter. Tells whether any ray's `t_max` may have come nearer.
    fn leaf(&mut self, isa: I, link: WideLink, set: u64) -> bool;
}

/// Visits the leaves whose boxes are entered, each with the rays that do. The root's own box is not tested: its lanes are.
#[inline(always)]
pub(crate) fn walk_packet<I: Isa, V: PacketVisitor<I>>(
    isa: I,
    tree: &WideTree,
    rays: &RayPacket,
    planes: &PacketPlanes,
    interval: &Interval<I>,
    visitor: &mut V,
) {
    let nodes = tree.nodes();
    if nodes.is_empty() {
        return;
    }
    // What is set aside: a lane, counted through all nodes, with the distance where it may be entered first, and the rays. Its box is tested ray by ray when it is
    // taken up, with the hits that are known by then.
    let mut stack = Stack::<(Entry, u64), WIDE_STACK>::new();
    let (mut at, mut set) = (0, interval.set);
    let mut farthest = visitor.t_max().largest(isa, interval.set);
    loop {
        let (mask, entry) = interval.enter(isa, &nodes[at], isa.splat8(farthest));
        set_aside(&isa.store8(entry), mask, (at * LANES) as u32, set, &mut stack);
        (at, set) = loop {
            let Some((entry, all)) = stack.pop() else { return };
            if f32::from_bits((entry >> 32) as u32) > farthest {
                continue;
            }
            let (parent, lane) = (&nodes[entry as u32 as usize / LANES], entry as u32 as usize % LANES);
            let set = planes.enter(isa, (parent, lane), interval.sides, all, &rays.t_min, visitor.t_max());
            if set == 0 {
                continue;
            }
            let link = WideLink::from_bits(parent.links[lane]);
            if !link.is_leaf() {
                break (link.node_index(), set);
            }
            if visitor.leaf(isa, link, set) {
                farthest = visitor.t_max().largest(isa, interval.set);
            }
        };
    }
}

/// Puts the lanes of the mask on the stack, the nearest one last. Lane 0 has the number `first`.
#[inline(always)]
fn set_aside(distances: &[f32; LANES], mask: u8, first: u32, set: u64, stack: &mut Stack<(Entry, u64), WIDE_STACK>) {
    let mut sorted = [0; LANES];
    let (mut left, mut count) = (mask, 0);
    while left != 0 {
        let lane = left.trailing_zeros() & 7;
        left &= left - 1;
        let new = u64::from(distances[lane as usize].to_bits()) << 32 | u64::from(first + lane);
        let mut at = count;
        while at > 0 && sorted[(at - 1) & 7] < new {
            sorted[at & 7] = sorted[(at - 1) & 7];
            at -= 1;
        }
        sorted[at & 7] = new;
        count += 1;
    }
    for at in 0..count {
        stack.push((sorted[at & 7], set));
    }
}
