//! A scene with all that belongs to it: what it looks like, what lights it, who looks at it, and
//! how it moves.

use std::sync::Arc;

use kinetree::{Affine, EditError, NodeId, Scene, Snapshot};

use crate::{Camera, Light, MaterialSet};

/// A scene that can be asked for a frame at any time.
pub struct World {
    /// The geometry, which `animation` edits.
    pub scene: Scene,
    /// What it looks like. The user id of an instance is an index into [`MaterialSet::surfaces`].
    pub material_set: Arc<MaterialSet>,
    /// Lights that are no surfaces.
    pub lights: Vec<LightSource>,
    /// In the order of the file; the first is the default.
    pub cameras: Vec<CameraSource>,
    /// How it moves.
    pub animation: Box<dyn Animation>,
}

/// What changes a scene from frame to frame.
pub trait Animation: Send {
    /// Records the edits that bring the scene to a time. Called with times in any order.
    ///
    /// # Errors
    /// An edit that the scene refused; what was edited before stays edited.
    fn go_to(&mut self, scene: &mut Scene, seconds: f64) -> Result<(), EditError>;

    /// Seconds after which the animation begins again; 0 when nothing moves.
    fn duration(&self) -> f64;
}

/// Nothing moves.
pub struct NoAnimation;

impl Animation for NoAnimation {
    fn go_to(&mut self, _: &mut Scene, _: f64) -> Result<(), EditError> {
        Ok(())
    }

    fn duration(&self) -> f64 {
        0.0
    }
}

/// A light, and the node it hangs on.
#[derive(Debug, Clone, Copy)]
pub struct LightSource {
    /// World space without a node.
    pub node: Option<NodeId>,
    /// In the space of the node.
    pub light: Light,
}

/// A camera, and the node it hangs on.
#[derive(Debug, Clone)]
pub struct CameraSource {
    /// May be empty; several cameras may share a name, the first is meant.
    pub name: String,
    /// World space without a node.
    pub node: Option<NodeId>,
    /// In the space of the node.
    pub camera: Camera,
}

/// One moment of a world: owned, unchanging, and all that a renderer needs.
#[derive(Clone)]
pub struct Frame {
    /// The geometry.
    pub view: Snapshot,
    /// What it looks like.
    pub material_set: Arc<MaterialSet>,
    /// World space.
    pub lights: Vec<Light>,
    /// Seconds.
    pub time: f64,
}

impl World {
    /// The world at a time, in seconds.
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

    /// A camera where it stands now, that is, at the time of the latest frame.
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
