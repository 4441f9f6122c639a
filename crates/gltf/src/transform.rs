//! The transform of a node relative to its parent: a matrix, or translation, rotation and scale.

use kinetree::Affine;

use crate::json::Node;

/// A transform relative to the parent.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Local {
    Matrix(Affine),
    Trs(Trs),
}

/// Translation, rotation and scale, each of which can be animated alone. Scale is applied first,
/// then rotation, then translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Trs {
    pub(crate) translation: [f32; 3],
    /// A unit quaternion, x y z w.
    pub(crate) rotation: [f32; 4],
    pub(crate) scale: [f32; 3],
}

impl Trs {
    pub(crate) fn affine(&self) -> Affine {
        Affine::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

impl Local {
    /// The transform of a node relative to its parent.
    pub(crate) fn of(node: &Node) -> Self {
        if let Some(m) = &node.matrix {
            let column = |i: usize| [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
            return Self::Matrix(Affine::from_columns(column(0), column(1), column(2), column(3)));
        }
        Self::Trs(Trs {
            translation: node.translation.as_deref().copied().unwrap_or([0.0; 3]),
            rotation: node.rotation.as_deref().and_then(|&rotation| normalized(rotation)).unwrap_or(IDENTITY_ROTATION),
            scale: node.scale.as_deref().copied().unwrap_or([1.0; 3]),
        })
    }

    pub(crate) fn affine(&self) -> Affine {
        match self {
            Self::Matrix(affine) => *affine,
            Self::Trs(trs) => trs.affine(),
        }
    }

    /// Decomposes a matrix; its shear is lost.
    pub(crate) fn trs(&self) -> Trs {
        match self {
            Self::Trs(trs) => *trs,
            Self::Matrix(affine) => {
                let columns = [affine.x_axis, affine.y_axis, affine.z_axis].map(glam::Vec3::from);
                let mirrored = affine.determinant() < 0.0;
                let lengths = columns.map(glam::Vec3::length);
                let scale = [if mirrored { -lengths[0] } else { lengths[0] }, lengths[1], lengths[2]];
                let mut axes =
                    glam::Mat3::from_cols(columns[0] / scale[0], columns[1] / scale[1], columns[2] / scale[2]);
                if !axes.is_finite() {
                    axes = glam::Mat3::IDENTITY;
                }
                let rotation = normalized(glam::Quat::from_mat3(&axes).to_array()).unwrap_or(IDENTITY_ROTATION);
                Trs { translation: affine.translation, rotation, scale }
            }
        }
    }
}

/// The quaternion of no rotation.
pub(crate) const IDENTITY_ROTATION: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// A quaternion of length one; `None` for one without a direction.
pub(crate) fn normalized(quaternion: [f32; 4]) -> Option<[f32; 4]> {
    // In double precision, the length of a finite quaternion is finite.
    let quaternion = quaternion.map(f64::from);
    let length = quaternion.iter().map(|q| q * q).sum::<f64>().sqrt();
    (length.is_finite() && length > 0.0).then(|| quaternion.map(|q| (q / length) as f32))
}
