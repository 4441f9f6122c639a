//! A bound on memory in proportion to the size of the file, so that a small file cannot exhaust it.
//!
//! The size of the file bounds what one accessor can hold, but many items may share one accessor,
//! an accessor may consist of zeros that are not stored, and every node that deforms a mesh has a
//! copy of it. All of these are counted here.

use std::cell::Cell;

use crate::error::{Item, Problem};

/// What may still be allocated.
pub(crate) struct Budget {
    /// Numbers: components of vectors, keys and indices.
    numbers: Cell<u64>,
}

impl Budget {
    /// Small files may share what they have as often as they like.
    const NUMBERS_AT_LEAST: u64 = 1 << 24;
    /// Files without many deformed copies of a mesh need less than two.
    const NUMBERS_PER_BYTE: u64 = 16;

    pub(crate) fn for_bytes(bytes: u64) -> Self {
        let numbers = bytes.saturating_mul(Self::NUMBERS_PER_BYTE).saturating_add(Self::NUMBERS_AT_LEAST);
        Self { numbers: Cell::new(numbers) }
    }

    pub(crate) fn spend_numbers(&self, count: u64, item: &Item) -> Result<(), Problem> {
        let left = self.numbers.get().checked_sub(count).ok_or_else(|| Problem::TooLarge(item.clone()))?;
        self.numbers.set(left);
        Ok(())
    }
}
