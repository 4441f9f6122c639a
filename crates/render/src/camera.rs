//! Pinhole cameras.

use kinetree::Affine;

/// A pinhole camera. Without rotation it looks along -z, with +y up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where it stands and looks. Its axes are used as directions only: scale does not matter.
    pub world_from_camera: Affine,
    /// Vertical field of view, radians.
    pub fov_y: f32,
}

impl Camera {
    /// A camera at `eye` that looks at `target`, with +y up.
    pub fn look_at(eye: [f32; 3], target: [f32; 3], fov_y: f32) -> Self {
        Self { world_from_camera: Affine::look_at(eye, target, [0.0, 1.0, 0.0]), fov_y }
    }

    /// Where it stands, metres, world space.
    pub fn position(&self) -> [f32; 3] {
        self.world_from_camera.translation
    }
}
