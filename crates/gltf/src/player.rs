//! Moves a scene as an animation says, and deforms meshes that have a skin or morph targets.

use kinetree::{Affine, EditError, InstanceId, MeshId, NodeId, Pose, Scene};
use kinetree_world::Animation;

use crate::clip::Channels;
use crate::keys::Keys;
use crate::nodes::Trs;
use crate::skeleton::{Bones, Skin};

/// Plays animations, over and over.
pub(crate) struct Player {
    /// Seconds.
    pub(crate) duration: f64,
    pub(crate) nodes: Vec<AnimatedNode>,
    pub(crate) bones: Bones,
    pub(crate) skins: Vec<Skin>,
    pub(crate) deformed: Vec<DeformedMesh>,
}

/// A node that the animation moves.
pub(crate) struct AnimatedNode {
    /// In the scene, unless it only serves as a joint.
    pub(crate) id: Option<NodeId>,
    pub(crate) bone: Option<usize>,
    pub(crate) rest: Trs,
    pub(crate) channels: Channels,
    /// Where it was placed last; `None` before the first time.
    pub(crate) placed: Option<Affine>,
}

/// A mesh that a skin or morph targets deform.
pub(crate) struct DeformedMesh {
    pub(crate) mesh: MeshId,
    pub(crate) skinned: Option<Skinned>,
    /// Of its morph targets, now.
    pub(crate) weights: Vec<f32>,
    pub(crate) keys: Option<Keys>,
    /// The version of the skin that it was posed with last; `None` before the first pose.
    pub(crate) posed_with: Option<u64>,
}

/// How joints deform a mesh.
pub(crate) struct Skinned {
    /// Among the player's skins.
    pub(crate) skin: usize,
    /// The node of the mesh. Its determinant decides which side of the triangles is the front, and
    /// nothing else about it counts (glTF 2.0 specification, section 3.7.4).
    pub(crate) node_bone: usize,
    /// Where the mesh stands. While the node mirrors, the mesh is posed in a mirrored space, which
    /// the placement of its instances mirrors back: it looks the same, and its fronts are where the
    /// node wants them.
    pub(crate) instances: Vec<InstanceId>,
    /// Whether the instances are mirrored.
    pub(crate) is_mirrored: bool,
}

/// Its own inverse.
const MIRROR: Affine = Affine::from_columns([-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]);

impl AnimatedNode {
    fn local(&self, seconds: f64) -> Affine {
        let Channels { translation, rotation, scale } = &self.channels;
        let trs = Trs {
            translation: translation.as_ref().map_or(self.rest.translation, |keys| keys.vector(seconds)),
            rotation: rotation.as_ref().map_or(self.rest.rotation, |keys| keys.rotation(seconds)),
            scale: scale.as_ref().map_or(self.rest.scale, |keys| keys.vector(seconds)),
        };
        trs.affine()
    }
}

impl DeformedMesh {
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

    /// Gives the scene its pose, if it is another than before.
    fn pose(&mut self, scene: &mut Scene, bones: &Bones, skins: &[Skin]) -> Result<(), EditError> {
        let mirrored = self.skinned.as_ref().is_some_and(|skinned| bones.is_mirrored(skinned.node_bone));
        if let Some(skinned) = self.skinned.as_mut().filter(|skinned| skinned.is_mirrored != mirrored) {
            self.posed_with = None;
            for &instance in &skinned.instances {
                scene.place(instance, if mirrored { MIRROR } else { Affine::IDENTITY })?;
            }
            skinned.is_mirrored = mirrored;
        }
        let skin = self.skinned.as_ref().map(|skinned| &skins[skinned.skin]);
        let version = skin.map_or(0, Skin::version);
        if self.posed_with == Some(version) {
            return Ok(());
        }
        let matrices = skin.map_or(&[][..], Skin::matrices);
        let reflected: Vec<Affine>;
        let joints = if mirrored {
            reflected = matrices.iter().map(|&matrix| MIRROR * matrix).collect();
            &reflected
        } else {
            matrices
        };
        scene.pose(self.mesh, &Pose { weights: &self.weights, joints })?;
        self.posed_with = Some(version);
        Ok(())
    }
}

impl Animation for Player {
    fn go_to(&mut self, scene: &mut Scene, seconds: f64) -> Result<(), EditError> {
        let seconds = moment(seconds, self.duration);
        for node in &mut self.nodes {
            let local = node.local(seconds);
            if node.placed == Some(local) {
                continue;
            }
            if let Some(id) = node.id {
                scene.place(id, local)?;
            }
            if let Some(bone) = node.bone {
                self.bones.set_local(bone, local);
            }
            node.placed = Some(local);
        }
        if self.bones.update() {
            self.skins.iter_mut().for_each(|skin| skin.update(&self.bones));
        }
        let mut scratch = Vec::new();
        for mesh in &mut self.deformed {
            if mesh.reweigh(seconds, &mut scratch) {
                // Until the scene has taken the pose.
                mesh.posed_with = None;
            }
            mesh.pose(scene, &self.bones, &self.skins)?;
        }
        Ok(())
    }

    fn duration(&self) -> f64 {
        self.duration
    }
}

/// Where a time falls in an animation that is repeated. What ends a round belongs to it, so that
/// the last pose is shown: after 0, the round is `0 < moment <= duration`.
fn moment(seconds: f64, duration: f64) -> f64 {
    let into = seconds.rem_euclid(duration);
    // Not positive, or not finite: nothing moves, or nobody knows where.
    if !into.is_finite() || duration <= 0.0 {
        return 0.0;
    }
    // The duration was rounded to `f32` in the file, so that the time of its last frame may lie
    // just behind it.
    let rounding = (seconds * f64::from(f32::EPSILON)).min(duration * LONGEST_ROUNDING);
    if seconds > 0.5 * duration && into <= rounding { duration } else { into }
}

/// As a share of the duration: less than anybody sees.
const LONGEST_ROUNDING: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_round_ends_with_its_last_moment() {
        for (seconds, duration, wanted) in [
            (0.0, 1.0, 0.0),
            (0.25, 1.0, 0.25),
            (1.0, 1.0, 1.0),
            (1.25, 1.0, 0.25),
            (2.0, 1.0, 1.0),
            (-0.25, 1.0, 0.75),
            (-1.0, 1.0, 0.0),
            (3.0, 0.0, 0.0),
            (f64::NAN, 1.0, 0.0),
            (f64::INFINITY, 1.0, 0.0),
        ] {
            assert_eq!(moment(seconds, duration), wanted, "{seconds} of {duration}");
        }
    }

    #[test]
    fn the_time_of_the_last_frame_is_the_end_whatever_the_rounding() {
        for frames in 1..2000 {
            for rate in [24.0, 25.0, 30.0, 29.97, 60.0] {
                let exact = f64::from(frames) / rate;
                let duration = f64::from(exact as f32);
                for round in [1.0, 2.0, 7.0] {
                    let wanted = moment(round * exact, duration);
                    assert!((wanted - duration).abs() < 1e-6 * duration, "{frames} frames at {rate}, round {round}");
                }
                assert!((moment(exact + 0.5 / rate, duration) - 0.5 / rate).abs() < 1e-4);
            }
        }
    }
}
