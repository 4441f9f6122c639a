//! What to read from a file, and how much of it.

use kinetree::Motion;

use crate::clip::Clip;

/// What to read from a file, and how much.
///
/// ```
/// use kinetree::Motion;
/// use kinetree_gltf::Options;
///
/// let options = Options::new().clip("walk").motion(Motion::Rigid).max_texture_bytes(256 << 20);
/// assert_eq!(options.motion, Motion::Rigid);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Options {
    /// The animations that are read; others cannot be played. `None` reads all of them.
    pub clip: Option<Clip>,
    /// The motion of meshes that no animation moves: [`Motion::Static`], or [`Motion::Rigid`] if
    /// the caller is going to move them.
    pub motion: Motion,
    /// How much memory the texels of all textures may take, bytes: four for every pixel. Images
    /// beyond that are left out, with a note.
    pub max_texture_bytes: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { clip: None, motion: Motion::Static, max_texture_bytes: 4 << 30 }
    }
}

impl Options {
    /// All animations, meshes that stand still, and 4 GiB of textures.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Reads only some animations: [`Options::clip`](field@Options::clip).
    #[must_use]
    pub fn clip(self, clip: impl Into<Clip>) -> Self {
        Self { clip: Some(clip.into()), ..self }
    }

    /// Sets [`Options::motion`](field@Options::motion).
    #[must_use]
    pub fn motion(self, motion: Motion) -> Self {
        Self { motion, ..self }
    }

    /// Sets [`Options::max_texture_bytes`](field@Options::max_texture_bytes).
    #[must_use]
    pub fn max_texture_bytes(self, max_texture_bytes: u64) -> Self {
        Self { max_texture_bytes, ..self }
    }
}
