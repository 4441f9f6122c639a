//! Collects the answers of an engine, in every way in which it will be timed.

use super::guarded::guarded;
use super::lineup::{BuiltEngine, named};
use crate::agree::{Dispute, EngineAnswer, disputes};
use crate::engine::Batch;
use crate::ray::Answer;
use crate::rays::{QueryKind, RaySet};

/// The rays of one set on which an engine, called in one way, disagrees with the reference.
pub(super) struct DisputedAnswers {
    /// The index of the set.
    pub(super) set: usize,
    /// The suffix of the batch; `None` for calls with one ray each.
    pub(super) batch: Option<&'static str>,
    pub(super) disputes: Vec<Dispute>,
}

/// Calls an engine in every way in which it will be timed.
///
/// # Errors
/// A sentence, if the engine panics.
pub(super) fn collect_answers(
    sets: &[RaySet],
    expected: &[Vec<Answer>],
    built: &BuiltEngine,
) -> Result<Vec<DisputedAnswers>, String> {
    let tree = &built.tree;
    let mut all = Vec::new();
    for (at, set) in sets.iter().enumerate() {
        let mut add = |batch: Option<&'static str>, given: Option<Vec<EngineAnswer>>| {
            let name = named(&built.name, batch.unwrap_or_default());
            let given = given.ok_or_else(|| format!("  {name} panicked on {}: NOT TIMED", set.kind.name()))?;
            all.push(DisputedAnswers { set: at, batch, disputes: disputes(&expected[at], given) });
            Ok::<(), String>(())
        };
        add(
            None,
            answers(set, |answers| tree.closest(&set.rays, answers), |blocked| tree.occluded(&set.rays, blocked)),
        )?;
        let Some(coherence) = set.kind.batch() else { continue };
        for batch in tree.batches().into_iter().filter(|batch: &&dyn Batch| batch.suits(coherence)) {
            let closest = |answers: &mut [Answer]| batch.closest(&set.rays, answers, coherence);
            let occluded = |blocked: &mut [bool]| batch.occluded(&set.rays, blocked, coherence);
            add(Some(batch.suffix()), answers(set, closest, occluded))?;
        }
    }
    Ok(all)
}

/// The answers to a set of rays; `None` if the engine panics.
fn answers(set: &RaySet, closest: impl Fn(&mut [Answer]), occluded: impl Fn(&mut [bool])) -> Option<Vec<EngineAnswer>> {
    let ask = || match set.kind.query_kind() {
        QueryKind::Closest => {
            let mut answers = vec![Answer::MISS; set.rays.len()];
            closest(&mut answers);
            answers.into_iter().map(EngineAnswer::Nearest).collect()
        }
        QueryKind::Occluded => {
            let mut blocked = vec![false; set.rays.len()];
            occluded(&mut blocked);
            blocked.into_iter().map(EngineAnswer::Occluded).collect()
        }
    };
    guarded(|| Ok(ask())).ok()
}
