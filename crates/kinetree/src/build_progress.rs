//! Progress and cancellation of a long build, from another thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use thiserror::Error;

/// The progress of one build, and the means to cancel it. Clones refer to the same build; any
/// thread may read and cancel.
///
/// A build without one pays nothing.
#[derive(Debug, Clone, Default)]
pub struct BuildProgress(Arc<State>);

/// The error of a cancelled build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the build was cancelled")]
pub struct Cancelled;

/// A build is a sequence of stages. Each is a fraction of what its predecessors have left, so the
/// number of stages need not be known.
///
/// Fractions are stored as the bits of floats, which are ordered as the floats are because none is
/// negative; so `fetch_max` works on them.
#[derive(Debug, Default)]
struct State {
    is_cancelled: AtomicBool,
    /// The fraction done, from 0 to 1.
    fraction: AtomicU32,
    /// Where the current stage begins and ends, as fractions of the whole build.
    start: AtomicU32,
    end: AtomicU32,
    /// Steps of the current stage.
    done: AtomicU64,
    steps: AtomicU64,
}

impl BuildProgress {
    /// For a build that has not begun.
    pub fn new() -> Self {
        Self::default()
    }

    /// The fraction of the build that is done, from 0 to 1: an estimate by counts, not by time. It
    /// never falls, and is 1 only when the build has finished.
    pub fn progress(&self) -> f32 {
        f32::from_bits(self.0.fraction.load(Ordering::Relaxed))
    }

    /// Cancels the build. It soon returns [`Cancelled`], unless it has just finished: each thread
    /// finishes its current task, and progress hardly moves any more.
    pub fn cancel(&self) {
        self.0.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the build was cancelled.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.0.is_cancelled.load(Ordering::Relaxed)
    }

    /// Begins the next stage, of `steps` steps, which is expected to take `fraction` of the time
    /// that is left. The caller must be the only thread at work. Does nothing once the build is
    /// cancelled.
    pub(crate) fn begin_stage(&self, fraction: f32, steps: usize) {
        if self.is_cancelled() {
            return;
        }
        let state = &*self.0;
        let start = f32::from_bits(state.end.load(Ordering::Relaxed));
        self.show(start);
        state.start.store(start.to_bits(), Ordering::Relaxed);
        state.end.store((start + (1.0 - start) * fraction).min(ALMOST_ALL).to_bits(), Ordering::Relaxed);
        state.done.store(0, Ordering::Relaxed);
        state.steps.store(steps.max(1) as u64, Ordering::Relaxed);
    }

    /// Records that `steps` more steps of the stage are done.
    pub(crate) fn advance(&self, steps: usize) {
        let state = &*self.0;
        let done = state.done.fetch_add(steps as u64, Ordering::Relaxed) + steps as u64;
        let part = (done as f32 / state.steps.load(Ordering::Relaxed) as f32).min(1.0);
        let [start, end] = [&state.start, &state.end].map(|bits| f32::from_bits(bits.load(Ordering::Relaxed)));
        self.show((start + (end - start) * part).min(end));
    }

    /// Ends the build.
    ///
    /// # Errors
    /// The build was cancelled before.
    pub(crate) fn finish(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() {
            return Err(Cancelled);
        }
        self.show(1.0);
        Ok(())
    }

    fn show(&self, fraction: f32) {
        self.0.fraction.fetch_max(fraction.to_bits(), Ordering::Relaxed);
    }
}

/// The largest fraction before the end.
const ALMOST_ALL: f32 = 0.999;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_share_what_is_left_and_only_the_end_is_one() {
        let progress = BuildProgress::new();
        assert_eq!(progress.progress(), 0.0);
        let mut last = 0.0;
        for fraction in [0.5, 0.5, 0.9, 1.0, 1.0] {
            progress.begin_stage(fraction, 10);
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
