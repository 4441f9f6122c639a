//! Shows progress: as a bar on a terminal, as an occasional line in a log, or not at all if the
//! program is to be quiet.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::output;

/// Shows on standard error how much of the work is done. Threads may report at the same time.
pub(crate) struct Progress {
    pictures: u64,
    done: AtomicU64,
    display: Display,
}

enum Display {
    None,
    Bar(ProgressBar),
    Lines { start: Instant, latest: Mutex<Instant> },
}

/// The length of a bar that shows a fraction.
const STEPS: u64 = 10_000;

/// The time between two lines in a log.
const LOG_INTERVAL: Duration = Duration::from_secs(10);

impl Progress {
    /// Progress of rendering `pictures` pictures of the same size.
    pub(crate) fn new(pictures: u64, quiet: bool) -> Self {
        let display = if quiet {
            Display::None
        } else if std::io::stderr().is_terminal() {
            Display::Bar(bar())
        } else {
            let now = Instant::now();
            Display::Lines { start: now, latest: Mutex::new(now) }
        };
        Self { pictures, done: AtomicU64::new(0), display }
    }

    /// Reports that one more tile is done; `of` is the number of tiles of a picture.
    pub(crate) fn tile_done(&self, of: u64) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        let total = of.saturating_mul(self.pictures);
        match &self.display {
            Display::None => {}
            Display::Bar(bar) => {
                if bar.length() != Some(total) {
                    bar.set_length(total);
                }
                bar.inc(1);
            }
            Display::Lines { start, latest } => write_line(*start, latest, done as f64 / total.max(1) as f64),
        }
    }

    /// Reports the fraction of the work that is done, from 0 to 1.
    pub(crate) fn report_fraction(&self, fraction: f64) {
        match &self.display {
            Display::None => {}
            Display::Bar(bar) => {
                bar.set_length(STEPS);
                bar.set_position((fraction.clamp(0.0, 1.0) * STEPS as f64) as u64);
            }
            Display::Lines { start, latest } => write_line(*start, latest, fraction),
        }
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }
}

/// Prints a line, unless one was printed within `LOG_INTERVAL`.
fn write_line(start: Instant, latest: &Mutex<Instant>, fraction: f64) {
    // If another thread is printing, this line is not needed.
    let Ok(mut latest) = latest.try_lock() else { return };
    if latest.elapsed() >= LOG_INTERVAL {
        *latest = Instant::now();
        output::print_to_stderr(&line(fraction, start.elapsed()));
    }
}

fn bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{wide_bar} {percent:>3} %  {elapsed} gone, {eta} left")
        .expect("the template is a constant, and a sound one");
    ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(5)).with_style(style)
}

fn line(fraction: f64, elapsed: Duration) -> String {
    let left = elapsed.as_secs_f64() * (1.0 - fraction) / fraction.max(1e-9);
    format!("{:.0} % done, {:.0} s gone, {left:.0} s left", fraction * 100.0, elapsed.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_tells_how_far_and_how_long() {
        assert_eq!(line(0.25, Duration::from_secs(10)), "25 % done, 10 s gone, 30 s left");
    }
}
