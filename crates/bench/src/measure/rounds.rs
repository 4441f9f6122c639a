//! Runs contenders in turn, round by round, so that a machine that slows down slows all of them.

use super::clock::Elapsed;

/// The number of rounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rounds {
    /// Rounds for contenders that are not far behind.
    pub(crate) full: usize,
    /// Rounds for those that are far behind, where a few are enough.
    pub(crate) behind: usize,
    /// A limit for the time of all rounds together, seconds; beyond it, rounds are left out.
    pub(crate) seconds: f64,
    /// Whether the first round is a warm-up that does not count.
    pub(crate) warm_up: bool,
}

/// A contender is far behind if it takes more than this many times the processor time of the
/// fastest.
const FAR_BEHIND: f64 = 6.0;

/// Runs `count` contenders round by round; each round begins with another one. The first round
/// tells which are far behind; for those with a single round it counts, even as a warm-up. If `run`
/// returns `None`, the contender has failed and is not run again. Returns the times of each
/// contender, round by round.
pub(crate) fn in_turn(
    count: usize,
    rounds: Rounds,
    mut run: impl FnMut(usize) -> Option<Elapsed>,
) -> Vec<Vec<Elapsed>> {
    let first: Vec<Option<Elapsed>> = (0..count).map(&mut run).collect();
    let fastest = first.iter().flatten().map(|elapsed| elapsed.processor).fold(f64::INFINITY, f64::min);
    let rounds = within_time(rounds, &first, fastest);
    let mut times = vec![Vec::new(); count];
    let mut turns = vec![0; count];
    for (contender, elapsed) in first.into_iter().enumerate() {
        let Some(elapsed) = elapsed else { continue };
        let wanted = if elapsed.processor <= fastest * FAR_BEHIND { rounds.full } else { rounds.behind };
        let counts = !rounds.warm_up || wanted <= 1 && elapsed.processor > fastest * FAR_BEHIND;
        if counts {
            times[contender].push(elapsed);
        }
        turns[contender] = wanted.saturating_sub(usize::from(counts));
    }
    let mut failed = vec![false; count];
    for round in 0..rounds.full.max(rounds.behind) {
        for turn in 0..count {
            let contender = (turn + round) % count;
            if round >= turns[contender] || failed[contender] {
                continue;
            }
            match run(contender) {
                Some(elapsed) => times[contender].push(elapsed),
                None => failed[contender] = true,
            }
        }
    }
    times
}

/// The rounds that the time limit allows after the first one, at least one.
fn within_time(rounds: Rounds, first: &[Option<Elapsed>], fastest: f64) -> Rounds {
    let all: f64 = first.iter().flatten().map(|elapsed| elapsed.wall).sum();
    let near = first.iter().flatten().filter(|elapsed| elapsed.processor <= fastest * FAR_BEHIND);
    let round: f64 = near.map(|elapsed| elapsed.wall).sum();
    let left = (rounds.seconds - all).max(0.0);
    let affordable = if round > 0.0 { (left / round).min(1e6) as usize } else { usize::MAX };
    let full = rounds.full.min(affordable.max(1));
    Rounds { full, behind: rounds.behind.min(full), ..rounds }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_take_turns_and_those_far_behind_take_fewer() {
        let mut order = Vec::new();
        let times = in_turn(3, Rounds { full: 4, behind: 2, seconds: f64::INFINITY, warm_up: true }, |contender| {
            order.push(contender);
            let wall = if contender == 1 { 10.0 } else { 1.0 };
            Some(Elapsed { wall, processor: wall })
        });
        assert_eq!(times.iter().map(Vec::len).collect::<Vec<_>>(), [4, 2, 4]);
        assert_eq!(order, [0, 1, 2, 0, 1, 2, 1, 2, 0, 2, 0, 0, 2]);
    }

    #[test]
    fn a_slow_contender_with_one_round_runs_once() {
        let mut runs = [0; 2];
        let times = in_turn(2, Rounds { full: 3, behind: 1, seconds: f64::INFINITY, warm_up: true }, |contender| {
            runs[contender] += 1;
            let wall = [1.0, 100.0][contender];
            Some(Elapsed { wall, processor: wall })
        });
        assert_eq!((runs, times[0].len(), times[1].len()), ([4, 1], 3, 1));
    }

    #[test]
    fn without_a_warm_up_every_run_counts() {
        let mut runs = 0;
        let times = in_turn(1, Rounds { full: 3, behind: 3, seconds: f64::INFINITY, warm_up: false }, |_| {
            runs += 1;
            Some(Elapsed { wall: 1.0, processor: 1.0 })
        });
        assert_eq!((runs, times[0].len()), (3, 3));
    }

    #[test]
    fn there_are_no_more_rounds_than_there_is_time_for() {
        for (seconds, expected) in [(f64::INFINITY, 9), (8.0, 3), (0.0, 1)] {
            let rounds = Rounds { full: 9, behind: 3, seconds, warm_up: true };
            let times = in_turn(2, rounds, |_| Some(Elapsed { wall: 1.0, processor: 1.0 }));
            assert_eq!((times[0].len(), times[1].len()), (expected, expected), "{seconds}");
        }
    }

    #[test]
    fn a_contender_that_fails_is_not_run_again() {
        let mut runs = 0;
        let times = in_turn(1, Rounds { full: 5, behind: 5, seconds: f64::INFINITY, warm_up: true }, |_| {
            runs += 1;
            None
        });
        assert!(times[0].is_empty());
        assert_eq!(runs, 1);
    }
}
