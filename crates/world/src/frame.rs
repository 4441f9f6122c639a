//! A world at one time.

use std::sync::Arc;

use kinetree::Snapshot;

use crate::{Light, MaterialSet};

/// A world at one time: all that a renderer needs. It borrows nothing, and does not change.
#[derive(Clone)]
pub struct Frame {
    /// The geometry.
    pub view: Snapshot,
    /// Materials and textures.
    pub material_set: Arc<MaterialSet>,
    /// The lights that are not surfaces, world space.
    pub lights: Vec<Light>,
    /// Seconds.
    pub time: f64,
}
