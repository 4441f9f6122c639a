//! Posing a mesh: morph targets first, then a skin.
//!
//! Linear blend skinning (Magnenat-Thalmann, Laperriere and Thalmann 1988) as glTF 2.0 defines it.
//! Normals are transformed by the cofactors of the blended matrix, so that they stay perpendicular
//! under stretching joints too.

use glam::{Mat3, Vec3};

use super::error::EditError;
use super::mesh::MeshData;
use super::skin::Skin;
use crate::geometry::Affine;
use crate::threads::Threads;

/// How a mesh is deformed from its rest pose.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pose<'a> {
    /// One weight per morph target; empty means all zero.
    pub weights: &'a [f32],
    /// One map per joint, from the rest pose to the pose, both in object space (glTF: the joint's
    /// global transform times its inverse bind matrix); empty means all at rest. A mesh without a
    /// skin has no joints.
    pub joints: &'a [Affine],
}

/// A pose that was checked against its mesh, kept until the next commit.
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

    /// Writes posed positions and, unless the slice is empty, posed normals.
    pub(crate) fn apply(
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
            let morphed = targets.iter().fold(Vec3::from(mesh.positions[vertex]), |sum, (target, weight)| {
                sum + Vec3::from(target.positions[vertex]) * **weight
            });
            *position = match skin.map(|skin| self.blended(skin, vertex)) {
                Some((linear, translation)) => (linear * morphed + translation).into(),
                None => morphed.into(),
            };
        });
        threads.for_each(normals, GRAIN, &|vertex, normal| {
            let rest = Vec3::from(mesh.normals[vertex]);
            let morphed = targets
                .iter()
                .filter(|(target, _)| !target.normals.is_empty())
                .fold(rest, |sum, (target, weight)| sum + Vec3::from(target.normals[vertex]) * **weight);
            let moved = skin.map_or(morphed, |skin| cofactors(self.blended(skin, vertex).0) * morphed);
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

/// Vertices in a task of one thread.
const GRAIN: usize = 2048;

/// The matrix that takes normals, up to length, where `m` takes surfaces.
fn cofactors(m: Mat3) -> Mat3 {
    let sign = m.determinant().signum();
    Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)) * sign
}
