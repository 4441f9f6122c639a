//! The walk through an eight-way tree, for a packet: the child that may be entered first comes first.

use std::mem::MaybeUninit;

use super::interval::Interval;
use super::planes::PacketPlanes;
use super::rays::{Column, RayPacket};
use crate::simd::Isa;
use crate::wide::{LANES, WIDE_STACK, WideLink, WideTree};

/// A question that a walk is compiled for.
pub(crate) trait PacketVisitor<I: Isa> {
    /// For each ray: boxes that are entered beyond this do not matter (any more). A ray that wants nothing has it before everything.
    fn t_max(&self) -> &Column;

    /// The units of a leaf that these rays enter.
    fn leaf(&mut self, isa: I, link: WideLink, set: u64);
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
    // What is set aside: in the upper half of an entry the bits of a distance, which order like the distance because it is not negative; in the lower half a
    // lane, counted through all nodes. Its box is tested ray by ray when it is taken up, with the hits that are known by then.
    let mut stack = [MaybeUninit::<u64>::uninit(); WIDE_STACK];
    let mut sets = [MaybeUninit::<u64>::uninit(); WIDE_STACK];
    let mut aside = 0;
    let (mut at, mut set) = (0, interval.set);
    let mut farthest = visitor.t_max().largest(isa, interval.set, f32::NEG_INFINITY);
    loop {
        // SAFETY: 0 is a node, and links that are not leaves lead to nodes of the same tree (promises 1 and 5 of `WideTree`, whose fields only `wide` writes).
        let node = unsafe { nodes.get_unchecked(at) };
        let (mask, entry) = interval.enter(isa, node, isa.splat8(farthest));
        // SAFETY: a node sets aside at most eight lanes and takes one of them up again, so a path of promise 6's length leaves room for eight more.
        let room = unsafe { &mut *stack.as_mut_ptr().add(aside).cast::<[u64; LANES]>() };
        let first = (at * LANES) as u32;
        let count = isa.push_sorted(entry, &[0, 1, 2, 3, 4, 5, 6, 7].map(|lane| first + lane), mask, room);
        for place in aside..aside + count {
            sets[place] = MaybeUninit::new(set);
        }
        aside += count;
        (at, set) = loop {
            if aside == 0 {
                return;
            }
            aside -= 1;
            // SAFETY: the first `aside` entries of both stacks were written, and there are no more than fit.
            let (entry, all) =
                unsafe { (stack.get_unchecked(aside).assume_init(), sets.get_unchecked(aside).assume_init()) };
            if f32::from_bits((entry >> 32) as u32) > farthest {
                continue;
            }
            let (parent, lane) = (entry as u32 as usize / LANES, entry as u32 as usize % LANES);
            // SAFETY: `parent` was visited before.
            let parent = unsafe { nodes.get_unchecked(parent) };
            let set = planes.enter(isa, (parent, lane), interval.sides, all, &rays.t_min, visitor.t_max());
            if set == 0 {
                continue;
            }
            let link = WideLink::from_bits(parent.links[lane]);
            if !link.is_leaf() {
                break (link.index(), set);
            }
            visitor.leaf(isa, link, set);
            farthest = visitor.t_max().largest(isa, interval.set, f32::NEG_INFINITY);
        };
    }
}
