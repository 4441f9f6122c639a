//! Decides whether to keep, refit or rebuild a mesh's tree, from the edits and the expected cost of
//! rays, never from measured times: the same edits give the same trees.
//!
//! A rise of the estimated drift means that a refitted tree has degraded. The estimate is relative
//! to a baseline, the cost in a pose in which the tree was good, and the baseline may be wrong: a
//! tree that was built over a point, a line or a crumpled pose never was good. So a cost far below
//! the baseline, and the first refit after a build, also count as doubt. In doubt, a new tree is
//! built, the costs of both in the same pose are compared, and the better one is kept: a false
//! alarm costs one build.

use super::quality::estimated_drift;
use super::{Action, Motion, Reason};
use crate::wide::RayCost;

/// What happened to a mesh since the last commit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Edit {
    Nothing,
    Positions,
    Triangles,
}

/// The input of [`decide`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeshUpdate {
    pub(crate) motion: Motion,
    pub(crate) edit: Edit,
    pub(crate) has_tree: bool,
    /// Whether the caller asked for a new tree.
    pub(crate) rebuild: bool,
    /// Whether the tree was built with a lower quality than the mesh is to have now.
    pub(crate) is_below_quality: bool,
}

/// What to do with a mesh before any cost is measured.
pub(crate) fn decide(update: &MeshUpdate) -> (Action, Reason) {
    match (update.edit, update.motion) {
        _ if !update.has_tree => (Action::Built, Reason::New),
        (Edit::Triangles, _) => (Action::Rebuilt, Reason::TrianglesChanged),
        _ if update.rebuild => (Action::Rebuilt, Reason::Requested),
        _ if update.is_below_quality => (Action::Rebuilt, Reason::QualityRaised),
        (Edit::Nothing, _) => (Action::Kept, Reason::NothingChanged),
        (Edit::Positions, Motion::Deforming) => (Action::Refitted, Reason::PositionsMoved),
        (Edit::Positions, _) => (Action::Rebuilt, Reason::NotMadeForRefit),
    }
}

/// A tree is compared with a new one at once if its estimated drift exceeds this, or if the plain
/// ratio of its costs does. The plain ratio catches what the estimate misses when scattered
/// triangles come together to a smooth surface: they overlap more and yet cost less.
///
/// Measured in the motions of `tests/drift.rs`: the mean work of rays in a frame is up to 1.2 times
/// that in fresh trees; with 1.5, up to 1.5 times.
const DEGRADED_ABOVE: f64 = 1.25;

/// The baseline of a tree whose estimated drift falls below this is doubtful.
const DOUBTFUL_BELOW: f64 = 0.8;

/// The new tree is kept if its cost is less than this fraction of the refitted tree's.
const WORTH_REPLACING: f64 = 0.95;

/// Poses whose costs differ by less than this ratio count as the same pose, for which the
/// comparison would have the same outcome.
const SAME_POSE: f64 = 1.01;

/// The largest number of refits between two comparisons: of a tree whose baseline is doubtful, and
/// of any other.
const LONGEST_WAIT_IN_DOUBT: u32 = 64;
const LONGEST_WAIT: u32 = 256;

/// The history of a tree since its build, from which comparisons are scheduled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Upkeep {
    /// The cost of rays when the tree was last known to be good; `None` if that pose had no area.
    baseline: Option<RayCost>,
    /// Whether the tree has been compared with a new one since its build.
    compared: bool,
    /// Refits since the last build or comparison, of poses with area.
    refits: u32,
    /// The number of refits after which the next comparison is due without a rise of the cost.
    wait: u32,
}

/// Why a tree must be compared with a new one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Doubt {
    /// The estimated drift is too large.
    Degraded,
    /// The baseline of the estimate may be wrong.
    Baseline,
}

impl Upkeep {
    /// For a tree that was built in a pose of this cost.
    pub(crate) fn of_build(built: Option<RayCost>) -> Self {
        Self { baseline: built, compared: false, refits: 0, wait: 1 }
    }

    /// Records the cost after a refit. Returns the estimated drift, if there is a baseline, and the
    /// reason to build a tree for comparison, if there is one.
    pub(crate) fn refitted(&mut self, now: &RayCost) -> (Option<f64>, Option<Doubt>) {
        self.refits = self.refits.saturating_add(1);
        let Some(baseline) = &self.baseline else { return (None, Some(Doubt::Baseline)) };
        let drift = estimated_drift(now, baseline);
        let in_doubt =
            drift < DOUBTFUL_BELOW && (!self.compared || self.refits >= self.wait.min(LONGEST_WAIT_IN_DOUBT));
        let is_due = self.refits >= self.wait && !is_same_pose(now, baseline);
        let doubt = if drift > DEGRADED_ABOVE {
            Some(Doubt::Degraded)
        } else {
            let is_costlier = now.work > DEGRADED_ABOVE * baseline.work;
            (is_costlier || in_doubt || is_due).then_some(Doubt::Baseline)
        };
        (Some(drift), doubt)
    }

    /// Records the comparison of two trees in the same pose. Returns `true` if the new tree must
    /// replace the refitted one; otherwise the refitted tree is as good, and its cost becomes the
    /// baseline.
    pub(crate) fn compared(&mut self, refitted: &RayCost, new: Option<&RayCost>) -> bool {
        let better = new.filter(|new| new.work < WORTH_REPLACING * refitted.work);
        self.wait = match better {
            // When the new tree will have degraded too far, at the rate of the old one.
            Some(new) => {
                let loss = (refitted.work / new.work - 1.0) / f64::from(self.refits.max(1));
                ((DEGRADED_ABOVE - 1.0) / loss).clamp(1.0, f64::from(LONGEST_WAIT)) as u32
            }
            None => (2 * self.wait).min(LONGEST_WAIT),
        };
        self.baseline = Some(*better.unwrap_or(refitted));
        self.compared = better.is_none();
        self.refits = 0;
        better.is_some()
    }
}

fn is_same_pose(one: &RayCost, other: &RayCost) -> bool {
    let near = |a: f64, b: f64| a < b * SAME_POSE && b < a * SAME_POSE;
    near(one.work, other.work) && near(one.crossed, other.crossed)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOTIONS: [Motion; 4] = [Motion::Static, Motion::Rigid, Motion::Deforming, Motion::Dynamic];

    #[test]
    fn what_bends_is_refitted_and_what_changes_is_rebuilt() {
        use {Action::*, Edit::*, Reason::*};
        for motion in MOTIONS {
            let decide = |edit, has_tree, rebuild, is_below_quality| {
                decide(&MeshUpdate { motion, edit, has_tree, rebuild, is_below_quality })
            };
            for (rebuild, is_below) in [(false, false), (false, true), (true, false), (true, true)] {
                for edit in [Nothing, Positions, Triangles] {
                    assert_eq!(decide(edit, false, rebuild, is_below), (Built, New));
                }
                assert_eq!(decide(Triangles, true, rebuild, is_below), (Rebuilt, TrianglesChanged));
            }
            for edit in [Nothing, Positions] {
                assert_eq!(decide(edit, true, true, false), (Rebuilt, Requested));
                assert_eq!(decide(edit, true, true, true), (Rebuilt, Requested));
                assert_eq!(decide(edit, true, false, true), (Rebuilt, QualityRaised));
            }
            assert_eq!(decide(Nothing, true, false, false), (Kept, NothingChanged));
            let moved =
                if motion == Motion::Deforming { (Refitted, PositionsMoved) } else { (Rebuilt, NotMadeForRefit) };
            assert_eq!(decide(Positions, true, false, false), moved, "{motion:?}");
        }
    }

    fn cost(work: f64, crossed: f64) -> RayCost {
        RayCost { work, crossed }
    }

    /// A tree of cost 20 whose comparison at the first refit found nothing better.
    fn settled() -> Upkeep {
        let mut upkeep = Upkeep::of_build(Some(cost(19.0, 3.0)));
        assert_eq!(upkeep.refitted(&cost(20.0, 3.0)).1, Some(Doubt::Baseline));
        assert!(!upkeep.compared(&cost(20.0, 3.0), Some(&cost(20.0, 3.0))));
        upkeep
    }

    #[test]
    fn the_first_refit_after_a_build_is_a_reason_to_compare_unless_the_pose_is_the_same() {
        let mut upkeep = Upkeep::of_build(Some(cost(20.0, 3.0)));
        assert_eq!(upkeep.refitted(&cost(20.1, 3.01)).1, None);
        assert_eq!(upkeep.refitted(&cost(20.5, 3.0)).1, Some(Doubt::Baseline));
        let mut upkeep = Upkeep::of_build(Some(cost(20.0, 3.0)));
        assert_eq!(upkeep.refitted(&cost(20.0, 2.9)).1, Some(Doubt::Baseline));
    }

    #[test]
    fn without_a_baseline_there_is_no_drift_but_a_comparison() {
        let mut upkeep = Upkeep::of_build(None);
        assert_eq!(upkeep.refitted(&cost(900.0, 3.0)), (None, Some(Doubt::Baseline)));
        assert!(upkeep.compared(&cost(900.0, 3.0), Some(&cost(20.0, 3.0))));
        assert_eq!(upkeep.refitted(&cost(20.0, 3.0)), (Some(1.0), None));
    }

    #[test]
    fn a_rise_is_compared_at_once_and_a_false_alarm_becomes_the_baseline() {
        let mut upkeep = settled();
        assert_eq!(upkeep.refitted(&cost(24.9, 3.0)).1, None);
        assert_eq!(upkeep.refitted(&cost(25.1, 3.0)).1, Some(Doubt::Degraded));
        assert!(!upkeep.compared(&cost(25.1, 3.0), Some(&cost(24.0, 3.0))));
        assert_eq!(upkeep.refitted(&cost(25.1, 3.0)), (Some(1.0), None));
        // Triangles come together: the estimate falls, the cost rises.
        let mut upkeep = settled();
        let (drift, doubt) = upkeep.refitted(&cost(25.1, 9.0));
        assert_eq!((drift.map(|drift| drift < 1.0), doubt), (Some(true), Some(Doubt::Baseline)));
        // Triangles move apart: the estimate rises, the cost does not.
        assert_eq!(settled().refitted(&cost(20.0, 1.0)).1, Some(Doubt::Degraded));
    }

    #[test]
    fn a_new_tree_is_kept_if_it_is_better_by_a_twentieth() {
        for (new, is_kept) in [(22.0, false), (20.0, false), (19.1, false), (18.9, true), (4.0, true)] {
            let mut upkeep = settled();
            assert_eq!(upkeep.compared(&cost(20.0, 3.0), Some(&cost(new, 3.0))), is_kept, "{new}");
            let good = if is_kept { new } else { 20.0 };
            assert_eq!(upkeep.refitted(&cost(good, 3.0)).0, Some(1.0));
        }
        assert!(!settled().compared(&cost(20.0, 3.0), None));
    }

    /// The numbers of refits between comparisons that find nothing better, while the cost changes
    /// by the same ratio in each refit.
    fn waits(ratio: f64, refits: usize) -> Vec<usize> {
        let mut upkeep = Upkeep::of_build(Some(cost(1e9, 3.0)));
        let (mut work, mut last, mut waits) = (1e9, 0, Vec::new());
        for refit in 1..=refits {
            work *= ratio;
            if upkeep.refitted(&cost(work, 3.0)).1.is_some() {
                assert!(!upkeep.compared(&cost(work, 3.0), Some(&cost(work, 3.0))));
                waits.push(refit - last);
                last = refit;
            }
        }
        waits
    }

    #[test]
    fn comparisons_in_vain_become_rarer() {
        assert_eq!(waits(0.9, 400), [1, 2, 4, 8, 16, 32, 64, 64, 64, 64, 64]);
        assert_eq!(waits(1.0002, 900), [50, 50, 50, 50, 50, 50, 64, 128, 256]);
        assert!(waits(1.0, 900).is_empty());
        assert_eq!(waits(2.0, 20), [1; 20]);
    }

    #[test]
    fn a_tree_that_degrades_is_compared_again_when_it_would_cost_too_much() {
        // Refits before the comparison, the ratio of costs it found, and the refits until a quarter
        // would be lost.
        for (refits, ratio, expected) in [(1, 1.06, 4), (3, 1.06, 12), (1, 1.3, 1), (600, 1.06, 256)] {
            let mut upkeep = Upkeep { refits, ..settled() };
            assert!(upkeep.compared(&cost(20.0 * ratio, 3.0), Some(&cost(20.0, 3.0))));
            for refit in 1..=expected {
                // A different pose of nearly the same cost, so that only the schedule asks for a
                // comparison.
                let doubt = upkeep.refitted(&cost(20.5, 3.0)).1;
                assert_eq!(doubt.is_some(), refit == expected, "{refits}, {ratio}, {refit}");
            }
        }
    }
}
