//! Bending a mesh: morph targets first, then a skin.
//!
//! Linear blend skinning (Magnenat-Thalmann, Laperriere and Thalmann 1988) as glTF 2.0 defines it. Normals follow by the cofactors of the blended
//! matrix, so that they stay perpendicular under stretching joints too.

use std::fmt;

use glam::{Mat3, Vec3};

use super::mesh::MeshData;
use super::{EditError, MeshError};
use crate::geometry::Affine;
use crate::threads::Threads;

/// Which joints pull at a vertex, and how strongly.
#[derive(Clone, Default, PartialEq)]
pub struct Skin {
    /// Four joints per vertex.
    pub joints: Vec<[u16; 4]>,
    /// Their weights. They are used as they are; their sum should be one.
    pub weights: Vec<[f32; 4]>,
}

/// A shape that a mesh can be pulled towards.
#[derive(Clone, Default, PartialEq)]
pub struct MorphTarget {
    /// Displacements, metres, one per vertex.
    pub positions: Vec<[f32; 3]>,
    /// Changes of the normals, one per vertex, or empty.
    pub normals: Vec<[f32; 3]>,
}

/// How a mesh is bent.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pose<'a> {
    /// One weight per morph target; none means all zero.
    pub weights: &'a [f32],
    /// For every joint, the map from the rest pose to the pose, both in the space of the mesh; none
    /// means all at rest. A mesh without a skin has no joints.
    pub joints: &'a [Affine],
}

/// In short: for how many vertices.
impl fmt::Debug for Skin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Skin").field("vertices", &self.joints.len()).finish_non_exhaustive()
    }
}

/// In short: for how many vertices.
impl fmt::Debug for MorphTarget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MorphTarget")
            .field("vertices", &self.positions.len())
            .field("has_normals", &!self.normals.is_empty())
            .finish_non_exhaustive()
    }
}

impl Skin {
    pub(crate) fn check(&self) -> Result<(), MeshError> {
        for (at, weights) in self.weights.iter().enumerate() {
            if !weights.iter().all(|weight| weight.is_finite()) {
                return Err(MeshError::NonFinite { at });
            }
            if weights.iter().any(|&weight| weight < 0.0) {
                return Err(MeshError::NegativeWeight { at });
            }
        }
        Ok(())
    }

    /// How many joints a pose has to have, at least.
    fn joint_count(&self) -> usize {
        let used = self.joints.iter().zip(&self.weights).flat_map(|(joints, weights)| joints.iter().zip(weights));
        used.filter(|&(_, &weight)| weight > 0.0).map(|(&joint, _)| usize::from(joint) + 1).max().unwrap_or(0)
    }
}

/// A pose that fits its mesh, kept until the next commit.
#[derive(Debug, Clone, Default)]
pub(crate) struct OwnedPose {
    weights: Vec<f32>,
    joints: Vec<Affine>,
}

impl OwnedPose {
    /// # Errors
    /// A pose that does not fit the mesh, or is not finite.
    pub(crate) fn new(pose: &Pose<'_>, mesh: &MeshData) -> Result<Self, EditError> {
        let targets = mesh.morph_targets.len();
        if !pose.weights.is_empty() && pose.weights.len() != targets {
            let found = pose.weights.len();
            return Err(EditError::PoseDiffers { what: "morph targets", expected: targets, found });
        }
        let joints = mesh.skin.as_ref().map_or(0, Skin::joint_count);
        let is_skinned = mesh.skin.is_some();
        if !pose.joints.is_empty() && (!is_skinned || pose.joints.len() < joints) {
            return Err(EditError::PoseDiffers { what: "joints", expected: joints, found: pose.joints.len() });
        }
        let bad_weight = pose.weights.iter().position(|weight| !weight.is_finite());
        let bad_joint = pose.joints.iter().position(|joint| !joint.is_finite());
        if let Some(at) = bad_weight.or(bad_joint) {
            return Err(EditError::NonFinite { at });
        }
        Ok(Self { weights: pose.weights.to_vec(), joints: pose.joints.to_vec() })
    }

    /// Writes positions, and normals if the mesh has any.
    pub(crate) fn bend(
        &self,
        mesh: &MeshData,
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
        threads: &Threads,
    ) {
        let targets: Vec<_> =
            mesh.morph_targets.iter().zip(&self.weights).filter(|&(_, &weight)| weight != 0.0).collect();
        let skin = mesh.skin.as_ref().filter(|_| !self.joints.is_empty());
        threads.for_each(positions, GRAIN, &|vertex, position| {
            let pulled = targets.iter().fold(Vec3::from(mesh.positions[vertex]), |place, (target, weight)| {
                place + Vec3::from(target.positions[vertex]) * **weight
            });
            *position = match skin.map(|skin| self.blended(skin, vertex)) {
                Some((linear, translation)) => (linear * pulled + translation).into(),
                None => pulled.into(),
            };
        });
        threads.for_each(normals, GRAIN, &|vertex, normal| {
            let rest = Vec3::from(mesh.normals[vertex]);
            let pulled = targets
                .iter()
                .filter(|(target, _)| !target.normals.is_empty())
                .fold(rest, |place, (target, weight)| place + Vec3::from(target.normals[vertex]) * **weight);
            let moved = skin.map_or(pulled, |skin| cofactors(self.blended(skin, vertex).0) * pulled);
            *normal = moved.normalize_or(rest).into();
        });
    }

    /// The weighted sum of the joints at a vertex.
    fn blended(&self, skin: &Skin, vertex: usize) -> (Mat3, Vec3) {
        let (mut linear, mut translation) = (Mat3::ZERO, Vec3::ZERO);
        for (&joint, &weight) in skin.joints[vertex].iter().zip(&skin.weights[vertex]) {
            if weight > 0.0 {
                let joint = &self.joints[usize::from(joint)];
                linear.x_axis += Vec3::from(joint.x_axis) * weight;
                linear.y_axis += Vec3::from(joint.y_axis) * weight;
                linear.z_axis += Vec3::from(joint.z_axis) * weight;
                translation += Vec3::from(joint.translation) * weight;
            }
        }
        (linear, translation)
    }
}

/// Vertices in a piece of work.
const GRAIN: usize = 2048;

/// Takes normals where the matrix takes surfaces.
fn cofactors(m: Mat3) -> Mat3 {
    let sign = m.determinant().signum();
    Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)) * sign
}
