//! Following a long build from another thread, and calling it off.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use thiserror::Error;

/// Follows one build: how far it is, and whether it is still wanted. Clones share what they see; any thread may look and cancel.
///
/// A build that nobody watches pays nothing.
#[derive(Debug, Clone, Default)]
pub struct BuildProgress(Arc<State>);

/// The build was called off. Nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the build was cancelled")]
pub struct Cancelled;

/// A build is a row of stages. Each takes its share of what its predecessors have left, so it does not matter how many there are.
///
/// Shares are not negative, so their bits are ordered as they are, and the larger of two can be kept without a lock.
#[derive(Debug, Default)]
struct State {
    is_cancelled: AtomicBool,
    /// What is shown.
    share: AtomicU32,
    /// Of the stage at work: where it began and where it ends, in shares of all.
    start: AtomicU32,
    end: AtomicU32,
    /// Of the stage at work, in units of its own.
    done: AtomicU64,
    units: AtomicU64,
}

impl BuildProgress {
    /// For one build, which has not begun.
    pub fn new() -> Self {
        Self::default()
    }

    /// How much of the build is done, from 0 to 1: an estimate, by counts and not by time. Never falls, and is 1 only when all is done.
    pub fn progress(&self) -> f32 {
        f32::from_bits(self.0.share.load(Ordering::Relaxed))
    }

    /// Calls the build off. It ends soon, with [`Cancelled`], unless it has just ended by itself:
    /// each thread finishes what it has in hand, and progress hardly moves any more.
    pub fn cancel(&self) {
        self.0.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether it was called off.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.0.is_cancelled.load(Ordering::Relaxed)
    }

    /// Another stage begins, of so many units, when the last one has ended; it is taken to need
    /// `share` of what is left. Stages follow each other: whoever begins one is the only one at
    /// work. None begins once the build has been called off.
    pub(crate) fn begin_stage(&self, share: f32, units: usize) {
        if self.is_cancelled() {
            return;
        }
        let state = &*self.0;
        let start = f32::from_bits(state.end.load(Ordering::Relaxed));
        self.show(start);
        state.start.store(start.to_bits(), Ordering::Relaxed);
        state.end.store((start + (1.0 - start) * share).min(ALMOST_ALL).to_bits(), Ordering::Relaxed);
        state.done.store(0, Ordering::Relaxed);
        state.units.store(units.max(1) as u64, Ordering::Relaxed);
    }

    /// So many more units of the stage are done.
    pub(crate) fn advance(&self, units: usize) {
        let state = &*self.0;
        let done = state.done.fetch_add(units as u64, Ordering::Relaxed) + units as u64;
        let part = (done as f32 / state.units.load(Ordering::Relaxed) as f32).min(1.0);
        let [start, end] = [&state.start, &state.end].map(|bits| f32::from_bits(bits.load(Ordering::Relaxed)));
        self.show((start + (end - start) * part).min(end));
    }

    /// All is done.
    ///
    /// # Errors
    /// It was called off before.
    pub(crate) fn finish(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() {
            return Err(Cancelled);
        }
        self.show(1.0);
        Ok(())
    }

    fn show(&self, share: f32) {
        self.0.share.fetch_max(share.to_bits(), Ordering::Relaxed);
    }
}

/// The most that is shown before the end.
const ALMOST_ALL: f32 = 0.999;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_share_what_is_left_and_only_the_end_is_one() {
        let progress = BuildProgress::new();
        assert_eq!(progress.progress(), 0.0);
        let mut last = 0.0;
        for share in [0.5, 0.5, 0.9, 1.0, 1.0] {
            progress.begin_stage(share, 10);
            for _ in 0..12 {
                progress.advance(1);
                assert!(progress.progress() >= last && progress.progress() < 1.0);
                last = progress.progress();
            }
        }
        assert!(last > 0.99);
        assert_eq!(progress.finish(), Ok(()));
        assert_eq!(progress.progress(), 1.0);
    }

    #[test]
    fn every_clone_can_call_it_off() {
        let progress = BuildProgress::new();
        progress.clone().cancel();
        assert!(progress.is_cancelled());
        assert_eq!(progress.finish(), Err(Cancelled));
        assert!(progress.progress() < 1.0);
    }
}
