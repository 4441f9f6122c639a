//! The table for readers.

use std::fmt::Write as _;

use super::{Metric, Row};
use crate::measure::statistics::{Ratio, geometric_mean};

/// Every row, the fastest of each question first; ours with their ratios to the best of the others.
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
    // Writing to a string cannot fail.
    let _ = writeln!(text, "\n{} | {what}{how} | {threads} | {}", row.case, row.unit);
}

fn line(text: &mut String, row: &Row, rows: &[Row]) {
    let robust = if row.robust { "watertight" } else { "" };
    let spread = format!("{:.3} to {:.3}", row.min, row.max);
    let _ = write!(text, "  {:<28} {robust:<10} {:>10.3}  {spread:<22}", row.engine, row.median);
    if row.is_ours() {
        if let Some((name, ratio)) = row.against(rows, |other| row.is_rival(other)) {
            let _ = write!(text, " {} of {name} (like)", times(ratio));
        }
        if let Some((name, ratio)) = row.against(rows, |_| true) {
            let _ = write!(text, " {} of {name} (best)", times(ratio));
        }
    }
    while text.ends_with(' ') {
        text.pop();
    }
    text.push('\n');
}

fn times(ratio: Ratio) -> String {
    format!("{:.2}x [{:.2}]", ratio.mean, ratio.lower)
}

/// Geometric means over the cases of the ratios of ours to the best others: the table that goals are stated in.
pub(crate) fn means(rows: &[Row]) -> String {
    let mut text = String::from("\ngeometric means over the cases: ours over the best of its like | of all\n");
    let mut seen: Vec<&Row> = Vec::new();
    for row in rows.iter().filter(|row| row.is_ours() && !row.times.is_empty()) {
        let key = |row: &Row| (row.engine.clone(), row.metric, row.rays, row.mode, row.threads);
        if seen.iter().any(|other| key(other) == key(row)) {
            continue;
        }
        seen.push(row);
        let alike = |other: &&Row| key(other) == key(row);
        let mean = |who: &dyn Fn(&Row, &Row) -> bool| {
            let ratios = rows.iter().filter(alike).filter_map(|ours| ours.against(rows, |other| who(ours, other)));
            geometric_mean(&ratios.map(|(_, ratio)| ratio.mean).collect::<Vec<_>>())
        };
        let show = |mean: Option<f64>| mean.map_or_else(|| "-".to_owned(), |mean| format!("{mean:.2}x"));
        let what = row.rays.map_or_else(|| format!("{:?}", row.metric).to_lowercase(), |kind| kind.name().to_owned());
        let mode = row.mode.map_or_else(String::new, |mode| format!("{mode:?}").to_lowercase());
        let (like, all) = (mean(&|ours, other| ours.is_rival(other)), mean(&|_, _| true));
        let _ = writeln!(
            text,
            "  {:<16} {what:<17} {mode:<7} {} threads  {:>7} | {:>7}",
            row.engine,
            row.threads,
            show(like),
            show(all)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::row::example;
    use super::*;
    use crate::engine::Class;

    #[test]
    fn ours_stands_with_its_ratios_and_the_fastest_stands_first() {
        let rows = [
            example("embree medium", Class::Fast, false, &[0.5, 0.5]),
            example("kinetree", Class::Fast, true, &[0.25, 0.25]),
            example("embree medium robust", Class::Fast, true, &[1.0, 1.0]),
        ];
        let text = table(&rows);
        let lines: Vec<&str> = text.lines().filter(|line| line.starts_with("  ")).collect();
        assert!(
            lines[0].contains("kinetree") && lines[0].contains("4.00x [4.00] of embree medium robust (like)"),
            "{text}"
        );
        assert!(lines[0].contains("2.00x [2.00] of embree medium (best)"), "{text}");
        assert!(lines[2].contains("embree medium robust"));
        let text = means(&rows);
        assert!(text.contains("4.00x |   2.00x"), "{text}");
    }
}
