//! Moves a scene as an animation says, and bends what hangs on joints or has morph targets.

use kinetree::{Affine, EditError, MeshId, NodeId, Pose, Scene};
use kinetree_render::Animation;

use crate::clip::Channels;
use crate::keys::Keys;
use crate::nodes::Parts;
use crate::skeleton::{Bones, Skin};

/// Plays one animation, over and over.
pub(crate) struct Player {
    /// Seconds.
    pub(crate) duration: f64,
    pub(crate) movers: Vec<Mover>,
    pub(crate) bones: Bones,
    pub(crate) skins: Vec<Skin>,
    pub(crate) bodies: Vec<Body>,
}

/// A node that the animation moves.
pub(crate) struct Mover {
    /// In the scene, unless it only serves as a joint.
    pub(crate) node: Option<NodeId>,
    pub(crate) bone: Option<usize>,
    pub(crate) rest: Parts,
    pub(crate) channels: Channels,
    /// Where it was placed last; `None` before the first time.
    pub(crate) placed: Option<Affine>,
}

/// A mesh that is bent.
pub(crate) struct Body {
    pub(crate) mesh: MeshId,
    /// Among the player's skins.
    pub(crate) skin: Option<usize>,
    /// Of its morph targets, now.
    pub(crate) weights: Vec<f32>,
    pub(crate) keys: Option<Keys>,
    /// The version of the skin that it was posed with last; `None` before the first pose.
    pub(crate) posed_with: Option<u64>,
}

impl Mover {
    fn local(&self, seconds: f64) -> Affine {
        let Channels { translation, rotation, scale } = &self.channels;
        let parts = Parts {
            translation: translation.as_ref().map_or(self.rest.translation, |keys| keys.vector(seconds)),
            rotation: rotation.as_ref().map_or(self.rest.rotation, |keys| keys.rotation(seconds)),
            scale: scale.as_ref().map_or(self.rest.scale, |keys| keys.vector(seconds)),
        };
        parts.affine()
    }
}

impl Body {
    /// Takes up the weights of a time, and says whether they are others than before.
    fn reweigh(&mut self, seconds: f64, scratch: &mut Vec<f32>) -> bool {
        let Some(keys) = &self.keys else { return false };
        scratch.clear();
        scratch.resize(self.weights.len(), 0.0);
        keys.sample(seconds, scratch);
        let changed = *scratch != self.weights;
        std::mem::swap(scratch, &mut self.weights);
        changed
    }
}

impl Animation for Player {
    fn go_to(&mut self, scene: &mut Scene, seconds: f64) -> Result<(), EditError> {
        let wrapped = if self.duration > 0.0 { seconds.rem_euclid(self.duration) } else { 0.0 };
        let seconds = if wrapped.is_finite() { wrapped } else { 0.0 };
        for mover in &mut self.movers {
            let local = mover.local(seconds);
            if mover.placed == Some(local) {
                continue;
            }
            if let Some(node) = mover.node {
                scene.place(node, local)?;
            }
            if let Some(bone) = mover.bone {
                self.bones.place(bone, local);
            }
            mover.placed = Some(local);
        }
        if self.bones.update() {
            self.skins.iter_mut().for_each(|skin| skin.update(&self.bones));
        }
        let mut scratch = Vec::new();
        for body in &mut self.bodies {
            let reweighed = body.reweigh(seconds, &mut scratch);
            if reweighed {
                // Until the scene has taken the pose.
                body.posed_with = None;
            }
            let skin = body.skin.map(|skin| &self.skins[skin]);
            let version = skin.map_or(0, Skin::version);
            if body.posed_with != Some(version) {
                scene.pose(body.mesh, &Pose { weights: &body.weights, joints: skin.map_or(&[], Skin::matrices) })?;
                body.posed_with = Some(version);
            }
        }
        Ok(())
    }

    fn duration(&self) -> f64 {
        self.duration
    }
}
