//! The walk through an eight-way tree, for a packet. The child that the packet may enter first is
//! visited first; in any-hit queries, the one whose subtree is expected to cost least.

use super::super::choose::{Entry, choose, choose_in_order};
use super::interval::Interval;
use super::planes::PacketPlanes;
use super::rays::{Column, RayPacket};
use crate::geometry::AT_MOST;
use crate::memory::StackBuffer;
use crate::simd::Isa;
use crate::tree::MAX_DEPTH;
use crate::wide::{LANES, WIDE_STACK, WideBvh, WideLink};

/// A query that a walk is compiled for.
pub(crate) trait PacketVisitor<I: Isa> {
    /// Whether any hit will do: children are then visited in the order of their lanes.
    fn wants_any(&self) -> bool;

    /// For each ray: boxes that are entered beyond this do not matter (any more). That of a ray
    /// that needs no more hits is minus infinity.
    fn t_max(&self) -> &Column;

    /// The items of a leaf that these rays enter. Tells whether any ray's `t_max` may have come
    /// nearer.
    fn leaf(&mut self, isa: I, link: WideLink, set: u64) -> bool;
}

/// How many nodes a path can have.
const PATH: usize = MAX_DEPTH + 1;

/// What [`choose`] knows the lanes of each node of a path by: eight times its place, plus the lane.
const LANES_OF: [[u32; LANES]; PATH] = {
    let mut all = [[0; LANES]; PATH];
    let mut at = 0;
    while at < PATH * LANES {
        all[at / LANES][at % LANES] = at as u32;
        at += 1;
    }
    all
};

/// Visits the leaves whose boxes are entered, each with the rays that do. The root's own box is not
/// tested: its lanes are.
#[inline(always)]
pub(crate) fn walk_packet<I: Isa, V: PacketVisitor<I>>(
    isa: I,
    tree: &WideBvh,
    rays: &RayPacket,
    planes: &PacketPlanes,
    interval: &Interval<I>,
    visitor: &mut V,
) {
    let nodes = tree.nodes();
    let mut farthest = visitor.t_max().largest(isa, interval.set) * AT_MOST;
    if nodes.is_empty() || farthest < 0.0 {
        return;
    }
    // The stack holds lanes of nodes on the path, with the distance where they may be entered
    // first. Their boxes are tested ray by ray when they are popped, with the hits that are known
    // by then. Promise 6 bounds the path.
    let mut room = StackBuffer::<Entry, WIDE_STACK>::new();
    let mut stack = room.stack();
    let mut path = [(0, 0); PATH];
    let (mut place, mut at, mut set) = (0, 0, interval.set);
    loop {
        let node = &nodes[at];
        path[place] = (at, set);
        let (entry, exit) = interval.enter(isa, node, farthest);
        let mut next = if visitor.wants_any() {
            choose_in_order(isa, entry, exit, &LANES_OF[place], &mut stack)
        } else {
            choose(isa, entry, exit, &LANES_OF[place], &mut stack)
        };
        (place, at, set) = loop {
            let lane = match next {
                Some(nearest) => nearest.bits() as usize,
                None => match stack.pop() {
                    Some(entry) if (entry >> 32) as u32 > farthest.to_bits() => continue,
                    Some(entry) => entry as u32 as usize,
                    None => return,
                },
            };
            next = None;
            let (parent, all) = path[lane / LANES % PATH];
            let (parent, place, lane) = (&nodes[parent], lane / LANES, lane % LANES);
            let link = WideLink::from_bits(parent.links[lane]);
            let set = planes.enter(isa, (parent, lane), interval.sides, all, &rays.t_min, visitor.t_max());
            if set == 0 {
                continue;
            }
            if !link.is_leaf() {
                break (place + 1, link.node_index(), set);
            }
            if visitor.leaf(isa, link, set) {
                farthest = visitor.t_max().largest(isa, interval.set) * AT_MOST;
                if farthest < 0.0 {
                    return;
                }
            }
        };
    }
}
