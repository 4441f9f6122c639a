//! How much is measured, and in how many rounds.

use super::options::Options;
use crate::machine;
use crate::measure::rounds::Rounds;

/// The largest scene, in triangles, that a quick run refits, or builds on several threads.
pub(super) const QUICK_TRIANGLES: usize = 700_000;

/// Settings that all parts of a comparison share.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    pub(super) quick: bool,
    /// Whether this is the first process. Checks whose outcome is the same in every process run
    /// only in the first.
    pub(super) first: bool,
    /// Rounds of tracing.
    pub(super) rounds: Rounds,
    /// Rounds of builds and refits, which take longer.
    pub(super) builds: Rounds,
    /// The number of threads that the machine has.
    pub(super) threads: usize,
}

impl Plan {
    pub(super) fn of(options: &Options) -> Self {
        let rounds = options.rounds.unwrap_or(if options.quick { 5 } else { 9 }).max(1);
        let seconds = f64::INFINITY;
        // Three rounds in all are enough for engines that are far behind.
        let behind = if options.quick || options.processes > 1 { 1 } else { rounds.min(3) };
        Self {
            quick: options.quick,
            first: options.number == 0,
            rounds: Rounds { full: rounds, behind, seconds, warm_up: true },
            // No warm-up: every tree has been built once before.
            builds: Rounds {
                full: if options.quick { rounds.min(3) } else { rounds },
                behind,
                seconds,
                warm_up: false,
            },
            threads: machine::threads(),
        }
    }

    #[cfg(test)]
    pub(super) fn minimal() -> Self {
        let rounds = Rounds { full: 1, behind: 1, seconds: f64::INFINITY, warm_up: false };
        Self { quick: true, first: true, rounds, builds: rounds, threads: 1 }
    }
}
