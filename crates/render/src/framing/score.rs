//! The score of a camera that shows the region of interest.

use super::region::Region;
use super::view_statistics::{ViewStatistics, is_visible};
use kinetree_world::{Camera, CameraProjection, Frame};

/// The part of the picture that should show the region; more is not better.
const ENOUGH: f32 = 0.55;
/// The part of the region's points that can be visible at once; the others are on the far side.
const MAX_VISIBLE: f32 = 0.5;

/// How well a camera shows a region.
#[derive(Debug, Clone, Copy)]
pub(super) struct Score {
    /// Larger is better; never negative.
    pub(super) value: f32,
    /// The part of the region's points that are visible.
    pub(super) shown: f32,
}

/// The score of a camera.
pub(super) fn score(frame: &Frame, region: &Region, camera: &Camera, aspect: f32) -> Score {
    let projection = CameraProjection::new(camera, aspect);
    let shown =
        region.points().iter().filter(|&&point| projection.contains(point) && is_visible(frame, camera, point)).count();
    let shown = shown as f32 / region.points().len().max(1) as f32;
    let statistics = ViewStatistics::sample(frame, camera, aspect, region.radius());
    let seen = (statistics.part_within(|position| region.contains(position)) / ENOUGH).min(1.0);
    let clear = statistics.clearance() * statistics.front_facing();
    let value = seen * (0.1 + (shown / MAX_VISIBLE).min(1.0)) * (0.1 + statistics.variety()) * clear * clear;
    Score { value, shown }
}
