//! The link of a node: its children or its primitives.

use std::ops::Range;

const COUNT_BITS: u32 = 4;
const COUNT_MASK: u32 = (1 << COUNT_BITS) - 1;

/// The children or the primitives of a node, packed into 32 bits: the lowest four bits are the
/// number of primitives, zero for an inner node; the others are the index of the first child or
/// primitive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
pub struct Link(u32);

const _: () = assert!(size_of::<Link>() == 4);

/// A [`Link`], unpacked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// An inner node: the index of its first child. The second child is the next node.
    Node(u32),
    /// A leaf: a range of the tree's primitive list. At least one primitive, at most
    /// [`Link::MAX_COUNT`].
    Primitives(Range<u32>),
}

impl Link {
    /// The largest number of primitives in a leaf.
    pub const MAX_COUNT: u32 = COUNT_MASK;

    /// The largest index of a node or primitive.
    pub const MAX_INDEX: u32 = (1 << (32 - COUNT_BITS)) - 1;

    /// Marks nodes that a builder has not written yet. No node links to the root, so the value is
    /// free.
    pub(crate) const UNUSED: Self = Self(0);

    /// A link to two children, given the index of the first.
    ///
    /// # Panics
    /// When the index is above [`Link::MAX_INDEX`].
    pub fn node(first_child: u32) -> Self {
        assert!(first_child <= Self::MAX_INDEX, "node {first_child} does not fit in a link");
        Self(first_child << COUNT_BITS)
    }

    /// A link to a range of the primitive list.
    ///
    /// # Panics
    /// When the range is empty or longer than [`Link::MAX_COUNT`], or starts above
    /// [`Link::MAX_INDEX`].
    pub fn primitives(range: Range<u32>) -> Self {
        let count = range.end.saturating_sub(range.start);
        assert!((1..=Self::MAX_COUNT).contains(&count), "a leaf of {count} primitives");
        assert!(range.start <= Self::MAX_INDEX, "primitive {} does not fit in a link", range.start);
        Self(range.start << COUNT_BITS | count)
    }

    /// Unpacks the link.
    #[inline]
    pub fn target(self) -> Target {
        let (index, count) = (self.0 >> COUNT_BITS, self.0 & COUNT_MASK);
        if count == 0 { Target::Node(index) } else { Target::Primitives(index..index + count) }
    }

    /// Whether the node is a leaf.
    #[inline]
    pub fn is_leaf(self) -> bool {
        self.0 & COUNT_MASK != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_in_comes_out() {
        for index in [0, 1, 77, Link::MAX_INDEX] {
            assert_eq!(Link::node(index).target(), Target::Node(index));
            for count in 1..=Link::MAX_COUNT {
                assert_eq!(Link::primitives(index..index + count).target(), Target::Primitives(index..index + count));
            }
        }
    }
}
