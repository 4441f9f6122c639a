//! How much is measured, and in how many rounds.

use super::options::Options;
use crate::machine;
use crate::measure::rounds::Rounds;

/// The most triangles that are refitted, or built by several threads, in a quick run.
pub(super) const QUICK_TRIANGLES: usize = 700_000;

/// What all parts of a comparison need to know.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    pub(super) quick: bool,
    /// Whether this is the first process: what is always the same is done in that one only.
    pub(super) first: bool,
    /// Of rays.
    pub(super) rounds: Rounds,
    /// Of builds and refits, which take longer.
    pub(super) builds: Rounds,
    /// All that the machine has.
    pub(super) threads: usize,
}

impl Plan {
    pub(super) fn of(options: &Options) -> Self {
        let rounds = options.rounds.unwrap_or(if options.quick { 5 } else { 9 }).max(1);
        let seconds = f64::INFINITY;
        // Of those who are far behind, three rounds in all are enough.
        let behind = if options.quick || options.processes > 1 { 1 } else { rounds.min(3) };
        Self {
            quick: options.quick,
            first: options.number == 0,
            rounds: Rounds { full: rounds, behind, seconds, warm_up: true },
            // Every tree has been built once before.
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
