//! What moves and deforms the contents of a file: the same for every copy of it in a scene.

use kinetree::Affine;

use crate::channels::{Channels, PerClip};
use crate::clip::{Clips, Playing};
use crate::keys::Keys;
use crate::skeleton::Skeleton;
use crate::skin::Skin;
use crate::transform::{Local, Trs};

/// The animations of a file, and what they move.
pub(crate) struct Rig {
    pub(crate) clips: Clips,
    pub(crate) nodes: Vec<AnimatedNode>,
    pub(crate) skeleton: Skeleton,
    pub(crate) skins: Vec<Skin>,
    pub(crate) deformed: Vec<DeformedMesh>,
}

/// A node that an animation moves.
pub(crate) struct AnimatedNode {
    /// In the file.
    pub(crate) node: usize,
    pub(crate) bone: Option<usize>,
    pub(crate) rest: Local,
    pub(crate) channels: PerClip<Channels>,
}

/// A mesh that a skin or morph targets deform.
pub(crate) struct DeformedMesh {
    /// Among the meshes of the asset.
    pub(crate) mesh: usize,
    pub(crate) skinned: Option<Skinned>,
    /// One per morph target, or none if the mesh does not morph.
    pub(crate) rest_weights: Vec<f32>,
    pub(crate) weights: PerClip<Keys>,
}

/// How joints deform a mesh.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Skinned {
    /// Among the skins of the rig.
    pub(crate) skin: usize,
    /// The node of the mesh. Its determinant decides which side of the triangles is the front, and
    /// nothing else about it counts (glTF 2.0 specification, section 3.7.4).
    pub(crate) node_bone: usize,
}

impl AnimatedNode {
    /// The transform of the node relative to its parent.
    pub(crate) fn local(&self, clips: &Clips, playing: Playing, seconds: f64) -> Affine {
        let played = || self.channels.iter().filter(|(clip, _)| clips.includes(playing, *clip)).map(|(_, c)| c);
        if played().next().is_none() {
            return self.rest.affine();
        }
        let rest = self.rest.trs();
        let translation = played().find_map(|channels| channels.translation.as_ref());
        let rotation = played().find_map(|channels| channels.rotation.as_ref());
        let scale = played().find_map(|channels| channels.scale.as_ref());
        let trs = Trs {
            translation: translation.map_or(rest.translation, |keys| keys.vector(seconds)),
            rotation: rotation.map_or(rest.rotation, |keys| keys.rotation(seconds)),
            scale: scale.map_or(rest.scale, |keys| keys.vector(seconds)),
        };
        trs.affine()
    }
}

impl DeformedMesh {
    /// The weights of the morph targets.
    pub(crate) fn weights(&self, clips: &Clips, playing: Playing, seconds: f64, out: &mut Vec<f32>) {
        out.clear();
        out.extend_from_slice(&self.rest_weights);
        if let Some((_, keys)) = self.weights.iter().find(|(clip, _)| clips.includes(playing, *clip)) {
            keys.sample(seconds, out);
        }
    }
}
