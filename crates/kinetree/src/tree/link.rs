//! Where a node leads.

use std::ops::Range;

const COUNT_BITS: u32 = 4;
const COUNT_MASK: u32 = (1 << COUNT_BITS) - 1;

/// Where a node leads, packed into 32 bits: the count is zero for an inner node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
pub struct Link(u32);

const _: () = assert!(size_of::<Link>() == 4);

/// What a [`Link`] says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// An inner node: its first child. The second one is the next node.
    Node(u32),
    /// A leaf: places in the tree's list of primitives. At least one, at most [`Link::MAX_COUNT`].
    Primitives(Range<u32>),
}

impl Link {
    /// The most primitives that a leaf holds.
    pub const MAX_COUNT: u32 = COUNT_MASK;

    /// Nodes and primitives are numbered below this.
    pub const MAX_INDEX: u32 = (1 << (32 - COUNT_BITS)) - 1;

    /// Leads to the root, which no node does: builders mark nodes with it that are not in use.
    pub(crate) const UNUSED: Self = Self(0);

    /// To the first of two children.
    ///
    /// # Panics
    /// When the number is above [`Link::MAX_INDEX`].
    pub fn node(first_child: u32) -> Self {
        assert!(first_child <= Self::MAX_INDEX, "node {first_child} has no room in a link");
        Self(first_child << COUNT_BITS)
    }

    /// To primitives.
    ///
    /// # Panics
    /// When there is none, or more than [`Link::MAX_COUNT`], or the first is above [`Link::MAX_INDEX`].
    pub fn primitives(range: Range<u32>) -> Self {
        let count = range.end.saturating_sub(range.start);
        assert!((1..=Self::MAX_COUNT).contains(&count), "a leaf of {count} primitives");
        assert!(range.start <= Self::MAX_INDEX, "primitive {} has no room in a link", range.start);
        Self(range.start << COUNT_BITS | count)
    }

    /// What it leads to.
    #[inline]
    pub fn target(self) -> Target {
        let (index, count) = (self.0 >> COUNT_BITS, self.0 & COUNT_MASK);
        if count == 0 { Target::Node(index) } else { Target::Primitives(index..index + count) }
    }

    /// Whether it leads to primitives.
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
