//! A scene with materials, lights, cameras and an animation.

use std::sync::Arc;

use kinetree::{Affine, EditError, NodeId, Scene};

use crate::{Animation, Camera, Frame, Light, MaterialSet};

/// A scene with materials, lights, cameras and an animation, which gives a [`Frame`] for any time.
pub struct World {
    /// The geometry, which `animation` edits.
    pub scene: Scene,
    /// Materials and textures. The user id of an instance is an index into [`MaterialSet::surfaces`].
    pub material_set: Arc<MaterialSet>,
    /// Lights that are not surfaces.
    pub lights: Vec<LightSource>,
    /// Cameras; the first is the default.
    pub cameras: Vec<CameraSource>,
    /// What moves the scene.
    pub animation: Box<dyn Animation>,
}

/// A light, attached to a node or fixed in world space.
#[derive(Debug, Clone, Copy)]
pub struct LightSource {
    /// The node, or `None` for world space.
    pub node: Option<NodeId>,
    /// The light in the space of the node.
    pub light: Light,
}

/// A named camera, attached to a node or fixed in world space.
#[derive(Debug, Clone)]
pub struct CameraSource {
    /// May be empty. Of cameras with the same name, a lookup by name gives the first.
    pub name: String,
    /// The node, or `None` for world space.
    pub node: Option<NodeId>,
    /// The camera in the space of the node.
    pub camera: Camera,
}

impl World {
    /// Brings the scene to a time, in seconds, commits it, and returns the frame.
    ///
    /// # Errors
    /// An edit of the animation that the scene refused.
    pub fn frame(&mut self, seconds: f64) -> Result<Frame, EditError> {
        self.animation.go_to(&mut self.scene, seconds)?;
        let lights = self
            .lights
            .iter()
            .map(|source| Ok(source.light.placed(&self.placement(source.node)?)))
            .collect::<Result<_, EditError>>()?;
        Ok(Frame { view: self.scene.commit(), material_set: self.material_set.clone(), lights, time: seconds })
    }

    /// A camera in world space at the time of the latest frame.
    ///
    /// # Errors
    /// The camera's node has been removed.
    pub fn camera(&self, source: &CameraSource) -> Result<Camera, EditError> {
        let world_from_node = self.placement(source.node)?;
        Ok(Camera { world_from_camera: world_from_node * source.camera.world_from_camera, ..source.camera })
    }

    fn placement(&self, node: Option<NodeId>) -> Result<Affine, EditError> {
        node.map_or(Ok(Affine::IDENTITY), |node| self.scene.world_from_node(node))
    }
}
