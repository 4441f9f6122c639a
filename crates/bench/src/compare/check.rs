//! Compares answers before anything is timed. A wrong answer of kinetree is a failure; those of
//! other engines are counted and shown.
//!
//! Engines are compared with the reference, which is a kinetree tree. Where an engine disagrees
//! with it, an exact search through all triangles decides, against the reference too. The search is
//! also run on a sample of rays on which all engines agree.

use std::collections::BTreeMap;

use super::collect::{DisputedAnswers, collect_answers};
use super::lineup::{BuiltEngine, named};
use super::log::Log;
use super::plan::Plan;
use crate::agree::{AnswerDifferences, EngineAnswer, ExactAnswers, disputes};
use crate::case::{Case, leeway};
use crate::engine::{FAST_PRECISION_SUFFIX, Reference};
use crate::exact::{closest_by_brute_force, crossing};
use crate::ray::{Answer, Ray};
use crate::rays::{QueryKind, RayKind, RaySet};
use crate::report::WrongAnswers;
use crate::soup::Soup;

/// The number of triangle tests of the exact search for the sample, in a full and in a quick run.
const SAMPLE_TRIANGLE_TESTS: [usize; 2] = [400_000_000, 60_000_000];
/// The same for disputed rays.
const DISPUTE_TRIANGLE_TESTS: [usize; 2] = [40_000_000_000, 1_000_000_000];

/// Wrong answers by engine (with the suffix of its batch), whether rays were traced one by one, and
/// set.
pub(crate) type Disagreements = BTreeMap<(String, bool, RayKind), WrongAnswers>;

/// The outcome of the comparison.
#[derive(Debug, Default)]
pub(crate) struct Checked {
    /// Whether kinetree gave a wrong answer, or another number of hits than the case says.
    pub(crate) kinetree_is_wrong: bool,
    /// Whether any engine gave a wrong answer away from edges of triangles.
    pub(crate) some_engine_differs: bool,
    /// The number of wrong answers.
    pub(crate) disagreements: Disagreements,
}

/// Compares all answers with those of the reference, and decides disputed rays by exact search.
/// Engines that panic are removed from the lineup.
pub(crate) fn check(
    case: &Case,
    plan: &Plan,
    soup: &Soup,
    reference: &Reference,
    sets: &[RaySet],
    lineup: &mut Vec<BuiltEngine>,
    log: &mut Log,
) -> Checked {
    let mut checked = Checked::default();
    let expected: Vec<Vec<Answer>> = sets.iter().map(|set| reference.closest(soup, &set.rays)).collect();
    for (set, answers) in sets.iter().zip(&expected) {
        let hits = answers.iter().filter(|answer| answer.is_hit()).count();
        log.print(&format!("  {:<17} {hits} of {} rays hit something", set.kind.name(), set.rays.len()));
        let wanted = case.expected(set.kind, plan.quick, soup.len());
        if wanted.is_some_and(|wanted| wanted.abs_diff(hits) > leeway(set.kind, set.rays.len())) {
            checked.kinetree_is_wrong = true;
            log.print(&format!("  {}: {hits} rays hit something, the case expects {wanted:?}", set.kind.name()));
        }
    }
    if plan.first {
        checked.kinetree_is_wrong |= !reference_is_right(plan, soup, sets, &expected, log);
    }
    compare_engines(plan, soup, sets, &expected, lineup, log, &mut checked);
    checked
}

/// Compares the reference with the exact search, on as many rays as the budget allows.
fn reference_is_right(plan: &Plan, soup: &Soup, sets: &[RaySet], expected: &[Vec<Answer>], log: &mut Log) -> bool {
    let sample = (SAMPLE_TRIANGLE_TESTS[usize::from(plan.quick)] / soup.len().max(1) / sets.len().max(1)).clamp(4, 512);
    let mut differences = AnswerDifferences::default();
    for (set, answers) in sets.iter().zip(expected) {
        let stride = (set.rays.len() / sample).max(1);
        let rays: Vec<Ray> = set.rays.iter().step_by(stride).copied().collect();
        let given: Vec<Answer> = answers.iter().step_by(stride).copied().collect();
        let right = closest_by_brute_force(soup, &rays);
        let disputes = disputes(&right, given.into_iter().map(EngineAnswer::Nearest));
        differences =
            differences.and(ExactAnswers::default().differences(soup, &rays, &right, &disputes, QueryKind::Closest));
    }
    log.print(&format!(
        "  exact search through all triangles: {} of {} answers of the reference differ, {} of them at edges",
        differences.all, differences.rays, differences.at_edges
    ));
    differences.elsewhere() == 0
}

/// Collects the answers of all engines, decides disputed rays, and counts wrong answers. Engines
/// that panic are removed from the lineup.
fn compare_engines(
    plan: &Plan,
    soup: &Soup,
    sets: &[RaySet],
    expected: &[Vec<Answer>],
    lineup: &mut Vec<BuiltEngine>,
    log: &mut Log,
    checked: &mut Checked,
) {
    let mut collected: Vec<Vec<DisputedAnswers>> = Vec::new();
    lineup.retain(|built| match collect_answers(sets, expected, built) {
        Ok(calls) => {
            collected.push(calls);
            true
        }
        Err(panicked) => {
            log.print(&panicked);
            checked.some_engine_differs = true;
            checked.kinetree_is_wrong |= is_kinetree(built);
            false
        }
    });
    let mut triangle_tests = DISPUTE_TRIANGLE_TESTS[usize::from(plan.quick)];
    let mut exact_answers = Vec::new();
    let (mut settled, mut unsettled, mut reference) = (0, 0, AnswerDifferences::default());
    for (at, (set, answers)) in sets.iter().zip(expected).enumerate() {
        let calls = collected.iter().flatten().filter(|call| call.set == at);
        let disputed: Vec<usize> = calls.flat_map(|call| &call.disputes).map(|dispute| dispute.ray).collect();
        let found = ExactAnswers::of(soup, &set.rays, disputed, &mut triangle_tests);
        (settled, unsettled) = (settled + found.settled(), unsettled + found.unsettled);
        reference = reference.and(found.differences(soup, &set.rays, answers, &[], QueryKind::Closest));
        exact_answers.push(found);
    }
    if settled + unsettled > 0 {
        let (all, at_edges) = (reference.all, reference.at_edges);
        log.print(&format!(
            "  disputed rays: {settled} decided by exact search, {unsettled} in favour of the reference for lack of time; it was wrong about {all}, {at_edges} of them at edges"
        ));
    }
    checked.kinetree_is_wrong |= reference.elsewhere() > 0;
    for (built, calls) in lineup.iter().zip(&collected) {
        count_wrong_answers(soup, sets, expected, &exact_answers, built, calls, log, checked);
    }
}

fn is_kinetree(built: &BuiltEngine) -> bool {
    built.name.starts_with("kinetree")
}

/// Counts and logs the wrong answers of an engine.
fn count_wrong_answers(
    soup: &Soup,
    sets: &[RaySet],
    expected: &[Vec<Answer>],
    exact_answers: &[ExactAnswers],
    built: &BuiltEngine,
    calls: &[DisputedAnswers],
    log: &mut Log,
    checked: &mut Checked,
) {
    let mut total = AnswerDifferences::default();
    let mut notes = Vec::new();
    for call in calls {
        let set = &sets[call.set];
        let (name, query_kind) = (named(&built.name, call.batch.unwrap_or_default()), set.kind.query_kind());
        let differences =
            exact_answers[call.set].differences(soup, &set.rays, &expected[call.set], &call.disputes, query_kind);
        if differences.elsewhere() > 0 {
            notes.push(describe(&name, set, &differences, soup));
        }
        let wrong_answers = WrongAnswers { all: differences.all, elsewhere: differences.elsewhere() };
        checked.disagreements.insert((name, call.batch.is_none(), set.kind), wrong_answers);
        total = total.and(differences);
    }
    log.print(&format!(
        "  {:<28} {} of {} answers are wrong, {} of them at edges",
        built.name, total.all, total.rays, total.at_edges
    ));
    // A few examples are enough.
    let ours = is_kinetree(built);
    let shown = notes.len().min(if ours { 3 } else { 1 });
    notes[..shown].iter().for_each(|note| log.print(note));
    checked.some_engine_differs |= total.elsewhere() > 0;
    // `Precision::Fast` does not promise what the watertight test does.
    checked.kinetree_is_wrong |= ours && !built.name.ends_with(FAST_PRECISION_SUFFIX) && total.elsewhere() > 0;
}

fn describe(engine: &str, set: &RaySet, differences: &AnswerDifferences, soup: &Soup) -> String {
    let (name, count) = (set.kind.name(), differences.elsewhere());
    let mut text = format!("    {engine} differs on {name}: {count} rays away from edges");
    if let Some((ray, expected, given)) = differences.first {
        let describe_answer = |answer: Answer| match soup.sources.get(answer.primitive as usize) {
            Some(source) => {
                let exact = crossing(&set.rays[ray], &soup.corners(answer.primitive));
                let exact = exact.map_or_else(|| "nowhere".to_owned(), |exact| exact.t.to_string());
                format!(
                    "{} (its plane is at {exact}) on triangle {} of instance {}",
                    answer.t, source.primitive, source.mesh
                )
            }
            None => "nowhere".to_owned(),
        };
        let given = match given {
            EngineAnswer::Nearest(answer) => describe_answer(answer),
            EngineAnswer::Occluded(blocked) => (if blocked { "somewhere" } else { "nowhere" }).to_owned(),
        };
        text += &format!("; ray {ray}, {:?}, ends at {}, not {given}", set.rays[ray], describe_answer(expected));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::budget::Budget;
    use crate::compare::lineup;
    use crate::engine;
    use crate::rays;
    use crate::report::Record;

    fn scene_of(case: &Case) -> (crate::scene::BenchScene, Reference, Vec<RaySet>) {
        let scene = case.scene.open().unwrap();
        let reference = Reference::of(&scene.soup).unwrap();
        let trace = |rays: &[Ray]| reference.closest(&scene.soup, rays);
        let sets = rays::sets(&scene, &case.sets, &|kind| case.count(kind, true), case.seed, &trace);
        (scene, reference, sets)
    }

    /// Every engine that is available here, in every way in which it is timed.
    #[test]
    fn every_engine_agrees_on_a_small_scene() {
        let text =
            "name='small'\nseed=3\nrays=1024\nquick_rays=1024\n[scene]\nkind='terrain'\nseed=5\ntriangles=3000\n";
        let case = Case::parse(text).unwrap();
        let (scene, reference, sets) = scene_of(&case);
        let (engines, _) = engine::all();
        let engines: Vec<_> = engines.iter().map(|engine| &**engine).collect();
        let (mut log, mut record) = (Log::default(), Record::default());
        let budget = (&mut Budget::new(false), f64::INFINITY);
        let mut lineup = lineup::build("small", &engines, &scene.soup, budget, &mut log, &mut record).unwrap();
        assert_eq!(lineup.len(), engines.len());
        let checked = check(&case, &Plan::minimal(), &scene.soup, &reference, &sets, &mut lineup, &mut log);
        assert!(!checked.kinetree_is_wrong && !checked.some_engine_differs);
        assert_eq!(lineup.len(), engines.len());
        let embree_costs = record.trees.iter().filter(|tree| tree.engine.starts_with("embree") && tree.cost.is_some());
        let embree = engines.iter().filter(|engine| engine.name().starts_with("embree") && !engine.shares_builds());
        assert_eq!(embree_costs.count(), embree.count());
    }

    /// A tree that reports misses only.
    struct Blind;

    impl engine::Tree for Blind {
        fn closest(&self, _: &[Ray], answers: &mut [Answer]) {
            answers.fill(Answer::MISS);
        }

        fn occluded(&self, _: &[Ray], blocked: &mut [bool]) {
            blocked.fill(false);
        }
    }

    /// Every tenth hit of the reference is replaced by a miss.
    #[test]
    fn errors_of_the_reference_count_against_it_and_not_against_engines_that_are_right() {
        let text = "name='small'\nseed=3\nrays=256\nquick_rays=256\n[scene]\nkind='pile'\nseed=5\ntriangles=2000\n";
        let case = Case::parse(text).unwrap();
        let (scene, reference, sets) = scene_of(&case);
        let mut expected: Vec<Vec<Answer>> = sets.iter().map(|set| reference.closest(&scene.soup, &set.rays)).collect();
        let forgotten = expected.iter_mut().map(|answers| {
            answers.iter_mut().step_by(10).filter(|answer| answer.is_hit()).map(|answer| *answer = Answer::MISS).count()
        });
        assert!(forgotten.sum::<usize>() > 20);
        let (engines, _) = engine::all();
        let right: Vec<_> = engines.iter().map(|engine| &**engine).filter(|it| it.name() == "kinetree best").collect();
        let (mut log, mut record) = (Log::default(), Record::default());
        let budget = (&mut Budget::new(false), f64::INFINITY);
        let mut lineup = lineup::build("small", &right, &scene.soup, budget, &mut log, &mut record).unwrap();
        lineup[0].name = "a rival".into();
        let mut checked = Checked::default();
        compare_engines(&Plan::minimal(), &scene.soup, &sets, &expected, &mut lineup, &mut log, &mut checked);
        assert!(checked.kinetree_is_wrong && !checked.some_engine_differs);
        assert!(checked.disagreements.values().all(|wrong_answers| wrong_answers.all == 0));
    }

    #[test]
    fn wrong_answers_of_kinetree_are_a_failure_and_those_of_others_are_counted() {
        let text = "name='small'\nseed=3\nrays=256\nquick_rays=256\n[scene]\nkind='pile'\nseed=5\ntriangles=2000\n";
        let mut case = Case::parse(text).unwrap();
        let (scene, reference, sets) = scene_of(&case);
        let checked = |case: &Case, name: &str| {
            let built = BuiltEngine {
                name: name.into(),
                instructions: String::new(),
                class: engine::Class::Fast,
                robust: false,
                tree: Box::new(Blind),
            };
            let mut lineup = vec![built];
            let plan = Plan::minimal();
            let checked = check(case, &plan, &scene.soup, &reference, &sets, &mut lineup, &mut Log::default());
            assert_eq!(lineup.len(), 1);
            checked
        };
        let others = checked(&case, "blind");
        assert!(!others.kinetree_is_wrong && others.some_engine_differs);
        assert!(others.disagreements[&("blind".into(), true, RayKind::Primary)].elsewhere > 10);
        assert!(checked(&case, "kinetree blind").kinetree_is_wrong);

        case.hits.insert(RayKind::Primary, crate::case::Hits { full: None, quick: Some(100_000) });
        assert!(checked(&case, "blind").kinetree_is_wrong);
    }
}
