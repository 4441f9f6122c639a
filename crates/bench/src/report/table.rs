//! The tables for readers.

use std::fmt::Write as _;

use super::goal::show;
use super::row::{Metric, PerRay, Row};

/// All rows, grouped by job, the best first; rows of kinetree with their ratios to the best of the
/// others.
pub(crate) fn table(rows: &[Row]) -> String {
    let mut text = String::new();
    let mut done = vec![false; rows.len()];
    for at in 0..rows.len() {
        if done[at] {
            continue;
        }
        let mut group: Vec<&Row> = Vec::new();
        for (other, row) in rows.iter().enumerate().skip(at) {
            if rows[at].is_comparable(row) {
                done[other] = true;
                group.push(row);
            }
        }
        head(&mut text, group[0]);
        let more_is_better = group[0].metric == Metric::Trace;
        group.sort_by(|a, b| {
            let order = a.median.total_cmp(&b.median);
            if more_is_better { order.reverse() } else { order }
        });
        group.iter().for_each(|row| line(&mut text, row, rows));
    }
    text
}

fn head(text: &mut String, row: &Row) {
    let what = match (row.metric, row.rays) {
        (Metric::Trace, Some(kind)) => kind.name(),
        (Metric::Trace, None) => "trace",
        (Metric::Build, _) => "build",
        (Metric::Refit, _) => "refit",
        (Metric::TopLevel, _) => "top level",
        (Metric::Memory, _) => "memory",
        (Metric::PeakMemory, _) => "peak memory",
    };
    let how = if row.mode.is_some_and(|mode| mode != crate::engine::Mode::Single) { ", many at once" } else { "" };
    let threads = if row.threads == 1 { "1 thread".to_owned() } else { format!("{} threads", row.threads) };
    let rays = if row.count > 0 { format!(" | {} rays", row.count) } else { String::new() };
    // Writing to a string cannot fail.
    let _ = writeln!(text, "\n{} | {what}{how} | {threads} | {}{rays}", row.case, row.unit.name());
}

fn line(text: &mut String, row: &Row, rows: &[Row]) {
    let robust = if row.robust { "watertight" } else { "" };
    let spread = format!("{:.3} to {:.3}", row.min, row.max);
    let _ =
        write!(text, "  {:<28} {:<9} {robust:<10} {:>10.3}  {spread:<22}", row.engine, row.instructions, row.median);
    if row.is_kinetree() {
        let like = row.against(rows, |other| row.is_rival(other));
        let best = row.against(rows, |_| true);
        for (other, which) in [(like, "like"), (best, "best")] {
            if let Some((name, ratio)) =
                other.and_then(|(other, log_ratios)| Some((&other.engine, log_ratios.ratio()?)))
            {
                let _ = write!(text, " {} of {name} ({which})", show(ratio));
            }
        }
    }
    if let Some(work) = &row.work {
        let PerRay { nodes, blocks, triangles, lines } = work;
        let _ =
            write!(text, "  {nodes:.1} nodes, {blocks:.1} blocks, {triangles:.1} triangles, {lines:.0} lines a ray");
    }
    if let Some(wrong_answers) = row.wrong_answers.filter(|wrong_answers| wrong_answers.all > 0) {
        let _ = write!(text, "  {} answers differ, {} not at edges", wrong_answers.all, wrong_answers.elsewhere);
    }
    while text.ends_with(' ') {
        text.pop();
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::super::row::{WrongAnswers, example};
    use super::*;
    use crate::engine::Class;

    #[test]
    fn rows_of_kinetree_show_their_ratios_and_the_fastest_comes_first() {
        let wrong_answers = Some(WrongAnswers { all: 7, elsewhere: 3 });
        let rows = [
            Row { wrong_answers, ..example("embree medium", Class::Fast, false, &[0.5, 0.5]) },
            example("kinetree", Class::Fast, true, &[0.25, 0.25]),
            example("embree medium robust", Class::Fast, true, &[1.0, 1.0]),
        ];
        let text = table(&rows);
        let lines: Vec<&str> = text.lines().filter(|line| line.starts_with("  ")).collect();
        assert!(
            lines[0].contains("kinetree") && lines[0].contains("4.00x [4.00, 4.00] of embree medium robust (like)"),
            "{text}"
        );
        assert!(lines[0].contains("2.00x [2.00, 2.00] of embree medium (best)"), "{text}");
        assert!(lines[1].contains("7 answers differ, 3 not at edges"), "{text}");
        assert!(lines[2].contains("embree medium robust"));
        assert!(lines.iter().all(|line| line.contains(" avx2 ")), "{text}");
    }
}
