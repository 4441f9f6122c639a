//! Answers first: who gives others than the reference is not timed.

use super::field::{Entrant, guarded};
use super::{Log, Plan};
use crate::agree::{Differences, Exact, compare, compare_occlusion, refined};
use crate::case::Case;
use crate::engine::{Batch, ours};
use crate::ray::{Answer, Ray};
use crate::rays::{Question, RaySet};
use crate::soup::Soup;

/// An engine that differs on more than such a part of the rays of a set, away from edges, is not timed. Of ours, any such ray is a failure.
const ALLOWED: f64 = 2e-3;
/// How many triangle tests the slow twin is given.
const LOOKS: usize = 400_000_000;
/// The same in a quick run.
const QUICK_LOOKS: usize = 60_000_000;

/// Compares all answers with those of the reference, and the reference with its slow twin. Entrants that do not agree leave the field. Whether
/// all agreed.
pub(crate) fn check(
    case: &Case,
    plan: &Plan,
    soup: &Soup,
    reference: &ours::Reference,
    sets: &[RaySet],
    field: &mut Vec<Entrant>,
    log: &mut Log,
) -> bool {
    let mut agreed = true;
    let fast: Vec<Vec<Answer>> = sets.iter().map(|set| reference.closest(&set.rays)).collect();
    for (set, answers) in sets.iter().zip(&fast) {
        let hits = answers.iter().filter(|answer| answer.is_hit()).count();
        log.say(&format!("  {:<17} {hits} of {} rays hit something", set.kind.name(), set.rays.len()));
        let wanted = case.expected(set.kind, plan.quick);
        if wanted.is_some_and(|wanted| wanted != hits) {
            agreed = false;
            log.say(&format!("  {}: {hits} rays hit something, the case says otherwise: {wanted:?}", set.kind.name()));
        }
    }
    agreed &= looks_right(plan, soup, reference, sets, &fast, log);
    let expected: Vec<Vec<Answer>> = sets.iter().zip(&fast).map(|(set, fast)| refined(soup, &set.rays, fast)).collect();
    field.retain(|entrant| {
        let (fair, flawless) = entrant_agrees(soup, sets, &expected, entrant, log);
        agreed &= flawless || fair && !entrant.name.starts_with("kinetree");
        fair
    });
    agreed
}

/// The reference against its slow twin, on as many rays as there is time for.
fn looks_right(
    plan: &Plan,
    soup: &Soup,
    reference: &ours::Reference,
    sets: &[RaySet],
    expected: &[Vec<Answer>],
    log: &mut Log,
) -> bool {
    let looks = if plan.quick { QUICK_LOOKS } else { LOOKS };
    let sample = (looks / soup.len().max(1) / sets.len().max(1)).clamp(4, 512);
    let mut differences = Differences::default();
    for (set, answers) in sets.iter().zip(expected) {
        let stride = (set.rays.len() / sample).max(1);
        let rays: Vec<Ray> = set.rays.iter().step_by(stride).copied().collect();
        let fast: Vec<Answer> = answers.iter().step_by(stride).copied().collect();
        let slow: Vec<Answer> = rays.iter().map(|ray| reference.closest_by_looking(ray)).collect();
        differences = differences.and(compare(soup, &rays, &slow, &fast));
    }
    log.say(&format!("  looking at every triangle: {} of {} rays differ", differences.all, differences.rays));
    differences.all == 0
}

/// Whether an entrant is fit to be timed, and whether it differs nowhere but at edges.
fn entrant_agrees(
    soup: &Soup,
    sets: &[RaySet],
    expected: &[Vec<Answer>],
    entrant: &Entrant,
    log: &mut Log,
) -> (bool, bool) {
    let mut total = Differences::default();
    let mut fair = true;
    let mut notes = Vec::new();
    for (set, answers) in sets.iter().zip(expected) {
        for (way, differences) in ways(soup, set, answers, entrant) {
            let Some(differences) = differences else {
                log.say(&format!("  {}{way} panicked on {}", entrant.name, set.kind.name()));
                return (false, false);
            };
            fair &= differences.elsewhere() as f64 <= ALLOWED * differences.rays as f64;
            if differences.elsewhere() > 0 {
                notes.push(describe(entrant, way, set, &differences, soup));
            }
            total = total.and(differences);
        }
    }
    log.say(&format!(
        "  {:<22} {} of {} answers differ, {} of them at edges{}",
        entrant.name,
        total.all,
        total.rays,
        total.at_edges,
        if fair { "" } else { ": NOT TIMED" }
    ));
    // One example is enough of those that are within what is allowed.
    let shown = if fair { notes.len().min(1) } else { notes.len() };
    notes[..shown].iter().for_each(|note| log.say(note));
    (fair, total.elsewhere() == 0)
}

/// Every way in which the entrant is going to be timed on a set, and how its answers differ; `None` when it panics.
fn ways(soup: &Soup, set: &RaySet, expected: &[Answer], entrant: &Entrant) -> Vec<(&'static str, Option<Differences>)> {
    let tree = &entrant.tree;
    let single = differences(
        soup,
        set,
        expected,
        |answers| tree.closest(&set.rays, answers),
        |seen| tree.occluded(&set.rays, seen),
    );
    let mut all = vec![("", single)];
    if let Some(coherence) = set.kind.batch() {
        for batch in tree.batches().into_iter().filter(|batch: &&dyn Batch| batch.suits(coherence)) {
            let closest = |answers: &mut [Answer]| batch.closest(&set.rays, answers, coherence);
            let occluded = |seen: &mut [bool]| batch.occluded(&set.rays, seen, coherence);
            let suffix = if batch.suffix().is_empty() { " in a batch" } else { batch.suffix() };
            all.push((suffix, differences(soup, set, expected, closest, occluded)));
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

fn describe(entrant: &Entrant, way: &str, set: &RaySet, differences: &Differences, soup: &Soup) -> String {
    let (name, count) = (set.kind.name(), differences.elsewhere());
    let mut text = format!("    {}{way} differs on {name}: {count} rays away from edges", entrant.name);
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
    use crate::compare::{Plan, field};
    use crate::engine;
    use crate::measure::rounds::Rounds;
    use crate::rays::{self, Kind};

    /// Every engine that can be had here, in every way in which it is timed.
    #[test]
    fn every_engine_agrees_on_a_small_scene() {
        let text =
            "name='small'\nseed=3\nrays=1024\nquick_rays=1024\n[scene]\nkind='terrain'\nseed=5\ntriangles=3000\n";
        let case = Case::parse(text).unwrap();
        let scenery = case.scene.open().unwrap();
        let reference = ours::Reference::of(&scenery.soup).unwrap();
        let sets = rays::sets(&scenery, &case.sets, case.rays, case.seed, &|rays| reference.closest(rays));
        let (engines, _) = engine::all();
        let engines: Vec<_> = engines.iter().map(|engine| &**engine).collect();
        let mut log = Log::default();
        let mut field = field::build("small", &engines, &scenery.soup, &mut log, &mut Vec::new()).unwrap();
        assert_eq!(field.len(), engines.len());
        let rounds = Rounds { full: 1, behind: 1, warm_up: false };
        let plan = Plan { quick: true, rounds, builds: rounds, threads: 1 };
        assert!(check(&case, &plan, &scenery.soup, &reference, &sets, &mut field, &mut log));
        assert_eq!(field.len(), engines.len());
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
    fn who_does_not_agree_is_not_timed() {
        let text = "name='small'\nseed=3\nrays=256\nquick_rays=256\n[scene]\nkind='pile'\nseed=5\ntriangles=2000\n";
        let mut case = Case::parse(text).unwrap();
        let scenery = case.scene.open().unwrap();
        let reference = ours::Reference::of(&scenery.soup).unwrap();
        let sets = rays::sets(&scenery, &case.sets, case.rays, case.seed, &|rays| reference.closest(rays));
        let rounds = Rounds { full: 1, behind: 1, warm_up: false };
        let plan = Plan { quick: true, rounds, builds: rounds, threads: 1 };
        let blind =
            || Entrant { name: "blind".into(), class: engine::Class::Fast, robust: false, tree: Box::new(Blind) };
        let mut field = vec![blind()];
        assert!(!check(&case, &plan, &scenery.soup, &reference, &sets, &mut field, &mut Log::default()));
        assert!(field.is_empty());

        case.hits.insert(Kind::Primary, crate::case::Hits { full: None, quick: Some(100_000) });
        assert!(!check(&case, &plan, &scenery.soup, &reference, &sets, &mut Vec::new(), &mut Log::default()));
    }
}
