//! How long things take. No other file names the clock, and where there is none, durations are `None`.

use std::time::Duration;

/// A moment from which time is counted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock(#[cfg(not(target_family = "wasm"))] std::time::Instant);

impl Clock {
    pub(crate) fn start() -> Self {
        Self(
            #[cfg(not(target_family = "wasm"))]
            std::time::Instant::now(),
        )
    }

    pub(crate) fn elapsed(self) -> Option<Duration> {
        #[cfg(not(target_family = "wasm"))]
        return Some(self.0.elapsed());
        #[cfg(target_family = "wasm")]
        None
    }
}
