//! References from one element of a file to another.

use std::cmp::Ordering;
use std::marker::PhantomData;
use std::num::NonZeroU32;

use serde::de::{Deserialize, Deserializer, Error};

/// The index of a `T` in the file's array of them; it may lead nowhere.
pub(crate) struct Index<T> {
    /// One more than the index, so that an `Option` needs no room of its own.
    successor: NonZeroU32,
    of: PhantomData<fn() -> T>,
}

const _: () = assert!(size_of::<Option<Index<()>>>() == 4);

impl<T> Index<T> {
    pub(crate) fn value(self) -> usize {
        self.successor.get() as usize - 1
    }
}

impl<'de, T> Deserialize<'de> for Index<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let index = u32::deserialize(deserializer)?;
        let successor = index.checked_add(1).and_then(NonZeroU32::new);
        let successor = successor.ok_or_else(|| D::Error::custom(format!("the index {index} is too large")))?;
        Ok(Self { successor, of: PhantomData })
    }
}

// By hand, since derived ones would ask the same of `T`.

impl<T> Clone for Index<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Index<T> {}

impl<T> PartialEq for Index<T> {
    fn eq(&self, other: &Self) -> bool {
        self.successor == other.successor
    }
}

impl<T> Eq for Index<T> {}

impl<T> PartialOrd for Index<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> Ord for Index<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.successor.cmp(&other.successor)
    }
}
