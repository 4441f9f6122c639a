//! A goal: the measured ratios case by case, and whether it is reached.

use std::fmt::Write as _;

use crate::measure::statistics::{LogRatios, Ratio};

/// The cases over which the geometric mean is taken.
pub(crate) const COUNTED: [&str; 5] =
    ["race_black_forest", "kitchen_country", "stanford_bunny", "teapot_in_stadium_a", "race"];

/// What a ratio must reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Target {
    /// The lower bound must reach the first number; the second is the aim.
    AtLeast(f64, f64),
    /// The upper bound must not exceed the first number; the second is the aim.
    AtMost(f64, f64),
    /// No target: shown for comparison.
    Shown,
}

/// The ratio of one case.
#[derive(Debug, Clone)]
pub(crate) struct CaseRatio {
    /// The name of the case.
    pub(crate) case: String,
    /// The rival, and further remarks.
    pub(crate) note: String,
    /// The measured ratio.
    pub(crate) log_ratios: LogRatios,
}

/// A goal with the measured ratios.
#[derive(Debug, Clone)]
pub(crate) struct Goal {
    /// A description of what is compared.
    pub(crate) what: String,
    /// What must be reached.
    pub(crate) target: Target,
    /// The ratios, case by case.
    pub(crate) found: Vec<CaseRatio>,
    /// Whether every case must reach the target, instead of the mean over the counted cases.
    pub(crate) alone: bool,
}

impl Goal {
    /// Whether the target is reached; `None` without a measurement or a target.
    fn reached(&self, ratio: Option<Ratio>) -> Option<bool> {
        let ratio = ratio?;
        let (lower, upper) = ratio.bounds.unwrap_or((ratio.mean, ratio.mean));
        match self.target {
            Target::AtLeast(must, _) => Some(lower >= must),
            Target::AtMost(must, _) => Some(upper <= must),
            Target::Shown => None,
        }
    }

    /// Appends the goal, its mean and its cases.
    pub(crate) fn write(&self, text: &mut String) {
        let (must, aim) = match self.target {
            Target::AtLeast(must, aim) => (format!("must {must:.2}"), format!(", aim {aim:.2}")),
            Target::AtMost(must, aim) => (format!("at most {must:.2}"), format!(", aim {aim:.2}")),
            Target::Shown => (String::from("for comparison"), String::new()),
        };
        let counted: Vec<&CaseRatio> =
            self.found.iter().filter(|found| COUNTED.contains(&found.case.as_str())).collect();
        let mean = if self.alone {
            None
        } else {
            LogRatios::mean_of(&counted.iter().map(|found| &found.log_ratios).collect::<Vec<_>>()).ratio()
        };
        let reached = if self.alone {
            let all: Vec<bool> = self.found.iter().filter_map(|found| self.reached(found.log_ratios.ratio())).collect();
            (!all.is_empty()).then(|| all.iter().all(|reached| *reached))
        } else {
            self.reached(mean)
        };
        let outcome = match (reached, self.found.is_empty()) {
            (Some(true), _) => "reached",
            (Some(false), _) => "SHORT",
            (None, true) => "not measured",
            (None, false) => "",
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{} ({must}{aim}) {outcome}", self.what);
        if let Some(mean) = mean {
            let _ = writeln!(
                text,
                "    {:<22} {}  over {} of {} scenes",
                "GEOMETRIC MEAN",
                show(mean),
                counted.len(),
                COUNTED.len()
            );
        }
        for found in &self.found {
            let counts = self.alone || COUNTED.contains(&found.case.as_str());
            let Some(ratio) = found.log_ratios.ratio() else { continue };
            let aside = if counts { "" } else { "  (not counted)" };
            let _ = writeln!(text, "    {:<22} {}  {}{aside}", found.case, show(ratio), found.note);
        }
    }
}

/// Such as `1.10x [1.08, 1.12]`.
pub(crate) fn show(ratio: Ratio) -> String {
    let bounds = ratio.bounds.map_or_else(|| "[-]".to_owned(), |(lower, upper)| format!("[{lower:.2}, {upper:.2}]"));
    format!("{:.2}x {bounds}", ratio.mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn goal(target: Target, ratios: [f64; 3], alone: bool) -> String {
        let cases = ["race", "kitchen_country", "other"];
        let found = |(case, ratio): (&str, f64)| CaseRatio {
            case: case.to_owned(),
            note: "of a rival".to_owned(),
            log_ratios: LogRatios::of_processes([ratio * 0.999, ratio, ratio * 1.001]),
        };
        let found = cases.into_iter().zip(ratios).map(found).collect();
        let mut text = String::new();
        Goal { what: "rays".into(), target, found, alone }.write(&mut text);
        text
    }

    #[test]
    fn the_mean_over_counted_cases_decides_and_others_are_shown() {
        let text = goal(Target::AtLeast(1.1, 1.3), [1.0, 1.44, 0.1], false);
        assert!(text.contains("reached") && text.contains("1.20x") && text.contains("(not counted)"), "{text}");
        assert!(goal(Target::AtLeast(1.1, 1.3), [1.0, 1.2, 9.0], false).contains("SHORT"));
        assert!(goal(Target::AtLeast(1.1, 1.3), [1.2, 1.2, 1.0], true).contains("SHORT"));
        assert!(goal(Target::AtMost(1.3, 1.1), [1.2, 1.2, 9.0], false).contains("reached"));
    }

    #[test]
    fn the_bound_counts_and_not_the_mean() {
        let found = vec![CaseRatio {
            case: "race".into(),
            note: String::new(),
            log_ratios: LogRatios::of_processes([1.0, 1.1, 1.3]),
        }];
        let mut text = String::new();
        Goal { what: "rays".into(), target: Target::AtLeast(1.1, 1.3), found, alone: false }.write(&mut text);
        assert!(text.contains("SHORT") && text.contains("1.13x"), "{text}");
    }
}
