//! A scene with materials, lights, cameras and an animation.

use std::sync::Arc;

use kinetree::{Affine, EditError, NodeId, Scene};

use crate::{Animation, Camera, Frame, Light, MaterialBindings, MaterialSet, NoAnimation, Sky};

/// A scene with materials, lights, cameras and an animation, which gives a [`Frame`] for any time.
#[non_exhaustive]
pub struct World {
    /// The geometry, which `animation` edits.
    pub scene: Scene,
    /// Materials and textures.
    pub material_set: Arc<MaterialSet>,
    /// Which surface of `material_set` each instance of `scene` has.
    pub material_bindings: MaterialBindings,
    /// Lights that are not surfaces.
    pub lights: Vec<LightSource>,
    /// The sky.
    pub sky: Sky,
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
    /// A world without materials, lights, cameras and animation.
    pub fn new(scene: Scene) -> Self {
        Self {
            scene,
            material_set: Arc::default(),
            material_bindings: MaterialBindings::default(),
            lights: Vec::new(),
            sky: Sky::default(),
            cameras: Vec::new(),
            animation: Box::new(NoAnimation),
        }
    }

    /// Brings the scene to a time, in seconds, commits it, and returns the frame.
    ///
    /// # Errors
    /// An edit of the animation that the scene refused; a light whose node has been removed.
    pub fn frame(&mut self, seconds: f64) -> Result<Frame, EditError> {
        self.animation.go_to(&mut self.scene, seconds)?;
        let lights = self
            .lights
            .iter()
            .map(|source| Ok(source.light.placed(&self.placement(source.node)?)))
            .collect::<Result<_, EditError>>()?;
        let frame = Frame::new(self.scene.commit());
        let mut frame = frame.with_materials(self.material_set.clone(), &mut self.material_bindings);
        (frame.lights, frame.sky, frame.time) = (lights, self.sky, seconds);
        Ok(frame)
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
