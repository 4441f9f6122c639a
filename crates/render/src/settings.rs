//! The settings of a picture, and why there may be none.

use crate::IntegratorKind;

/// The size, sampling and integrator of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Pixels in a row, 1 to 65536.
    pub width: u32,
    /// Rows, 1 to 65536.
    pub height: u32,
    /// Samples per pixel, at least 1.
    pub spp: u32,
    /// Index of the first sample. The mean of the pictures of samples 0..8 and 8..16 is that of
    /// 0..16.
    pub first_sample: u32,
    /// Seeds the sampler: another seed gives other noise.
    pub seed: u64,
    /// The number of threads; `None` for rayon's global pool. The picture does not depend on it.
    pub threads: Option<usize>,
    /// What the picture shows.
    pub integrator: IntegratorKind,
    /// How often a path may scatter.
    pub max_depth: u32,
    /// Upper bound of a single contribution from beyond the first bounce, radiance; biased, and
    /// therefore off by default.
    pub clamp: Option<f32>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            spp: 16,
            first_sample: 0,
            seed: 0,
            threads: None,
            integrator: IntegratorKind::Path,
            max_depth: 64,
            clamp: None,
        }
    }
}

impl Settings {
    /// Checks the size and the samples.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let &Self { width, height, spp, first_sample: first, .. } = self;
        let sides = 1..=MAX_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) || u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(RenderError::Size { width, height });
        }
        if spp == 0 || first.checked_add(spp).is_none() {
            return Err(RenderError::Samples { spp, first });
        }
        Ok(())
    }
}

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A side is zero or beyond the limit, or there are too many pixels.
    #[error(
        "a picture of {width} x {height} pixels cannot be made: sides go from 1 to {MAX_SIDE}, pixels up to {MAX_PIXELS}"
    )]
    Size {
        /// As asked for.
        width: u32,
        /// As asked for.
        height: u32,
    },
    /// No samples, or sample indices of 2^32 and more.
    #[error("{spp} samples per pixel from number {first} on cannot be taken: at least 1, and numbers below 2^32")]
    Samples {
        /// As asked for.
        spp: u32,
        /// As asked for.
        first: u32,
    },
    /// The thread pool could not be made.
    #[error("{count} threads cannot be had: {reason}")]
    Threads {
        /// As asked for.
        count: usize,
        /// The reason.
        reason: String,
    },
    /// The caller asked to stop.
    #[error("stopped before the picture was finished")]
    Stopped,
}

/// Longest side, pixels.
pub const MAX_SIDE: u32 = 65_536;
/// Largest number of pixels: with twelve bytes each, 1.5 GiB.
pub const MAX_PIXELS: u64 = 1 << 27;
