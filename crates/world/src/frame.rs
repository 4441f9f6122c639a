//! A world at one time.

use std::fmt;
use std::sync::Arc;

use kinetree::Snapshot;

use crate::material_bindings::UNBOUND;
use crate::{Light, MaterialBindings, MaterialSet, Sky, Surface};

/// A world at one time: all that a renderer needs. It borrows nothing, and does not change.
#[derive(Clone)]
pub struct Frame {
    /// The geometry.
    pub snapshot: Snapshot,
    /// Materials and textures.
    pub material_set: Arc<MaterialSet>,
    /// The lights that are not surfaces, world space.
    pub lights: Vec<Light>,
    /// The sky.
    pub sky: Sky,
    /// Seconds.
    pub time: f64,
    /// Index into the surfaces of `material_set` for each instance, by its dense index.
    surfaces: Arc<[u32]>,
}

/// Prints sizes, not contents.
impl fmt::Debug for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Frame")
            .field("snapshot", &self.snapshot)
            .field("lights", &self.lights.len())
            .field("sky", &self.sky)
            .field("time", &self.time)
            .finish_non_exhaustive()
    }
}

impl Frame {
    /// A frame at time 0 without lights, under a black sky, whose instances have the default
    /// material.
    pub fn new(snapshot: Snapshot) -> Self {
        Self {
            snapshot,
            material_set: Arc::default(),
            lights: Vec::new(),
            sky: Sky::default(),
            time: 0.0,
            surfaces: Arc::default(),
        }
    }

    /// Gives the instances of the frame the surfaces that they are bound to.
    #[must_use]
    pub fn with_materials(mut self, material_set: Arc<MaterialSet>, bindings: &mut MaterialBindings) -> Self {
        self.surfaces = bindings.resolve(&self.snapshot);
        self.material_set = material_set;
        self
    }

    /// The surface of the instance with a dense index, [`InstanceView::index`]; `None` for one that
    /// has none, whose triangles have the default material.
    ///
    /// [`InstanceView::index`]: kinetree::InstanceView::index
    #[inline]
    pub fn surface(&self, instance: u32) -> Option<&Surface> {
        self.material_set.surfaces.get(self.surface_index(instance)? as usize)
    }

    /// As [`Frame::surface`], the index into [`MaterialSet::surfaces`] that the instance is bound
    /// to.
    #[inline]
    pub fn surface_index(&self, instance: u32) -> Option<u32> {
        self.surfaces.get(instance as usize).copied().filter(|&surface| surface != UNBOUND)
    }
}
