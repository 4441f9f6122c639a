//! Clusters and the pairs that they merge into.

use crate::geometry::Aabb;

const LEAF: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 27;
const INDEX_MASK: u32 = (1 << COUNT_SHIFT) - 1;

/// The largest number of primitives: their indices must fit beside a count in a link.
pub(super) const MAX_PRIMITIVES: usize = 1 << COUNT_SHIFT;

/// A cluster: its box and its contents.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cluster {
    pub(super) bounds: Aabb,
    pub(super) kind: Kind,
}

/// The contents of a cluster.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Kind {
    /// The index of a pair; or, for a leaf, the index of its first primitive and their number.
    pub(super) link: u32,
    pub(super) primitives: u32,
    pub(super) leaves: u32,
    /// The number of nodes on the longest path; 1 for a leaf.
    pub(super) height: u32,
}

/// The two children of a merged cluster, in one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Pair {
    pub(super) bounds: [Aabb; 2],
    pub(super) links: [u32; 2],
    pub(super) heights: [u32; 2],
}

const _: () = assert!(size_of::<Pair>() == 64);

/// An unpacked link of a pair.
pub(super) enum Half {
    Pair(usize),
    Leaf { index: usize, count: usize },
}

pub(super) fn half(link: u32) -> Half {
    if link & LEAF == 0 {
        Half::Pair(link as usize)
    } else {
        Half::Leaf { index: (link & INDEX_MASK) as usize, count: (link >> COUNT_SHIFT & 15) as usize }
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
    pub(super) fn single(index: usize) -> Self {
        Self::leaf(index, 1)
    }

    /// A leaf whose first primitive is at this index of the chunk.
    #[inline(always)]
    pub(super) fn leaf(index: usize, count: usize) -> Self {
        let primitives = count as u32;
        Self { link: LEAF | primitives << COUNT_SHIFT | index as u32, primitives, leaves: 1, height: 1 }
    }

    /// Joins two leaves: the last primitive of this one is linked to the first of the other. An
    /// entry of `chains` holds the primitive in its lower half and the index of the next entry in
    /// its upper half.
    #[inline(always)]
    pub(super) fn chained(&self, other: &Self, chains: &mut [u64]) -> Self {
        let mut last = (self.link & INDEX_MASK) as usize;
        for _ in 1..self.primitives {
            last = (chains[last] >> 32) as usize;
        }
        chains[last] |= u64::from(other.link & INDEX_MASK) << 32;
        let primitives = self.primitives + other.primitives;
        Self { link: LEAF | primitives << COUNT_SHIFT | self.link & INDEX_MASK, primitives, leaves: 1, height: 1 }
    }
}
