//! How much a file may ask for, so that a small file cannot fill the memory.
//!
//! The bytes that are there bound what one accessor can hold, but many items may share one accessor, an accessor may
//! consist of zeros that are nowhere, and every node that deforms a mesh has a copy of it. All of these are paid for here.

use std::cell::Cell;

use crate::error::{Item, Problem};

/// What is left to be asked for.
pub(crate) struct Budget {
    /// Numbers: components of vectors, keys and indices.
    numbers: Cell<u64>,
}

impl Budget {
    /// Enough for small files to be generous with what they have.
    const NUMBERS_AT_LEAST: u64 = 1 << 24;
    /// Files without a crowd of deformed copies stay below two.
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
