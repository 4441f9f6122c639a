//! The chart: bars for single calls on one thread, written as SVG by hand.

use std::fmt::Write as _;

use super::{Metric, Row};
use crate::engine::Mode;

const LEFT: f64 = 190.0;
const WIDTH: f64 = 560.0;
const BAR: f64 = 13.0;

/// One panel per case and kind of rays; a bar per engine with the range of its rounds. Bars of a panel share a scale.
pub(crate) fn chart(rows: &[Row], title: &str) -> String {
    let shown = |row: &&Row| row.metric == Metric::Trace && row.mode == Some(Mode::Single) && row.threads == 1;
    let mut panels: Vec<Vec<&Row>> = Vec::new();
    for row in rows.iter().filter(shown) {
        match panels.iter_mut().find(|panel| panel[0].is_comparable(row)) {
            Some(panel) => panel.push(row),
            None => panels.push(vec![row]),
        }
    }
    let height: f64 = 60.0 + panels.iter().map(|panel| 34.0 + BAR * panel.len() as f64).sum::<f64>();
    let mut svg = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.0}\" height=\"{height:.0}\" font-family=\"sans-serif\" font-size=\"10\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n<text x=\"12\" y=\"24\" font-size=\"15\">{}</text>",
        LEFT + WIDTH + 90.0,
        escaped(title)
    );
    let mut y = 50.0;
    for mut panel in panels {
        panel.sort_by(|a, b| b.median.total_cmp(&a.median));
        let kind = panel[0].rays.map_or("", |kind| kind.name());
        let heading = format!("{}, {kind}: million rays per second, one thread", panel[0].case);
        let _ = writeln!(svg, "<text x=\"12\" y=\"{y:.1}\" font-weight=\"bold\">{}</text>", escaped(&heading));
        let most = panel.iter().map(|row| row.max).fold(f64::MIN_POSITIVE, f64::max);
        y += 6.0;
        for row in panel {
            bar(&mut svg, row, y, WIDTH / most);
            y += BAR;
        }
        y += 28.0;
    }
    svg.push_str("</svg>\n");
    svg
}

fn bar(svg: &mut String, row: &Row, y: f64, scale: f64) {
    let color = match (row.is_ours(), row.robust) {
        (true, _) => "#d1495b",
        (false, true) => "#7a9cc6",
        (false, false) => "#b6bec9",
    };
    let (middle, name) = (y + BAR * 0.5, escaped(&row.engine));
    let [median, min, max] = [row.median, row.min, row.max].map(|value| value * scale);
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{name}</text>\
         <rect x=\"{LEFT}\" y=\"{:.1}\" width=\"{median:.1}\" height=\"{:.1}\" fill=\"{color}\"/>\
         <path d=\"M{:.1} {middle:.1}H{:.1}\" stroke=\"#222222\"/>\
         <text x=\"{:.1}\" y=\"{:.1}\">{:.2}</text>",
        LEFT - 6.0,
        middle + 3.5,
        y + 1.5,
        BAR - 3.0,
        LEFT + min,
        LEFT + max,
        LEFT + max + 5.0,
        middle + 3.5,
        row.median
    );
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::super::row::example;
    use super::*;
    use crate::engine::Class;

    #[test]
    fn every_engine_has_a_bar_and_names_are_escaped() {
        let rows = [example("kinetree", Class::Fast, true, &[0.5]), example("a<b", Class::Fast, false, &[1.0])];
        let svg = chart(&rows, "x & y");
        assert_eq!(svg.matches("<rect x=").count(), 2);
        assert!(svg.contains("a&lt;b") && svg.contains("x &amp; y") && !svg.contains("a<b"));
        assert_eq!(svg.matches("<svg").count(), svg.matches("</svg>").count());
        let width = |name: &str| {
            let bar = &svg[svg.find(&format!(">{name}<")).unwrap()..];
            let start = &bar[bar.find("width=\"").unwrap() + 7..];
            start[..start.find('"').unwrap()].parse::<f64>().unwrap()
        };
        assert!((width("kinetree") - WIDTH).abs() < 0.1 && (width("a&lt;b") - WIDTH / 2.0).abs() < 0.1);
    }
}
