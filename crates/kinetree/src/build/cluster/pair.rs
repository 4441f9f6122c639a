//! What clusters are made of, while they are merged.

use crate::geometry::Aabb;

const LEAF: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 27;
const PLACE_MASK: u32 = (1 << COUNT_SHIFT) - 1;

/// The most primitives there can be, so that their places fit beside a count.
pub(super) const MAX_PRIMITIVES: usize = 1 << COUNT_SHIFT;

/// A box, and what is in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cluster {
    pub(super) bounds: Aabb,
    pub(super) kind: Kind,
}

/// What is in a cluster.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Kind {
    /// The number of a pair; or, of a leaf, the place of its first primitive, and how many follow.
    pub(super) link: u32,
    pub(super) primitives: u32,
    pub(super) leaves: u32,
    /// Nodes on the longest path; 1 for a leaf.
    pub(super) height: u32,
}

/// The two halves of a merged cluster, in a cache line.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Pair {
    pub(super) bounds: [Aabb; 2],
    pub(super) links: [u32; 2],
    pub(super) heights: [u32; 2],
}

const _: () = assert!(size_of::<Pair>() == 64);

/// What a link of a pair says.
pub(super) enum Half {
    Pair(usize),
    Leaf { place: usize, count: usize },
}

pub(super) fn half(link: u32) -> Half {
    if link & LEAF == 0 {
        Half::Pair(link as usize)
    } else {
        Half::Leaf { place: (link & PLACE_MASK) as usize, count: (link >> COUNT_SHIFT & 15) as usize }
    }
}

impl Pair {
    #[inline(always)]
    pub(super) fn of(pair: &[Cluster; 2]) -> Self {
        Self {
            bounds: [pair[0].bounds, pair[1].bounds],
            links: [pair[0].kind.link, pair[1].kind.link],
            heights: [pair[0].kind.height, pair[1].kind.height],
        }
    }
}

impl Kind {
    /// A leaf with one primitive.
    #[inline(always)]
    pub(super) fn single(place: usize) -> Self {
        Self::leaf(place, 1)
    }

    /// A leaf whose first primitive has this place.
    #[inline(always)]
    pub(super) fn leaf(place: usize, count: usize) -> Self {
        let primitives = count as u32;
        Self { link: LEAF | primitives << COUNT_SHIFT | place as u32, primitives, leaves: 1, height: 1 }
    }

    /// One leaf of two: a chain leads from the last primitive of this one to the first of the other. A link of a chain holds the primitive in its
    /// lower half, and the place of the next in its upper half.
    #[inline(always)]
    pub(super) fn chained(&self, other: &Self, chains: &mut [u64]) -> Self {
        let mut last = (self.link & PLACE_MASK) as usize;
        for _ in 1..self.primitives {
            last = (chains[last] >> 32) as usize;
        }
        chains[last] |= u64::from(other.link & PLACE_MASK) << 32;
        let primitives = self.primitives + other.primitives;
        Self { link: LEAF | primitives << COUNT_SHIFT | self.link & PLACE_MASK, primitives, leaves: 1, height: 1 }
    }
}
