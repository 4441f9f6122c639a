//! A scene with materials, lights, cameras and an animation.

use std::fmt;
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

/// Prints sizes, not contents.
impl fmt::Debug for World {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("World")
            .field("scene", &self.scene)
            .field("lights", &self.lights.len())
            .field("cameras", &self.cameras.len())
            .field("duration", &self.animation.duration())
            .finish_non_exhaustive()
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Moves a node one metre along x per second.
    struct Drive(NodeId);

    impl Animation for Drive {
        fn go_to(&mut self, scene: &mut Scene, seconds: f64) -> Result<(), EditError> {
            scene.place(self.0, Affine::from_translation([seconds as f32, 0.0, 0.0]))
        }

        fn duration(&self) -> f64 {
            10.0
        }
    }

    #[test]
    fn lights_and_cameras_follow_their_nodes_and_frames_stay_as_they_are() {
        let mut scene = Scene::new();
        let node = scene.add_node(scene.root(), Affine::IDENTITY).expect("a node fits");
        let mut world = World::new(scene);
        let lamp = Light::Point { position: [0.0, 1.0, 0.0], intensity: [1.0; 3], range: f32::INFINITY };
        world.lights = [Some(node), None].map(|node| LightSource { node, light: lamp }).to_vec();
        world.sky = Sky::Constant([2.0; 3]);
        let camera = Camera::look_at([0.0, 0.0, 5.0], [0.0; 3], 0.8);
        world.cameras.push(CameraSource { name: "on board".into(), node: Some(node), camera });
        world.animation = Box::new(Drive(node));

        let at = |x: f32| Light::Point { position: [x, 1.0, 0.0], intensity: [1.0; 3], range: f32::INFINITY };
        let first = world.frame(1.5).expect("the node is there");
        assert_eq!(world.camera(&world.cameras[0]).map(|camera| camera.position()), Ok([1.5, 0.0, 5.0]));
        let second = world.frame(4.0).expect("the node is there");
        assert_eq!((first.lights, first.sky, first.time), (vec![at(1.5), at(0.0)], Sky::Constant([2.0; 3]), 1.5));
        assert_eq!((second.lights, second.time), (vec![at(4.0), at(0.0)], 4.0));

        world.animation = Box::new(NoAnimation);
        world.scene.remove_node(node).expect("the node is there");
        assert!(world.frame(0.0).is_err() && world.camera(&world.cameras[0]).is_err());
    }
}
