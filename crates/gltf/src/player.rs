//! Plays the animations of a file in a scene.

use std::sync::Arc;

use kinetree::{Affine, EditError, InstanceId, MeshId, NodeId, Pose, Scene};

use crate::clip::{Clip, ClipInfo, PlayError, Playing};
use crate::rig::{DeformedMesh, Rig};
use crate::skeleton::SkeletonPose;
use crate::skin::JointMatrices;

/// Plays the animations of one copy of a file in a scene, each over and over.
///
/// What it records depends on the animation and the time only, not on what was played before. Nodes
/// that the animation does not move are at rest.
///
/// It owns the transforms of animated nodes and the poses of deformed meshes, and edits only those
/// that change: what the caller does to them lasts until then. Skins follow the animation, not
/// nodes that the caller moves.
pub struct Player {
    rig: Arc<Rig>,
    /// As the animated nodes of the rig.
    nodes: Vec<NodeState>,
    skeleton: SkeletonPose,
    /// As the skins of the rig.
    skins: Vec<JointMatrices>,
    /// As the deformed meshes of the rig.
    deformed: Vec<MeshState>,
}

/// An animated node in the scene.
struct NodeState {
    /// `None` for a joint that is not in the scene.
    id: Option<NodeId>,
    /// Its transform as it was set last; `None` before the first time.
    local: Option<Affine>,
}

/// A deformed mesh in the scene.
struct MeshState {
    id: MeshId,
    /// While the node of a skinned mesh mirrors, the mesh is posed in a mirrored space, which the
    /// placement of its instances mirrors back: it looks the same, and its fronts are on the other
    /// side.
    instances: Vec<InstanceId>,
    /// Whether the instances are mirrored.
    is_mirrored: bool,
    /// Of its morph targets, now.
    weights: Vec<f32>,
    /// The version of the joint matrices that it was posed with last, 0 without a skin; `None` if
    /// the scene does not have the present pose.
    posed_with: Option<u64>,
}

/// Its own inverse.
const MIRROR: Affine = Affine::from_columns([-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]);

impl Player {
    /// A player for what has been inserted: `node` gives the nodes of the file in the scene,
    /// `meshes` has the meshes of the asset, and `instances` those of each mesh.
    pub(crate) fn new(
        rig: &Arc<Rig>,
        node: impl Fn(usize) -> Option<NodeId>,
        meshes: &[MeshId],
        mut instances: impl FnMut(usize) -> Vec<InstanceId>,
    ) -> Self {
        let mesh_state = |deformed: &DeformedMesh| MeshState {
            id: meshes[deformed.mesh],
            instances: if deformed.skinned.is_some() { instances(deformed.mesh) } else { Vec::new() },
            is_mirrored: false,
            weights: deformed.rest_weights.clone(),
            posed_with: None,
        };
        Self {
            rig: Arc::clone(rig),
            nodes: rig.nodes.iter().map(|animated| NodeState { id: node(animated.node), local: None }).collect(),
            skeleton: SkeletonPose::at_rest(&rig.skeleton),
            skins: rig.skins.iter().map(JointMatrices::new).collect(),
            deformed: rig.deformed.iter().map(mesh_state).collect(),
        }
    }

    /// All animations of the file, in its order.
    pub fn clips(&self) -> &[ClipInfo] {
        &self.rig.clips.all
    }

    /// How long an animation takes, seconds; 0 if it moves nothing.
    ///
    /// # Errors
    /// An animation that the file does not have, or that was not read.
    pub fn duration(&self, clip: &Clip) -> Result<f64, PlayError> {
        Ok(self.duration_of(self.rig.clips.playing(clip)?))
    }

    /// Records the edits that bring the scene to a time of an animation, in seconds, which begins
    /// again after its duration.
    ///
    /// # Errors
    /// An animation that the file does not have, or that was not read; an edit that the scene
    /// refused, such as one of a node that has been removed: what was edited before stays edited.
    pub fn go_to(&mut self, scene: &mut Scene, clip: &Clip, seconds: f64) -> Result<(), PlayError> {
        let playing = self.rig.clips.playing(clip)?;
        Ok(self.play(scene, playing, seconds)?)
    }

    /// Records the edits that bring everything back to where it is without an animation.
    ///
    /// # Errors
    /// An edit that the scene refused: what was edited before stays edited.
    pub fn rest(&mut self, scene: &mut Scene) -> Result<(), EditError> {
        self.play(scene, Playing::Nothing, 0.0)
    }

    /// Whether nothing ever changes once it has been posed.
    pub(crate) fn is_still(&self) -> bool {
        let moves = |index: usize| self.nodes[index].id.is_some() || self.rig.nodes[index].bone.is_some();
        self.deformed.is_empty() && !(0..self.nodes.len()).any(moves)
    }

    pub(crate) fn duration_of(&self, playing: Playing) -> f64 {
        self.rig.clips.duration(playing)
    }

    pub(crate) fn play(&mut self, scene: &mut Scene, playing: Playing, seconds: f64) -> Result<(), EditError> {
        let rig = &*self.rig;
        let seconds = time_in_clip(seconds, rig.clips.duration(playing));
        for (state, animated) in self.nodes.iter_mut().zip(&rig.nodes) {
            let local = animated.local(&rig.clips, playing, seconds);
            if state.local == Some(local) {
                continue;
            }
            if let Some(id) = state.id {
                scene.place(id, local)?;
            }
            if let Some(bone) = animated.bone {
                self.skeleton.set_local(bone, local);
            }
            state.local = Some(local);
        }
        if self.skeleton.update(&rig.skeleton) {
            self.skins.iter_mut().zip(&rig.skins).for_each(|(matrices, skin)| matrices.update(skin, &self.skeleton));
        }
        let mut weights = Vec::new();
        for (state, deformed) in self.deformed.iter_mut().zip(&rig.deformed) {
            deformed.weights(&rig.clips, playing, seconds, &mut weights);
            if weights != state.weights {
                std::mem::swap(&mut weights, &mut state.weights);
                state.posed_with = None;
            }
            state.pose(scene, deformed, &self.skeleton, &self.skins)?;
        }
        Ok(())
    }
}

impl MeshState {
    /// Gives the scene the pose of the mesh, if it does not have it.
    fn pose(
        &mut self,
        scene: &mut Scene,
        deformed: &DeformedMesh,
        skeleton: &SkeletonPose,
        skins: &[JointMatrices],
    ) -> Result<(), EditError> {
        let mirrored = deformed.skinned.is_some_and(|skinned| skeleton.is_mirrored(skinned.node_bone));
        if self.is_mirrored != mirrored {
            self.posed_with = None;
            for &instance in &self.instances {
                scene.place(instance, if mirrored { MIRROR } else { Affine::IDENTITY })?;
            }
            self.is_mirrored = mirrored;
        }
        let skin = deformed.skinned.map(|skinned| &skins[skinned.skin]);
        let version = skin.map_or(0, |skin| skin.version);
        if self.posed_with == Some(version) {
            return Ok(());
        }
        let matrices = skin.map_or(&[][..], |skin| &skin.matrices);
        let reflected: Vec<Affine>;
        let joints = if mirrored {
            reflected = matrices.iter().map(|&matrix| MIRROR * matrix).collect();
            &reflected
        } else {
            matrices
        };
        scene.pose(self.id, &Pose { weights: &self.weights, joints })?;
        self.posed_with = Some(version);
        Ok(())
    }
}

/// In short: what it has to move.
impl std::fmt::Debug for Player {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Player")
            .field("clips", &self.rig.clips.all.len())
            .field("nodes", &self.nodes.len())
            .field("deformed", &self.deformed.len())
            .finish_non_exhaustive()
    }
}

/// Where a time falls in an animation that is repeated. What ends a round belongs to it, so that
/// the last pose is shown: after 0, the round is `0 < time <= duration`.
fn time_in_clip(seconds: f64, duration: f64) -> f64 {
    let into = seconds.rem_euclid(duration);
    // Without a duration nothing moves; a time that is not finite counts as the first.
    if !into.is_finite() || duration <= 0.0 {
        return 0.0;
    }
    // The duration was rounded to `f32` in the file, so that the time of its last frame may lie
    // just behind it.
    let rounding = (seconds * f64::from(f32::EPSILON)).min(duration * LONGEST_ROUNDING);
    if seconds > 0.5 * duration && into <= rounding { duration } else { into }
}

/// As a share of the duration: too short to be seen.
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
            assert_eq!(time_in_clip(seconds, duration), wanted, "{seconds} of {duration}");
        }
    }

    #[test]
    fn the_time_of_the_last_frame_is_the_end_whatever_the_rounding() {
        for frames in 1..2000 {
            for rate in [24.0, 25.0, 30.0, 29.97, 60.0] {
                let exact = f64::from(frames) / rate;
                let duration = f64::from(exact as f32);
                for round in [1.0, 2.0, 7.0] {
                    let wanted = time_in_clip(round * exact, duration);
                    assert!((wanted - duration).abs() < 1e-6 * duration, "{frames} frames at {rate}, round {round}");
                }
                assert!((time_in_clip(exact + 0.5 / rate, duration) - 0.5 / rate).abs() < 1e-4);
            }
        }
    }
}
