//! The walk through an eight-way tree, for one ray: eight boxes at a step, the nearest child first.

use std::mem::MaybeUninit;
use std::ops::ControlFlow;

use glam::Vec3A;

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

/// Where a ray enters and leaves the eight boxes of a node.
pub(crate) trait Boxes<I: Isa>: Copy {
    /// Entered where the first is at most the second, and only lanes in use count. The first is not negative.
    fn enter(&self, isa: I, node: &WideNode, t_max: I::F8) -> (I::F8, I::F8);

    /// Bit per axis: whether the ray runs down it.
    fn octant(&self) -> usize;
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
        let (near, far) = (&ray.near, &ray.far);
        Self {
            near_scale: splat(isa, near.scale),
            near_offset: splat(isa, near.offset),
            far_scale: splat(isa, far.scale),
            far_offset: splat(isa, far.offset),
            near_side: [usize::from(ray.downwards[0]), usize::from(ray.downwards[1]), usize::from(ray.downwards[2])],
            t_min: isa.splat8(ray.t_min),
        }
    }

    /// Where the ray meets the planes of an axis that it meets first.
    #[inline(always)]
    fn near(&self, isa: I, node: &WideNode, axis: usize) -> I::F8 {
        let planes = isa.load8(&node.planes[axis][self.near_side[axis] & 1]);
        isa.mul_sub8(planes, self.near_scale[axis], self.near_offset[axis])
    }

    /// Where the ray meets the opposite planes.
    #[inline(always)]
    fn far(&self, isa: I, node: &WideNode, axis: usize) -> I::F8 {
        let planes = isa.load8(&node.planes[axis][self.near_side[axis] & 1 ^ 1]);
        isa.mul_sub8(planes, self.far_scale[axis], self.far_offset[axis])
    }
}

// Closures and `map` do not always become part of the kernel, and are compiled without its instructions then; so axes are written out here.
#[inline(always)]
fn splat<I: Isa>(isa: I, x: Vec3A) -> [I::F8; 3] {
    [isa.splat8(x.x), isa.splat8(x.y), isa.splat8(x.z)]
}

impl<I: Isa> Boxes<I> for RayLanes<I> {
    #[inline(always)]
    fn enter(&self, isa: I, node: &WideNode, t_max: I::F8) -> (I::F8, I::F8) {
        // None is not a number, since the ray is tame; `t_min` is not negative, and an exit that is counts as none.
        let entry = isa.max_bits8(self.near(isa, node, 0), self.near(isa, node, 1));
        let entry = isa.max_bits8(entry, isa.max_bits8(self.near(isa, node, 2), self.t_min));
        let exit = isa.min_bits8(self.far(isa, node, 0), self.far(isa, node, 1));
        let exit = isa.min_bits8(exit, isa.min_bits8(self.far(isa, node, 2), t_max));
        (entry, exit)
    }

    #[inline(always)]
    fn octant(&self) -> usize {
        self.near_side[0] | self.near_side[1] << 1 | self.near_side[2] << 2
    }
}

/// The same in double precision, box by box, for the rare ray whose reciprocals overflow.
#[derive(Clone, Copy)]
pub(crate) struct Carefully<'a>(pub(crate) &'a SafeRay);

impl<I: Isa> Boxes<I> for Carefully<'_> {
    #[inline(always)]
    fn enter(&self, isa: I, node: &WideNode, t_max: I::F8) -> (I::F8, I::F8) {
        let (entry, exit) = self.0.enter_all(node, isa.store8(t_max)[0]);
        (isa.load8(&entry), isa.load8(&exit))
    }

    #[inline(always)]
    fn octant(&self) -> usize {
        0
    }
}

impl SafeRay {
    #[cold]
    fn enter_all(&self, node: &WideNode, t_max: f32) -> ([f32; 8], [f32; 8]) {
        let (mut entries, mut exits) = ([0.0; 8], [-1.0; 8]);
        for (lane, _) in node.lanes() {
            if let Some(entry) = self.enter(&node.bounds(lane), t_max) {
                (entries[lane], exits[lane]) = (entry, f32::INFINITY);
            }
        }
        (entries, exits)
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
    // Grows downwards, so that the nearest is the lowest. Not zeroed: that would be a call, and longer than the walk of many a ray.
    let mut stack = [MaybeUninit::<u64>::uninit(); WIDE_STACK];
    let mut top = WIDE_STACK;
    let mut t_max = isa.splat8(visitor.t_max());
    let mut link = WideLink::node(0);
    let octant = boxes.octant();
    loop {
        // SAFETY: links that are not leaves lead to nodes of the same tree (promises 1 and 5 of `WideTree`, whose fields only `wide` writes).
        let node = unsafe { nodes.get_unchecked(link.index()) };
        tally.node();
        let (entry, exit) = boxes.enter(isa, node, t_max);
        // SAFETY: each node on a path sets at most seven links aside, and no path is longer than promise 6 says, so there is room for eight more.
        let room = unsafe { &mut *stack.as_mut_ptr().add(top - 8).cast::<[MaybeUninit<u64>; 8]>() };
        let (count, nearest) = if V::ORDERED {
            isa.choose(entry, exit, node.in_use, &node.links, node.far_to_near(octant), room)
        } else {
            in_order(isa.le8(entry, exit) & node.in_use, &node.links, room)
        };
        if count != 0 {
            // The nearest is taken at once, the others wait.
            top -= count - 1;
            link = WideLink::from_bits(nearest);
        } else {
            match pop(&stack, &mut top, visitor.t_max()) {
                Some(next) => link = next,
                None => return,
            }
        }
        while link.is_leaf() {
            tally.leaf();
            if visitor.leaf(isa, link, tally).is_break() {
                return;
            }
            let nearest = visitor.t_max();
            t_max = isa.splat8(nearest);
            match pop(&stack, &mut top, nearest) {
                Some(next) => link = next,
                None => return,
            }
        }
    }
}

/// The nearest of what was set aside, unless it lies too far by now.
#[inline(always)]
fn pop(stack: &[MaybeUninit<u64>; WIDE_STACK], top: &mut usize, t_max: f32) -> Option<WideLink> {
    while *top < WIDE_STACK {
        // SAFETY: everything from `top` on has been written.
        let entry = unsafe { stack.get_unchecked(*top).assume_init() };
        *top += 1;
        if (entry >> 32) as u32 <= t_max.to_bits() {
            return Some(WideLink::from_bits(entry as u32));
        }
    }
    None
}

/// The lanes of the mask as they stand, in the last places of the room, without distances: they count as entered at once.
#[inline(always)]
fn in_order(mut mask: u8, links: &[u32; 8], room: &mut [MaybeUninit<u64>; 8]) -> (usize, u32) {
    let count = mask.count_ones() as usize;
    let first = links[mask.trailing_zeros() as usize & 7];
    for at in 1..count {
        mask &= mask.wrapping_sub(1);
        room[(8 - count + at) & 7].write(u64::from(links[mask.trailing_zeros() as usize & 7]));
    }
    (count, first)
}
