//! The chart: bars for single calls on one thread, as SVG. Its colours follow the reader's choice
//! of a light or dark scheme.

use std::fmt::Write as _;

use super::row::{GROWTH, Metric, Row};
use crate::engine::Mode;
use crate::rays::RayKind;

/// The columns of the chart.
const KINDS: [RayKind; 3] = [RayKind::Primary, RayKind::Diffuse, RayKind::Shadow];
/// Widths of a column's names, bars and numbers, and heights of a bar and of the heading, pixels.
const LEFT: f64 = 150.0;
const WIDTH: f64 = 200.0;
const RIGHT: f64 = 50.0;
const BAR: f64 = 13.0;
const HEAD: f64 = 40.0;

/// Colours for both schemes; bars stand out from either background.
const STYLE: &str = "<style>\
    text { fill: #1f2328 } .ground { fill: #ffffff } .range { stroke: #1f2328 }\
    .ours { fill: #d1495b } .robust { fill: #5f8dc4 } .other { fill: #a3adb9 }\
    @media (prefers-color-scheme: dark) {\
    text { fill: #e6edf3 } .ground { fill: #0d1117 } .range { stroke: #e6edf3 }\
    .ours { fill: #e8697a } .robust { fill: #5783b8 } .other { fill: #6e7781 } }\
    </style>";

/// One panel per case and kind of rays, with a bar per engine and the range of its rounds. The bars
/// of a panel share a scale.
pub(crate) fn chart(rows: &[Row], title: &str) -> String {
    let mut cases: Vec<&str> = Vec::new();
    for row in rows.iter().filter(|row| row.metric == Metric::Trace && !row.case.starts_with(GROWTH)) {
        if !cases.contains(&row.case.as_str()) {
            cases.push(&row.case);
        }
    }
    let panel = |case: &str, kind: RayKind| {
        let shown = |row: &&Row| {
            let single = row.mode == Some(Mode::Single) && row.threads == 1;
            single && row.rays == Some(kind) && row.case == case
        };
        let mut panel: Vec<&Row> = rows.iter().filter(shown).collect();
        panel.sort_by(|a, b| b.median.total_cmp(&a.median));
        panel
    };
    let column = LEFT + WIDTH + RIGHT;
    let (mut body, mut y) = (String::new(), 64.0);
    for case in cases {
        let panels = KINDS.map(|kind| (kind, panel(case, kind)));
        for (at, (kind, panel)) in panels.iter().enumerate() {
            draw(&mut body, &format!("{case}, {}", kind.name()), panel, at as f64 * column + 10.0, y);
        }
        y += HEAD + BAR * panels.iter().map(|(_, panel)| panel.len()).max().unwrap_or(0) as f64;
    }
    let width = column * KINDS.len() as f64 + 20.0;
    let title = escaped(title);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {y:.0}\" width=\"{width:.0}\" height=\"{y:.0}\" \
         font-family=\"sans-serif\" font-size=\"10\">\n{STYLE}\n<rect class=\"ground\" width=\"100%\" height=\"100%\"/>\n\
         <text x=\"12\" y=\"24\" font-size=\"15\">{title}</text>\n\
         <text x=\"12\" y=\"42\">million rays per second, single calls, one thread: median and range of the rounds; \
         red: kinetree, blue: others that are watertight, grey: others that are not</text>\n{body}</svg>\n"
    )
}

fn draw(svg: &mut String, heading: &str, panel: &[&Row], x: f64, y: f64) {
    if panel.is_empty() {
        return;
    }
    // Writing to a string cannot fail.
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" font-weight=\"bold\">{}</text>", escaped(heading));
    let most = panel.iter().map(|row| row.max).fold(f64::MIN_POSITIVE, f64::max);
    for (at, row) in panel.iter().enumerate() {
        bar(svg, row, x + LEFT, y + 6.0 + BAR * at as f64, WIDTH / most);
    }
}

fn bar(svg: &mut String, row: &Row, x: f64, y: f64, scale: f64) {
    let class = match (row.is_kinetree(), row.robust) {
        (true, _) => "ours",
        (false, true) => "robust",
        (false, false) => "other",
    };
    let (middle, name) = (y + BAR * 0.5, escaped(&row.engine));
    let [median, min, max] = [row.median, row.min, row.max].map(|value| value * scale);
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{name}</text>\
         <rect class=\"{class}\" x=\"{x:.1}\" y=\"{:.1}\" width=\"{median:.1}\" height=\"{:.1}\"/>\
         <path class=\"range\" d=\"M{:.1} {middle:.1}H{:.1}\"/>\
         <text x=\"{:.1}\" y=\"{:.1}\">{:.2}</text>",
        x - 6.0,
        middle + 3.5,
        y + 1.5,
        BAR - 3.0,
        x + min,
        x + max,
        x + max + 5.0,
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
        assert_eq!(svg.matches(" x=\"160.0\" y=").count(), 2, "{svg}");
        assert!(svg.contains("a&lt;b") && svg.contains("x &amp; y") && !svg.contains("a<b"));
        assert_eq!(svg.matches("<svg").count(), svg.matches("</svg>").count());
        let width = |name: &str| {
            let bar = &svg[svg.find(&format!(">{name}<")).unwrap()..];
            let start = &bar[bar.find("width=\"").unwrap() + 7..];
            start[..start.find('"').unwrap()].parse::<f64>().unwrap()
        };
        assert!((width("kinetree") - WIDTH).abs() < 0.1 && (width("a&lt;b") - WIDTH / 2.0).abs() < 0.1);
    }

    #[test]
    fn both_schemes_set_text_and_background() {
        let (light, dark) = STYLE.split_once("@media").unwrap();
        for style in [light, dark] {
            assert!(style.contains("text { fill") && style.contains(".ground { fill"));
        }
        assert!(!chart(&[], "").contains("NaN"));
    }
}
