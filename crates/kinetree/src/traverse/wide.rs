//! The walk through an eight-way tree, for one ray: eight boxes at a step, the nearest child first.

use std::mem::MaybeUninit;
use std::ops::ControlFlow;

use super::Tally;
use crate::geometry::SafeRay;
use crate::simd::Isa;
use crate::wide::{WIDE_STACK, WideLink, WideNode, WideTree};

/// A question that a walk is compiled for.
pub(crate) trait WideVisitor<I: Isa, T: Tally> {
    /// Whether nearer children have to come first. A question that ends at any hit does not care.
    const ORDERED: bool;

    /// Boxes that are entered beyond this do not matter (any more). Not negative.
    fn t_max(&self) -> f32;

    /// The units of a leaf. `Break` ends the walk.
    fn leaf(&mut self, isa: I, link: WideLink, tally: &mut T) -> ControlFlow<()>;
}

/// Which of the eight boxes a ray enters, and where.
pub(crate) trait Boxes<I: Isa>: Copy {
    fn enter(&self, isa: I, node: &WideNode, t_max: I::F8) -> (u8, I::F8);
}

/// A ray in registers: one multiplication and subtraction per plane. See [`SafeRay`] for how it leans.
#[derive(Clone, Copy)]
pub(crate) struct RayLanes<I: Isa> {
    near_scale: [I::F8; 3],
    near_offset: [I::F8; 3],
    far_scale: [I::F8; 3],
    far_offset: [I::F8; 3],
    /// Which side of a node's planes is met first.
    near_side: [usize; 3],
    t_min: I::F8,
}

impl<I: Isa> RayLanes<I> {
    #[inline(always)]
    pub(crate) fn new(isa: I, ray: &SafeRay) -> Self {
        Self {
            near_scale: [0, 1, 2].map(|axis| isa.splat8(ray.near[axis].scale)),
            near_offset: [0, 1, 2].map(|axis| isa.splat8(ray.near[axis].offset)),
            far_scale: [0, 1, 2].map(|axis| isa.splat8(ray.far[axis].scale)),
            far_offset: [0, 1, 2].map(|axis| isa.splat8(ray.far[axis].offset)),
            near_side: [0, 1, 2].map(|axis| usize::from(ray.downwards[axis])),
            t_min: isa.splat8(ray.t_min),
        }
    }
}

impl<I: Isa> Boxes<I> for RayLanes<I> {
    #[inline(always)]
    fn enter(&self, isa: I, node: &WideNode, t_max: I::F8) -> (u8, I::F8) {
        let (mut entry, mut exit) = (self.t_min, t_max);
        for axis in 0..3 {
            let side = self.near_side[axis] & 1;
            let near = isa.load8(&node.planes[axis][side]);
            let far = isa.load8(&node.planes[axis][side ^ 1]);
            // New value first: on NaN, `max` and `min` keep the second.
            entry = isa.max8(isa.mul_sub8(near, self.near_scale[axis], self.near_offset[axis]), entry);
            exit = isa.min8(isa.mul_sub8(far, self.far_scale[axis], self.far_offset[axis]), exit);
        }
        (isa.le8(entry, exit) & node.in_use as u8, entry)
    }
}

/// The same in double precision, box by box, for the rare ray whose reciprocals overflow.
#[derive(Clone, Copy)]
pub(crate) struct Carefully<'a>(pub(crate) &'a SafeRay);

impl<I: Isa> Boxes<I> for Carefully<'_> {
    #[inline(always)]
    fn enter(&self, isa: I, node: &WideNode, t_max: I::F8) -> (u8, I::F8) {
        let (mask, entries) = self.0.enter_all(node, isa.store8(t_max)[0]);
        (mask, isa.load8(&entries))
    }
}

impl SafeRay {
    #[cold]
    fn enter_all(&self, node: &WideNode, t_max: f32) -> (u8, [f32; 8]) {
        let mut entries = [0.0; 8];
        let mut mask = 0;
        for (lane, _) in node.lanes() {
            if let Some(entry) = self.enter(&node.bounds(lane), t_max) {
                entries[lane] = entry;
                mask |= 1 << lane;
            }
        }
        (mask, entries)
    }
}

/// Visits the leaves whose boxes are entered. The root's own box is not tested: its lanes are.
#[inline(always)]
pub(crate) fn walk_wide<I: Isa, T: Tally, V: WideVisitor<I, T>>(
    isa: I,
    tree: &WideTree,
    boxes: impl Boxes<I>,
    visitor: &mut V,
    tally: &mut T,
) {
    let nodes = tree.nodes();
    if nodes.is_empty() {
        return;
    }
    // Not zeroed: that would be a call, and longer than the walk of many a ray.
    let mut stack = [MaybeUninit::<u64>::uninit(); WIDE_STACK];
    let mut aside = 0;
    let mut t_max = isa.splat8(visitor.t_max());
    let mut link = WideLink::node(0);
    loop {
        // SAFETY: links that are not leaves lead to nodes of the same tree (promises 1 and 5 of `WideTree`, whose fields only `wide` writes).
        let node = unsafe { nodes.get_unchecked(link.index()) };
        tally.node();
        let (mask, entry) = boxes.enter(isa, node, t_max);
        if mask & mask.wrapping_sub(1) == 0 {
            if mask != 0 {
                link = WideLink::from_bits(node.links[mask.trailing_zeros() as usize & 7]);
            } else {
                match pop(&stack, &mut aside, visitor.t_max()) {
                    Some(next) => link = next,
                    None => return,
                }
            }
        } else {
            // SAFETY: a node sets aside at most eight links and takes one of them up again, so a path of promise 6's length leaves room for eight more; the
            // first `aside` entries are written.
            let room = unsafe { &mut *stack.as_mut_ptr().add(aside).cast::<[u64; 8]>() };
            let count = if V::ORDERED {
                isa.push_sorted(entry, &node.links, mask, room)
            } else {
                push_in_order(&node.links, mask, room)
            };
            aside += count - 1;
            // SAFETY: the entry was written just now.
            link = WideLink::from_bits(unsafe { stack.get_unchecked(aside).assume_init() } as u32);
        }
        while link.is_leaf() {
            tally.leaf();
            if visitor.leaf(isa, link, tally).is_break() {
                return;
            }
            let nearest = visitor.t_max();
            t_max = isa.splat8(nearest);
            match pop(&stack, &mut aside, nearest) {
                Some(next) => link = next,
                None => return,
            }
        }
    }
}

/// The nearest of what was set aside, unless it lies too far by now.
#[inline(always)]
fn pop(stack: &[MaybeUninit<u64>; WIDE_STACK], aside: &mut usize, t_max: f32) -> Option<WideLink> {
    while *aside > 0 {
        *aside -= 1;
        // SAFETY: the first `aside` entries are written, and there are no more than fit.
        let entry = unsafe { stack.get_unchecked(*aside).assume_init() };
        if (entry >> 32) as u32 <= t_max.to_bits() {
            return Some(WideLink::from_bits(entry as u32));
        }
    }
    None
}

/// The lanes of the mask, the first one last, without distances: they count as entered at once.
#[inline(always)]
fn push_in_order(links: &[u32; 8], mut mask: u8, stack: &mut [u64; 8]) -> usize {
    let count = mask.count_ones() as usize;
    for at in (0..count).rev() {
        stack[at & 7] = u64::from(links[mask.trailing_zeros() as usize & 7]);
        mask &= mask.wrapping_sub(1);
    }
    count
}
