//! Wall-clock time, and processor time.

use std::time::{Duration, Instant};

/// The readings of both clocks at the start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stopwatch {
    wall: Instant,
    processor: Duration,
    scope: ClockScope,
}

/// Whose processor time counts.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ClockScope {
    /// The calling thread's.
    Thread,
    /// All threads of the process: for jobs that run on threads of their own.
    Process,
}

/// How long a job took.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Elapsed {
    /// Wall-clock time, seconds.
    pub(crate) wall: f64,
    /// Processor time, seconds; wall-clock time if the system does not tell.
    pub(crate) processor: f64,
}

impl Stopwatch {
    /// Starts the stopwatch.
    pub(crate) fn start(scope: ClockScope) -> Self {
        Self { wall: Instant::now(), processor: worked(scope).unwrap_or_default(), scope }
    }

    /// The time since the start.
    pub(crate) fn read(&self) -> Elapsed {
        let processor = worked(self.scope).map(|now| now.saturating_sub(self.processor).as_secs_f64());
        let wall = self.wall.elapsed().as_secs_f64();
        Elapsed { wall, processor: processor.unwrap_or(wall) }
    }
}

#[cfg(unix)]
fn worked(scope: ClockScope) -> Option<Duration> {
    let clock = match scope {
        ClockScope::Thread => libc::CLOCK_THREAD_CPUTIME_ID,
        ClockScope::Process => libc::CLOCK_PROCESS_CPUTIME_ID,
    };
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `time` is a live variable of the type that is written.
    let failed = unsafe { libc::clock_gettime(clock, &mut time) } != 0;
    (!failed).then(|| Duration::new(time.tv_sec as u64, time.tv_nsec as u32))
}

#[cfg(not(unix))]
fn worked(_: ClockScope) -> Option<Duration> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_counted_and_sleep_is_not() {
        let watch = Stopwatch::start(ClockScope::Thread);
        std::thread::sleep(Duration::from_millis(30));
        let slept = watch.read();
        assert!(slept.wall >= 0.03);
        assert!(cfg!(not(unix)) || slept.processor < 0.02, "{slept:?}");
        let mut x = 1_u64;
        while watch.read().processor - slept.processor < 0.002 {
            x = std::hint::black_box(x.wrapping_mul(3));
        }
    }
}
