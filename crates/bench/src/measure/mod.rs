//! Clocks, memory counts, thread affinity, and statistics.

pub(crate) mod clock;
pub(crate) mod memory;
pub(crate) mod pin;
pub(crate) mod rounds;
pub(crate) mod statistics;
