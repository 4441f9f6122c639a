//! Nodes as traversal reads them: eight rows of eight numbers, at the offset that is stored in a
//! [`WideLink`](super::WideLink).
//!
//! Offsets are in units of eight bytes, so that the address of a node is base + 8 * offset, one x86
//! addressing mode.

use super::node::{LANES, LINKS, ROWS};

/// The nodes of a tree, as rows.
#[derive(Clone, Copy)]
pub(crate) struct NodeArray<'a> {
    rows: &'a [[f32; LANES]],
    /// The largest offset that is followed by all rows of a node.
    last: usize,
}

/// One node, as rows.
#[derive(Clone, Copy)]
pub(crate) struct NodeView<'a> {
    rows: &'a [[f32; LANES]],
    /// At most the `last` of the [`NodeArray`].
    offset: usize,
}

/// The size of a row, in units of offsets.
pub(super) const OFFSETS_PER_ROW: usize = size_of::<[f32; LANES]>() / 8;

impl<'a> NodeArray<'a> {
    /// `None` if there is no node.
    #[inline(always)]
    pub(crate) fn new(rows: &'a [[f32; LANES]]) -> Option<Self> {
        Some(Self { rows, last: rows.len().checked_sub(ROWS)? * OFFSETS_PER_ROW })
    }

    /// # Panics
    /// When the offset is not followed by a whole node.
    #[inline(always)]
    pub(crate) fn at(self, offset: u32) -> NodeView<'a> {
        let offset = offset as usize;
        assert!(offset <= self.last, "no node at offset {offset}");
        NodeView { rows: self.rows, offset }
    }
}

impl<'a> NodeView<'a> {
    /// # Panics
    /// When the index is not below eight.
    #[inline(always)]
    fn row(self, index: usize) -> &'a [f32; LANES] {
        assert!(index < ROWS, "one of eight rows");
        // The index is added first, because it is the same for all nodes.
        let row = self.rows.as_ptr().wrapping_add(index);
        // SAFETY: the offset is followed by eight rows, all within the slice, which lives for 'a;
        // and every offset is a multiple of eight bytes, so floats are aligned.
        unsafe { &*row.cast::<u64>().wrapping_add(self.offset).cast::<[f32; LANES]>() }
    }

    /// The planes of one side along an axis.
    #[inline(always)]
    pub(crate) fn planes(self, axis: usize, side: usize) -> &'a [f32; LANES] {
        self.row(2 * axis + side)
    }

    /// The links of all lanes; those of unused lanes are unspecified.
    #[inline(always)]
    pub(crate) fn links(self) -> &'a [u32; LANES] {
        bytemuck::cast_ref(self.row(LINKS))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_behind_their_offsets() {
        let numbers: Vec<[f32; 8]> =
            (0..24).map(|row| [0, 1, 2, 3, 4, 5, 6, 7].map(|i| (8 * row + i) as f32)).collect();
        assert!(NodeArray::new(&numbers[..7]).is_none());
        let rows = NodeArray::new(&numbers).unwrap();
        for offset in 0..=64 {
            let eight = rows.at(offset);
            for row in 0..8 {
                assert_eq!(eight.row(row)[0], (2 * offset as usize + 8 * row) as f32);
            }
        }
        assert!(std::panic::catch_unwind(|| rows.at(65)).is_err());
        assert!(std::panic::catch_unwind(|| rows.at(u32::MAX)).is_err());
        assert!(std::panic::catch_unwind(|| rows.at(0).row(8)).is_err());
    }
}
