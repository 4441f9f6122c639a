//! The camera of a bench scene.

use std::fmt;

use glam::Vec3;

use crate::soup::Soup;

/// A pinhole camera for square pictures.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PinholeCamera {
    /// Metres, world space.
    pub(crate) position: Vec3,
    /// The direction of view, of length one.
    pub(crate) forward: Vec3,
    /// From the centre of the picture to its right edge, at distance one.
    pub(crate) right: Vec3,
    /// From the centre of the picture to its upper edge, at distance one.
    pub(crate) up: Vec3,
}

impl PinholeCamera {
    /// A camera at `position` that looks at `target`; `half` is the tangent of half the angle of
    /// view.
    pub(crate) fn look_at(position: Vec3, target: Vec3, half: f32) -> Self {
        let forward = (target - position).normalize_or(Vec3::NEG_Z);
        let right = forward.cross(Vec3::Y).normalize_or(Vec3::X);
        Self { position, forward, right: right * half, up: right.cross(forward) * half }
    }

    /// A camera outside the scene that shows all of it.
    pub(super) fn frame(soup: &Soup) -> Self {
        let bounds = soup.bounds();
        let radius = (Vec3::from(bounds.extent()).length() * 0.5).max(1e-6);
        let center = Vec3::from(bounds.center());
        Self::look_at(center + Vec3::new(0.62, 0.38, 0.68).normalize() * radius * 2.0, center, 0.5)
    }
}

impl fmt::Display for PinholeCamera {
    /// Writes the fields of a case file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { position, forward, right, .. } = self;
        write!(f, "{position:?}, looking along {forward:?}, half {}", right.length())
    }
}
