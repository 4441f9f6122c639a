//! How good a camera is at showing a region.

use super::region::Region;
use super::view_statistics::{ViewStatistics, is_visible};
use kinetree_world::{Camera, CameraProjection, Frame};

/// The part of the picture that should show the region; more is no better.
const ENOUGH: f32 = 0.55;
/// The part of the region's places that can be seen at once; the others are on the far side.
const MOST_SHOWN: f32 = 0.5;

/// What a camera is worth.
#[derive(Debug, Clone, Copy)]
pub(super) struct Score {
    /// Larger is better, none is negative.
    pub(super) value: f32,
    /// The part of the region's places that is seen.
    pub(super) shown: f32,
}

/// The score of a camera.
pub(super) fn score(frame: &Frame, region: &Region, camera: &Camera, aspect: f32) -> Score {
    let projection = CameraProjection::new(camera, aspect);
    let shown =
        region.places().iter().filter(|&&place| projection.contains(place) && is_visible(frame, camera, place)).count();
    let shown = shown as f32 / region.places().len().max(1) as f32;
    let statistics = ViewStatistics::sample(frame, camera, aspect, region.radius());
    let seen = (statistics.part_within(|position| region.contains(position)) / ENOUGH).min(1.0);
    let clear = statistics.clearance() * statistics.front_facing();
    let value = seen * (0.1 + (shown / MOST_SHOWN).min(1.0)) * (0.1 + statistics.variety()) * clear * clear;
    Score { value, shown }
}
