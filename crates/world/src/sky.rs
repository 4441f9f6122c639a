//! The sky.

/// Radiance that arrives from infinitely far away, linear RGB, W/(m^2 sr).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sky {
    /// The same from everywhere.
    Constant([f32; 3]),
    /// From the horizon (y = 0) smoothly to the zenith (+y), and below the horizon to the ground
    /// (-y).
    Gradient {
        /// Straight up.
        zenith: [f32; 3],
        /// Level.
        horizon: [f32; 3],
        /// Straight down.
        ground: [f32; 3],
    },
}

impl Default for Sky {
    fn default() -> Self {
        Self::Constant([0.0; 3])
    }
}
