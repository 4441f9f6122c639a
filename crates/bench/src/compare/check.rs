//! Answers first: how many of each engine differ from the reference. A wrong one of ours is a failure; those of others are counted and shown.
//!
//! The reference is a tree of ours with distances in double precision. It is held itself against a search through all triangles in double precision, on as
//! many rays as there is time for.

use std::collections::BTreeMap;

use super::field::{Entrant, guarded};
use super::traces::named;
use super::{Log, Plan};
use crate::agree::{Differences, compare, compare_occlusion};
use crate::case::{Case, leeway};
use crate::engine::ours::LOOSE;
use crate::engine::{Batch, ours};
use crate::exact::{self, Exact};
use crate::ray::{Answer, Ray};
use crate::rays::Kind;
use crate::rays::{Question, RaySet};
use crate::report::Differ;
use crate::soup::Soup;

/// How many triangle tests the slow twin is given.
const LOOKS: usize = 400_000_000;
/// The same in a quick run.
const QUICK_LOOKS: usize = 60_000_000;

/// Of engine (with the name of its batch), whether rays came one by one, and set.
pub(crate) type Disagreements = BTreeMap<(String, bool, Kind), Differ>;

/// What came of it.
#[derive(Debug, Default)]
pub(crate) struct Checked {
    /// Whether an answer of ours, or how many there are, was not as it should be.
    pub(crate) ours_wrong: bool,
    /// Whether anybody's was not, apart from edges of triangles.
    pub(crate) somebody_differs: bool,
    /// How often.
    pub(crate) disagreements: Disagreements,
}

/// Compares all answers with those of the reference, and the reference with its slow twin. Entrants that panic leave the field.
pub(crate) fn check(
    case: &Case,
    plan: &Plan,
    soup: &Soup,
    reference: &ours::Reference,
    sets: &[RaySet],
    field: &mut Vec<Entrant>,
    log: &mut Log,
) -> Checked {
    let mut checked = Checked::default();
    let expected: Vec<Vec<Answer>> = sets.iter().map(|set| reference.closest(soup, &set.rays)).collect();
    for (set, answers) in sets.iter().zip(&expected) {
        let hits = answers.iter().filter(|answer| answer.is_hit()).count();
        log.say(&format!("  {:<17} {hits} of {} rays hit something", set.kind.name(), set.rays.len()));
        let wanted = case.expected(set.kind, plan.quick, soup.len());
        if wanted.is_some_and(|wanted| wanted.abs_diff(hits) > leeway(set.rays.len())) {
            checked.ours_wrong = true;
            log.say(&format!("  {}: {hits} rays hit something, the case says otherwise: {wanted:?}", set.kind.name()));
        }
    }
    if plan.first {
        checked.ours_wrong |= !looks_right(plan, soup, sets, &expected, log);
    }
    field.retain(|entrant| entrant_answers(soup, sets, &expected, entrant, log, &mut checked));
    checked
}

/// The reference against its slow twin, on as many rays as there is time for.
fn looks_right(plan: &Plan, soup: &Soup, sets: &[RaySet], expected: &[Vec<Answer>], log: &mut Log) -> bool {
    let looks = if plan.quick { QUICK_LOOKS } else { LOOKS };
    let sample = (looks / soup.len().max(1) / sets.len().max(1)).clamp(4, 512);
    let mut differences = Differences::default();
    for (set, answers) in sets.iter().zip(expected) {
        let stride = (set.rays.len() / sample).max(1);
        let rays: Vec<Ray> = set.rays.iter().step_by(stride).copied().collect();
        let given: Vec<Answer> = answers.iter().step_by(stride).copied().collect();
        differences = differences.and(compare(soup, &rays, &exact::closest_by_looking(soup, &rays), &given));
    }
    log.say(&format!(
        "  looking at every triangle in double precision: {} of {} rays differ, {} of them at edges",
        differences.all, differences.rays, differences.at_edges
    ));
    differences.elsewhere() == 0
}

/// Counts an entrant's differences; whether it can be timed.
fn entrant_answers(
    soup: &Soup,
    sets: &[RaySet],
    expected: &[Vec<Answer>],
    entrant: &Entrant,
    log: &mut Log,
    checked: &mut Checked,
) -> bool {
    let ours = entrant.name.starts_with("kinetree");
    let mut total = Differences::default();
    let mut notes = Vec::new();
    for (set, answers) in sets.iter().zip(expected) {
        for (batch, differences) in ways(soup, set, answers, entrant) {
            let name = named(&entrant.name, batch.unwrap_or_default());
            let Some(differences) = differences else {
                log.say(&format!("  {name} panicked on {}: NOT TIMED", set.kind.name()));
                checked.somebody_differs = true;
                checked.ours_wrong |= ours;
                return false;
            };
            if differences.elsewhere() > 0 {
                notes.push(describe(&name, set, &differences, soup));
            }
            let differ = Differ { all: differences.all, elsewhere: differences.elsewhere() };
            checked.disagreements.insert((name, batch.is_none(), set.kind), differ);
            total = total.and(differences);
        }
    }
    log.say(&format!(
        "  {:<28} {} of {} answers differ, {} of them at edges",
        entrant.name, total.all, total.rays, total.at_edges
    ));
    // Examples are enough.
    let shown = notes.len().min(if ours { 3 } else { 1 });
    notes[..shown].iter().for_each(|note| log.say(note));
    checked.somebody_differs |= total.elsewhere() > 0;
    // Single precision is not held to what only the watertight test promises.
    checked.ours_wrong |= ours && !entrant.name.ends_with(LOOSE) && total.elsewhere() > 0;
    true
}

/// Every way in which the entrant is going to be timed on a set (one by one, or the name of a batch), and how its answers differ; `None` when it panics.
fn ways(
    soup: &Soup,
    set: &RaySet,
    expected: &[Answer],
    entrant: &Entrant,
) -> Vec<(Option<&'static str>, Option<Differences>)> {
    let tree = &entrant.tree;
    let single = differences(
        soup,
        set,
        expected,
        |answers| tree.closest(&set.rays, answers),
        |seen| tree.occluded(&set.rays, seen),
    );
    let mut all = vec![(None, single)];
    if let Some(coherence) = set.kind.batch() {
        for batch in tree.batches().into_iter().filter(|batch: &&dyn Batch| batch.suits(coherence)) {
            let closest = |answers: &mut [Answer]| batch.closest(&set.rays, answers, coherence);
            let occluded = |seen: &mut [bool]| batch.occluded(&set.rays, seen, coherence);
            all.push((Some(batch.suffix()), differences(soup, set, expected, closest, occluded)));
        }
    }
    all
}

fn differences(
    soup: &Soup,
    set: &RaySet,
    expected: &[Answer],
    closest: impl Fn(&mut [Answer]),
    occluded: impl Fn(&mut [bool]),
) -> Option<Differences> {
    let asked = || match set.kind.question() {
        Question::Closest => {
            let mut answers = vec![Answer::MISS; set.rays.len()];
            closest(&mut answers);
            compare(soup, &set.rays, expected, &answers)
        }
        Question::Occluded => {
            let mut seen = vec![false; set.rays.len()];
            occluded(&mut seen);
            compare_occlusion(soup, &set.rays, expected, &seen)
        }
    };
    guarded(|| Ok(asked())).ok()
}

fn describe(engine: &str, set: &RaySet, differences: &Differences, soup: &Soup) -> String {
    let (name, count) = (set.kind.name(), differences.elsewhere());
    let mut text = format!("    {engine} differs on {name}: {count} rays away from edges");
    if let Some((ray, expected, given)) = differences.first {
        let place = |answer: Answer| match soup.sources.get(answer.primitive as usize) {
            Some(source) => {
                let exact = Exact::of(soup, &set.rays[ray], answer.primitive).t;
                format!("{} (exactly {exact}) on triangle {} of instance {}", answer.t, source.primitive, source.mesh)
            }
            None => "nowhere".to_owned(),
        };
        let given = given.map_or_else(|| "otherwise".to_owned(), place);
        text += &format!("; ray {ray}, {:?}, ends at {}, not {given}", set.rays[ray], place(expected));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::budget::Budget;
    use crate::compare::field;
    use crate::engine;
    use crate::rays;
    use crate::report::Record;

    fn scene_of(case: &Case) -> (crate::scene::Scenery, ours::Reference, Vec<RaySet>) {
        let scenery = case.scene.open().unwrap();
        let reference = ours::Reference::of(&scenery.soup).unwrap();
        let trace = |rays: &[Ray]| reference.closest(&scenery.soup, rays);
        let sets = rays::sets(&scenery, &case.sets, &|kind| case.count(kind, true), case.seed, &trace);
        (scenery, reference, sets)
    }

    /// Every engine that can be had here, in every way in which it is timed.
    #[test]
    fn every_engine_agrees_on_a_small_scene() {
        let text =
            "name='small'\nseed=3\nrays=1024\nquick_rays=1024\n[scene]\nkind='terrain'\nseed=5\ntriangles=3000\n";
        let case = Case::parse(text).unwrap();
        let (scenery, reference, sets) = scene_of(&case);
        let (engines, _) = engine::all();
        let engines: Vec<_> = engines.iter().map(|engine| &**engine).collect();
        let (mut log, mut record) = (Log::default(), Record::default());
        let budget = (&mut Budget::new(false), f64::INFINITY);
        let mut field = field::build("small", &engines, &scenery.soup, budget, &mut log, &mut record).unwrap();
        assert_eq!(field.len(), engines.len());
        let checked = check(&case, &Plan::least(), &scenery.soup, &reference, &sets, &mut field, &mut log);
        assert!(!checked.ours_wrong && !checked.somebody_differs);
        assert_eq!(field.len(), engines.len());
        let embree_costs = record.trees.iter().filter(|tree| tree.engine.starts_with("embree") && tree.cost.is_some());
        let embree = engines.iter().filter(|engine| engine.name().starts_with("embree") && !engine.shares_builds());
        assert_eq!(embree_costs.count(), embree.count());
    }

    /// A tree that sees nothing.
    struct Blind;

    impl engine::Tree for Blind {
        fn closest(&self, _: &[Ray], answers: &mut [Answer]) {
            answers.fill(Answer::MISS);
        }

        fn occluded(&self, _: &[Ray], seen: &mut [bool]) {
            seen.fill(false);
        }
    }

    #[test]
    fn wrong_answers_of_ours_are_a_failure_and_those_of_others_are_counted() {
        let text = "name='small'\nseed=3\nrays=256\nquick_rays=256\n[scene]\nkind='pile'\nseed=5\ntriangles=2000\n";
        let mut case = Case::parse(text).unwrap();
        let (scenery, reference, sets) = scene_of(&case);
        let checked = |case: &Case, name: &str| {
            let entrant = Entrant {
                name: name.into(),
                instructions: String::new(),
                class: engine::Class::Fast,
                robust: false,
                tree: Box::new(Blind),
            };
            let mut field = vec![entrant];
            let plan = Plan::least();
            let checked = check(case, &plan, &scenery.soup, &reference, &sets, &mut field, &mut Log::default());
            assert_eq!(field.len(), 1);
            checked
        };
        let others = checked(&case, "blind");
        assert!(!others.ours_wrong && others.somebody_differs);
        assert!(others.disagreements[&("blind".into(), true, Kind::Primary)].elsewhere > 10);
        assert!(checked(&case, "kinetree blind").ours_wrong);

        case.hits.insert(Kind::Primary, crate::case::Hits { full: None, quick: Some(100_000) });
        assert!(checked(&case, "blind").ours_wrong);
    }
}
