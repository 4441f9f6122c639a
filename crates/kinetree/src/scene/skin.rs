//! What deforms a mesh: skins and morph targets.

use std::fmt;

use super::error::MeshError;

/// The joints that move each vertex, and their weights.
#[derive(Clone, Default, PartialEq)]
pub struct Skin {
    /// Four joints per vertex.
    pub joints: Vec<[u16; 4]>,
    /// Their weights. They are used as they are; their sum should be one.
    pub weights: Vec<[f32; 4]>,
}

/// A morph target (blend shape): displacements that a pose adds, times a weight.
#[derive(Clone, Default, PartialEq)]
pub struct MorphTarget {
    /// Displacements, metres, one per vertex.
    pub positions: Vec<[f32; 3]>,
    /// Changes of the normals, one per vertex, or empty.
    pub normals: Vec<[f32; 3]>,
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
    /// # Errors
    /// A weight that is negative or not finite.
    pub(super) fn check(&self) -> Result<(), MeshError> {
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

    /// The least number of joints of a pose.
    pub(super) fn joint_count(&self) -> usize {
        let used = self.joints.iter().zip(&self.weights).flat_map(|(joints, weights)| joints.iter().zip(weights));
        used.filter(|&(_, &weight)| weight > 0.0).map(|(&joint, _)| usize::from(joint) + 1).max().unwrap_or(0)
    }
}
