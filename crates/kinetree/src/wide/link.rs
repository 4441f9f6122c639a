//! The link of a lane of a wide node.

use std::ops::Range;

use super::node::ROWS;
use super::node_view::OFFSETS_PER_ROW;

const LEAF: u32 = 1 << 31;
const INDEX_MASK: u32 = (1 << WideLink::COUNT_SHIFT) - 1;
const OFFSET_SHIFT: u32 = (OFFSETS_PER_ROW * ROWS).trailing_zeros();

/// The child of a lane, packed into 32 bits: a node, or a few contiguous items (triangle blocks or
/// instances).
///
/// Bit 31 is set for items. Then bits 28 to 30 hold their count minus one, and bits 0 to 27 the
/// index of the first. For a node, bits 0 to 30 hold its offset in units of eight bytes, which is
/// 32 times its index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(transparent)]
pub struct WideLink(u32);

const _: () = assert!(size_of::<WideLink>() == 4);

/// A [`WideLink`], unpacked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum WideTarget {
    /// A node, by index.
    Node(u32),
    /// Items: at least one, at most [`WideLink::MAX_ITEMS`].
    Items(Range<u32>),
}

impl WideLink {
    /// The largest number of items in a leaf.
    pub const MAX_ITEMS: u32 = 8;

    /// The largest index of an item.
    pub const MAX_ITEM: u32 = INDEX_MASK;

    /// The largest index of a node.
    pub const MAX_NODE: u32 = (LEAF - 1) >> OFFSET_SHIFT;

    /// The lowest of the three bits that hold the number of items minus one; the bits are zero in a
    /// link to a node.
    pub(crate) const COUNT_SHIFT: u32 = 28;

    /// A link to a node.
    ///
    /// # Panics
    /// When the index is above [`WideLink::MAX_NODE`].
    pub fn node(index: u32) -> Self {
        assert!(index <= Self::MAX_NODE, "node {index} does not fit in a link");
        Self(index << OFFSET_SHIFT)
    }

    /// A link to a range of items.
    ///
    /// # Panics
    /// When the range is empty or longer than [`WideLink::MAX_ITEMS`], or starts above
    /// [`WideLink::MAX_ITEM`].
    pub fn items(range: Range<u32>) -> Self {
        let count = range.end.saturating_sub(range.start);
        assert!((1..=Self::MAX_ITEMS).contains(&count), "a leaf of {count} items");
        assert!(range.start <= INDEX_MASK, "item {} does not fit in a link", range.start);
        Self(LEAF | (count - 1) << Self::COUNT_SHIFT | range.start)
    }

    /// The link with `nodes` added to the index of a node, or `items` to the index of an item.
    #[inline]
    pub(super) fn moved(self, nodes: u32, items: u32) -> Self {
        match self.target() {
            WideTarget::Node(node) => Self::node(node + nodes),
            WideTarget::Items(range) => Self::items(range.start + items..range.end + items),
        }
    }

    #[inline(always)]
    pub(crate) fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    #[inline(always)]
    pub(crate) fn bits(self) -> u32 {
        self.0
    }

    /// Whether the link is to items.
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & LEAF != 0
    }

    /// The index of the node, for a link to a node.
    #[inline(always)]
    pub(crate) fn node_index(self) -> usize {
        (self.0 >> OFFSET_SHIFT) as usize
    }

    /// The offset of the node, for a link to a node: see
    /// [`NodeArray`](super::node_view::NodeArray).
    #[inline(always)]
    pub(crate) fn offset(self) -> u32 {
        self.0
    }

    /// The index of the first item, for a link to items.
    #[inline(always)]
    pub(crate) fn item_index(self) -> usize {
        (self.0 & INDEX_MASK) as usize
    }

    /// The number of items, for a link to items.
    #[inline(always)]
    pub(crate) fn item_count(self) -> usize {
        (self.0 >> Self::COUNT_SHIFT & 7) as usize + 1
    }

    /// Unpacks the link.
    pub fn target(self) -> WideTarget {
        if self.is_leaf() {
            let first = self.item_index() as u32;
            WideTarget::Items(first..first + self.item_count() as u32)
        } else {
            WideTarget::Node(self.node_index() as u32)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_in_comes_out() {
        for index in [0, 1, 77, WideLink::MAX_NODE] {
            assert_eq!(WideLink::node(index).target(), WideTarget::Node(index));
        }
        for index in [0, 1, 77, WideLink::MAX_ITEM] {
            for count in 1..=WideLink::MAX_ITEMS {
                let items = index..index + count;
                assert_eq!(WideLink::items(items.clone()).target(), WideTarget::Items(items));
            }
        }
    }
}
