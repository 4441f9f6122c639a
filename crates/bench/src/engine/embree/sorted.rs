//! Single calls on rays that were sorted as kinetree sorts them.

use std::sync::Arc;

use kinetree::{Aabb, Coherence};

use super::api::{Api, Handle};
use super::single::{closest, occluded};
use crate::engine::interface::{Batch, Mode};
use crate::engine::sorted;
use crate::ray::{Answer, Ray};

/// The scene, and the bounds that rays are sorted in.
pub(super) struct Sorted {
    pub(super) api: Arc<Api>,
    /// The scene is owned by the tree that owns this value.
    pub(super) scene: Handle,
    pub(super) bounds: Aabb,
}

// SAFETY: a committed scene may be traced from all threads.
unsafe impl Send for Sorted {}
// SAFETY: as above.
unsafe impl Sync for Sorted {}

impl Batch for Sorted {
    fn suffix(&self) -> &'static str {
        "sorted"
    }

    fn mode(&self) -> Mode {
        Mode::Batch
    }

    fn suits(&self, coherence: Coherence) -> bool {
        coherence == Coherence::Incoherent
    }

    fn closest(&self, rays: &[Ray], answers: &mut [Answer], _: Coherence) {
        sorted::closest(self.bounds, rays, answers, |rays, answers| closest(&self.api, self.scene, rays, answers));
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool], _: Coherence) {
        sorted::occluded(self.bounds, rays, answers, |rays, answers| occluded(&self.api, self.scene, rays, answers));
    }
}
