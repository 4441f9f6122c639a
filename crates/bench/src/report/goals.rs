//! The goals for speed, each with its measured ratios: kinetree over the best rival, case by case,
//! and the geometric mean.

use super::derived::base;
use super::goal::{CaseRatio, Goal, Target};
use super::record::{Record, TreeNote};
use super::row::{GROWTH, Metric, Row};
use crate::engine::{Class, Mode};
use crate::measure::statistics::LogRatios;
use crate::rays::RayKind;

/// The class, the setting of kinetree, the setting of Embree, and the name of the class.
const CLASSES: [(Class, &str, &str, &str); 2] =
    [(Class::Fast, "kinetree fast", "embree medium", "Fast"), (Class::Best, "kinetree best", "embree high", "Best")];

const HEAD: &str = "
== goals: how many times faster kinetree is than the best of the others, scene by scene, and the geometric mean

Fast: kinetree's Fast trees against Embree MEDIUM, tinybvh's plain build and the like. Best: kinetree's Best trees against Embree HIGH, tinybvh HQ and
the like. In brackets: the ratio exceeds the first number with a probability of 95 %, and lies below the second with the same. Rounds are paired; the
bounds are Student's for the mean of logarithms: of the means of processes if there are several, else of rounds; [-] after a single measurement. The
first number must reach the target.

";

/// A text with all goals, and the level at which they were measured.
pub(crate) fn goals(record: &Record, level: &str, second_cache: usize) -> String {
    let mut text = format!(
        "{HEAD}Level {level}; engines that cannot be forced to a level use the instructions of their own build.\n\n"
    );
    let mut all = Vec::new();
    for class in CLASSES {
        rays(record, class, &mut all);
        batches(record, class, second_cache, &mut all);
    }
    thin(record, &mut all);
    builds(record, &mut all);
    rest(record, &mut all);
    all.iter().for_each(|goal| goal.write(&mut text));
    text
}

impl Record {
    /// For each case, the row of kinetree that `ours` selects over the fastest row that `rival`
    /// selects.
    fn pairs(&self, ours: impl Fn(&Row) -> bool, rival: impl Fn(&Row) -> bool) -> Vec<CaseRatio> {
        let find = |row: &Row| {
            let others =
                self.rows.iter().filter(|other| other.case == row.case && !other.times.is_empty() && rival(other));
            let best = others.min_by(|a, b| a.seconds().total_cmp(&b.seconds()))?;
            let wrong_answers = best.wrong_answers.filter(|wrong_answers| wrong_answers.elsewhere > 0);
            let wrong_answers = wrong_answers.map_or_else(String::new, |wrong_answers| {
                format!(", which gives {} wrong answers", wrong_answers.elsewhere)
            });
            let log_ratios = LogRatios::of_times(&row.times, &best.times);
            Some(CaseRatio { case: row.case.clone(), note: format!("of {}{wrong_answers}", best.engine), log_ratios })
        };
        let growth = |row: &&Row| row.case.starts_with(GROWTH);
        self.rows.iter().filter(|row| !growth(row) && row.is_kinetree() && ours(row)).filter_map(find).collect()
    }
}

fn is_single(row: &Row, kind: RayKind, class: Class, robust: bool) -> bool {
    row.rays == Some(kind)
        && row.mode == Some(Mode::Single)
        && row.threads == 1
        && row.class == class
        && row.robust == robust
}

type ClassRow = (Class, &'static str, &'static str, &'static str);

/// Goals for single calls.
fn rays(record: &Record, (class, _, _, classes): ClassRow, all: &mut Vec<Goal>) {
    let sets = [(RayKind::Primary, 1.3), (RayKind::Diffuse, 1.3), (RayKind::Shadow, 1.5), (RayKind::ShadowShort, 1.5)];
    let mut add = |kind: RayKind, what: &str, target, found| {
        all.push(Goal {
            what: format!("{classes} | {}, single calls, {what}", kind.name()),
            target,
            found,
            alone: false,
        });
    };
    for (kind, aim) in sets {
        let is = |robust| move |row: &Row| is_single(row, kind, class, robust);
        let others = |robust| move |row: &Row| !row.is_kinetree() && is_single(row, kind, class, robust);
        let found = record.pairs(is(false), others(false));
        add(kind, "Precision::Fast over fast modes", Target::AtLeast(1.1, aim), found);
        add(kind, "watertight over fast modes", Target::Shown, record.pairs(is(true), others(false)));
        add(kind, "watertight over robust modes", Target::AtLeast(1.2, 1.5), record.pairs(is(true), others(true)));
        let own = record.pairs(is(true), |row| row.is_kinetree() && is_single(row, kind, class, false));
        add(kind, "watertight over our own Precision::Fast", Target::AtLeast(0.9, 0.95), own);
    }
}

/// Goals for batches.
fn batches(record: &Record, (class, ..): ClassRow, second_cache: usize, all: &mut Vec<Goal>) {
    let (_, name, _, classes) = CLASSES[usize::from(class == Class::Best)];
    let batch = |kind: RayKind, robust: bool| {
        move |row: &Row| {
            let same = row.rays == Some(kind) && row.mode == Some(Mode::Batch) && row.threads == 1;
            same && row.class == class && row.robust == robust
        }
    };
    for robust in [false, true] {
        let how = if robust { "watertight" } else { "Precision::Fast" };
        let packet = |row: &Row| {
            let same = row.rays == Some(RayKind::Primary) && row.mode == Some(Mode::Packet) && row.threads == 1;
            same && row.class == class && !row.robust
        };
        let found = record.pairs(batch(RayKind::Primary, robust), packet);
        let what = format!("{classes} | primary, coherent batch, {how} over Embree's best fast packets");
        all.push(Goal { what, target: Target::AtLeast(0.9, 1.2), found, alone: false });

        let shuffled = |row: &Row| {
            let same = row.rays == Some(RayKind::DiffuseShuffled) && row.threads == 1;
            same && !row.is_kinetree() && row.class == class && !row.robust
        };
        let sorted = |row: &Row| row.engine.ends_with(" sorted");
        let plain = record.pairs(batch(RayKind::DiffuseShuffled, robust), |row| shuffled(row) && !sorted(row));
        let beside = record.pairs(batch(RayKind::DiffuseShuffled, robust), |row| shuffled(row) && sorted(row));
        let is_large =
            |found: &CaseRatio| record.tree(&found.case, name).is_some_and(|tree| tree.bytes > 10 * second_cache);
        let (large, small): (Vec<CaseRatio>, Vec<CaseRatio>) = plain.into_iter().partition(is_large);
        for (size, target, found) in [
            ("trees over ten times the second cache", Target::AtLeast(1.4, 2.2), large),
            ("smaller trees", Target::AtLeast(1.0, 1.2), small),
            ("beside it: over Embree on our sorted rays, the sort charged", Target::Shown, beside),
        ] {
            let what = format!("{classes} | diffuse_shuffled, batch, {how}, {size}");
            all.push(Goal { what, target, found, alone: false });
        }
    }
}

/// Goals for scenes of long thin triangles, each scene for itself.
fn thin(record: &Record, all: &mut Vec<Goal>) {
    for robust in [false, true] {
        let how = if robust { "watertight" } else { "Precision::Fast" };
        for kind in [RayKind::Primary, RayKind::Diffuse] {
            let is = |row: &Row| is_single(row, kind, Class::Best, robust);
            let others = |row: &Row| !row.is_kinetree() && is_single(row, kind, Class::Best, false);
            let mut found = record.pairs(is, others);
            found.retain(|found| ["thin_diagonals_a", "long_diagonals"].contains(&found.case.as_str()));
            for found in &mut found {
                let bytes = |engine: &str| {
                    record.tree(&found.case, engine).map(|tree| tree.bytes as f64 / tree.triangles as f64)
                };
                let number = |bytes: Option<f64>| bytes.map_or_else(|| "-".to_owned(), |bytes| format!("{bytes:.0}"));
                let engine = found.note.strip_prefix("of ").unwrap_or_default();
                let engine = engine.split(',').next().unwrap_or_default();
                found.note += &format!(
                    "; {} against {} bytes per triangle",
                    number(bytes("kinetree best")),
                    number(bytes(engine))
                );
            }
            let what = format!("Best | {}, long thin triangles, {how} over fast modes", kind.name());
            all.push(Goal { what, target: Target::AtLeast(1.4, 2.5), found, alone: true });
        }
    }
}

/// How fast rays are traced in the built trees, and what the trees cost.
fn quality(record: &Record, case: &str, ours: &str, rival: &str) -> (Option<f64>, String) {
    let traced = record.traced(case, ours, rival).and_then(|log_ratios| log_ratios.ratio()).map(|ratio| ratio.mean);
    let cost =
        |engine: &str| record.tree(case, base(engine)).filter(|tree| !tree.is_binary()).and_then(|tree| tree.cost);
    let shown = traced.map_or_else(|| "-".to_owned(), |traced| format!("{traced:.2}x"));
    let costs = cost(ours).zip(cost(rival));
    let costs = costs
        .map_or_else(String::new, |(ours, rival)| format!(", cost {ours:.2} against {rival:.2} by Embree's formula"));
    let text = format!("rays {shown}{costs}");
    (traced, text)
}

/// Goals for builds on one thread.
fn builds(record: &Record, all: &mut Vec<Goal>) {
    let loose = |engine: &str| format!("{engine}{}", crate::engine::FAST_PRECISION_SUFFIX);
    // With `Precision::Fast`, like Embree's default, if that was measured.
    let tracing = |case: &str, engine: &str| {
        let other = loose(engine);
        if record.single(case, &other, RayKind::Primary, 1).is_some() { other } else { engine.to_owned() }
    };
    let compare = |ours: &'static str, rival: &'static str| {
        let is =
            |name: &'static str| move |row: &Row| row.metric == Metric::Build && row.threads == 1 && row.engine == name;
        let mut found = record.pairs(is(ours), is(rival));
        for found in &mut found {
            found.note += &format!(": {}", quality(record, &found.case, &tracing(&found.case, ours), rival).1);
        }
        found
    };
    let mut add = |what: &str, target, found| all.push(Goal { what: what.into(), target, found, alone: false });
    let fastest = compare("kinetree fastest", "embree low");
    let good = |found: &CaseRatio, than: &str, least: f64| {
        let ours = tracing(&found.case, "kinetree fastest");
        quality(record, &found.case, &ours, than).0.is_some_and(|traced| traced >= least)
    };
    let (level, rest): (Vec<CaseRatio>, Vec<CaseRatio>) =
        fastest.clone().into_iter().partition(|found| good(found, "embree low", 1.0));
    let near: Vec<CaseRatio> = fastest.iter().filter(|found| good(found, "embree medium", 0.95)).cloned().collect();
    add("build, Fastest over Embree LOW, where rays are at least as fast", Target::AtLeast(1.0, 1.2), level);
    add("build, Fastest over Embree LOW, where rays are slower", Target::Shown, rest);
    // The build may take 1.6 times as long as Embree's.
    add(
        "build, Fastest over Embree LOW, where rays reach 0.95 of MEDIUM's",
        Target::AtLeast(1.0 / 1.6, 1.2 / 1.6),
        near,
    );
    add("build, Fast over Embree MEDIUM", Target::AtLeast(1.2, 1.8), compare("kinetree fast", "embree medium"));
    add("build, Fast over tinybvh", Target::Shown, compare("kinetree fast", "tinybvh"));
    add("build, Best over Embree HIGH", Target::AtLeast(1.0, 1.5), compare("kinetree best", "embree high"));
}

/// Goals for scaling, time to image, refits, growth and memory.
fn rest(record: &Record, all: &mut Vec<Goal>) {
    let mut add = |what: String, target, found, alone| all.push(Goal { what, target, found, alone });
    for (_, ours, rival, _) in CLASSES {
        // The aim for kinetree's own scaling is 1.9, which the notes show.
        let target = Target::AtLeast(1.0, 1.0);
        add(
            format!("scaling of builds, {ours} over {rival}, aim 1.9 by itself"),
            target,
            record.scalings(None, (ours, rival)),
            false,
        );
        for kind in [RayKind::Primary, RayKind::Diffuse] {
            let found = record.scalings(Some(kind), (ours, rival));
            add(format!("scaling of {}, {ours} over {rival}, aim 1.9 by itself", kind.name()), target, found, false);
        }
    }
    for each in [1.0, 10.0, 100.0] {
        for (robust, how) in [(false, "Precision::Fast"), (true, "watertight")] {
            let what = format!(
                "time to image, {each} rays per triangle (a third each primary, diffuse, shadow), best settings, {how}"
            );
            add(what, Target::AtLeast(1.1, 1.5), record.images(each, robust), false);
        }
    }
    let refit = |row: &Row| row.metric == Metric::Refit;
    let found = record.pairs(refit, |row| refit(row) && row.engine.starts_with("embree"));
    let (mut unindexed, indexed): (Vec<CaseRatio>, Vec<CaseRatio>) =
        found.into_iter().partition(|found| found.case.ends_with(UNINDEXED));
    unindexed.iter_mut().for_each(|found| found.case.truncate(found.case.len() - UNINDEXED.len()));
    add("refit, shared vertices, over Embree's".into(), Target::AtLeast(1.4, 2.0), indexed, false);
    add("refit, three vertices for each triangle, over Embree's".into(), Target::AtLeast(1.4, 2.0), unindexed, false);
    let growth = |engine: &&str| record.growth(engine);
    let ours = ["kinetree fast"].iter().filter_map(growth).collect();
    add("growth of build time per triangle over log2(N/4)".into(), Target::AtMost(1.3, 1.15), ours, true);
    let others = ["kinetree fastest", "embree low", "embree medium", "tinybvh"].iter().filter_map(growth).collect();
    add("growth of others".into(), Target::Shown, others, true);
    let bytes = |tree: &TreeNote| {
        let each = tree.bytes as f64 / tree.triangles.max(1) as f64;
        let ours = tree.engine == "kinetree fast" && !tree.case.starts_with(GROWTH);
        ours.then(|| CaseRatio {
            case: tree.case.clone(),
            note: "bytes".into(),
            log_ratios: LogRatios::of_processes([each]),
        })
    };
    let found = record.trees.iter().filter_map(bytes).collect();
    add("bytes per triangle of the Fast tree, leaves included".into(), Target::AtMost(75.0, 66.0), found, true);
}

/// Ends the names of cases whose triangles share no vertices.
pub(crate) const UNINDEXED: &str = " unindexed";

#[cfg(test)]
mod tests {
    use super::super::row::example;
    use super::*;

    #[test]
    fn each_goal_finds_its_own_rows() {
        let row = |engine: &str, class, robust, times: &[f64]| example(engine, class, robust, times);
        let record = Record {
            rows: vec![
                row("kinetree fast", Class::Fast, true, &[1.0, 1.0]),
                row("kinetree best", Class::Best, true, &[0.5, 0.5]),
                row("embree medium", Class::Fast, false, &[1.5, 1.5]),
                row("embree medium robust", Class::Fast, true, &[2.0, 2.0]),
                row("tinybvh", Class::Fast, false, &[1.25, 1.25]),
                row("embree high", Class::Best, false, &[1.0, 1.0]),
            ],
            ..Record::default()
        };
        let text = goals(&record, "avx2", 1 << 20);
        let after = |start: &str| {
            let at = text.find(start).unwrap_or_else(|| panic!("{start} in {text}"));
            text[at..].lines().skip(2).take(1).collect::<String>()
        };
        let line = after("Fast | primary, single calls, watertight over fast modes");
        assert!(line.contains("1.25x [1.25, 1.25]  of tinybvh"), "{line}");
        let line = after("Fast | primary, single calls, watertight over robust modes");
        assert!(line.contains("2.00x") && line.contains("embree medium robust"), "{line}");
        let line = after("Best | primary, single calls, watertight over fast modes");
        assert!(line.contains("2.00x") && line.contains("embree high"), "{line}");
        assert!(text.contains("Fast | primary, single calls, Precision::Fast over fast modes"));
        assert!(text.contains("not measured"));
    }
}
