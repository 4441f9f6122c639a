//! Skins: the joints that deform a mesh, and the matrices that they deform it with.

use std::sync::Arc;

use kinetree::Affine;

use crate::accessor::Accessors;
use crate::document::Document;
use crate::error::{Item, Problem};
use crate::json::{self, ElementType, Index};
use crate::skeleton::{Skeleton, SkeletonPose};

/// A skin of the file.
pub(crate) struct Skin {
    /// In the file.
    pub(crate) index: usize,
    pub(crate) name: Option<Arc<str>>,
    /// Bones of the skeleton.
    pub(crate) joints: Vec<u32>,
    /// The inverse bind matrices; without them, all are the identity.
    joint_from_mesh: Option<Vec<Affine>>,
}

impl Skin {
    /// # Errors
    /// References to what is not there; too few inverse bind matrices, or some that are not finite.
    pub(crate) fn read(
        document: &Document,
        index: Index<json::Skin>,
        skeleton: &Skeleton,
        accessors: &Accessors<'_>,
        from: &Item,
    ) -> Result<Self, Problem> {
        let skin = document.get(index, "skin", from)?;
        let item = Item::named("skin", index.value(), skin.name.as_deref());
        let mut joints = Vec::with_capacity(skin.joints.len());
        for &joint in &skin.joints {
            document.get(joint, "node", &item)?;
            let bone = skeleton.bone(joint.value()).ok_or_else(|| item.invalid("has a joint that is no bone"))?;
            joints.push(bone as u32);
        }
        let joint_from_mesh = match skin.inverse_bind_matrices {
            None => None,
            Some(accessor) => {
                let matrices = accessors.floats::<16>(accessor, ElementType::Mat4, &item)?;
                if matrices.len() < joints.len() || !matrices.as_flattened().iter().all(|number| number.is_finite()) {
                    return Err(
                        item.invalid("has fewer inverse bind matrices than joints, or some that are not finite")
                    );
                }
                Some(matrices.iter().take(joints.len()).map(affine).collect())
            }
        };
        let name = skin.name.as_deref().map(Arc::from);
        Ok(Self { index: index.value(), name, joints, joint_from_mesh })
    }
}

/// The matrices of a skin at one moment.
pub(crate) struct JointMatrices {
    /// From the mesh at rest to the space of the root nodes of the file, by joint.
    pub(crate) matrices: Vec<Affine>,
    /// Changes whenever the matrices change.
    pub(crate) version: u64,
}

impl JointMatrices {
    /// Before the first update.
    pub(crate) fn new(skin: &Skin) -> Self {
        Self { matrices: vec![Affine::IDENTITY; skin.joints.len()], version: 0 }
    }

    pub(crate) fn update(&mut self, skin: &Skin, pose: &SkeletonPose) {
        let mut changed = false;
        for (joint, (matrix, &bone)) in self.matrices.iter_mut().zip(&skin.joints).enumerate() {
            let root_from_joint = pose.root_from_bone(bone as usize);
            let root_from_mesh = match &skin.joint_from_mesh {
                Some(joint_from_mesh) => root_from_joint * joint_from_mesh[joint],
                None => root_from_joint,
            };
            changed |= *matrix != root_from_mesh;
            *matrix = root_from_mesh;
        }
        self.version += u64::from(changed);
    }
}

/// Four columns of four, of which the last row is 0 0 0 1.
fn affine(m: &[f32; 16]) -> Affine {
    let column = |i: usize| [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
    Affine::from_columns(column(0), column(1), column(2), column(3))
}
