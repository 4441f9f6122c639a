//! Images on surfaces: eight-bit texels, filtered bilinearly.

/// An image with what is needed to look it up.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGBA, row by row from the top, `width * height` of them.
    pub texels: Vec<[u8; 4]>,
    /// Colour is encoded as sRGB, and decoded when it is looked up; alpha never is.
    pub srgb: bool,
    /// What lies left and right of the image, and above and below.
    pub wrap: [Wrap; 2],
    /// Whether neighbouring texels are blended.
    pub filter: Filter,
}

/// What lies beyond an image's edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image again, every other one mirrored.
    Mirror,
    /// The texel at the edge.
    Clamp,
}

/// How a colour is made of texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// The four around the point, weighted.
    #[default]
    Bilinear,
}
