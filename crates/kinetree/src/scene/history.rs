//! What a scene keeps from commit to commit.

use std::sync::Arc;

use super::frame::Frame;
use super::hierarchy_cache::HierarchyCache;
use super::published::Publisher;
use crate::traverse::MeshFrame;

/// Frames that can be written again, and what the next frame takes over from the last.
#[derive(Debug, Default)]
pub(crate) struct History {
    pub(super) frames: Publisher<Frame>,
    pub(super) hierarchy: HierarchyCache,
    /// How many commits there were.
    pub(super) count: u64,
    /// Stands in the slot of a mesh that was removed.
    pub(super) nothing: Arc<MeshFrame>,
}
