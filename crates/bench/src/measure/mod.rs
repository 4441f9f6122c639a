//! Clocks, counts of memory, and what is made of many measurements.

pub(crate) mod clock;
pub(crate) mod memory;
pub(crate) mod pin;
pub(crate) mod rounds;
pub(crate) mod statistics;
