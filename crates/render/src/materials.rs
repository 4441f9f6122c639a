//! What a scene looks like: materials, textures, and which triangle wears which.
//!
//! A [`MaterialSet`] is made once, when a world is loaded. An instance points into it with its user
//! id: `user_id` is an index into [`MaterialSet::surfaces`], and a surface says for every triangle
//! of the mesh which material it has. Meshes of the same look may move as they like.

use std::fmt;

use crate::texture::Texture;

/// Everything that shading needs and that does not change from frame to frame.
#[derive(Debug, Default, Clone)]
pub struct MaterialSet {
    /// Indexed by [`Part::material`].
    pub materials: Vec<Material>,
    /// Indexed by [`TextureRef::texture`].
    pub textures: Vec<Texture>,
    /// Indexed by the user id of an instance.
    pub surfaces: Vec<Surface>,
    /// The light that comes from infinity in every direction.
    pub sky: Sky,
}

/// How the triangles and vertices of one mesh are dressed.
#[derive(Default, Clone)]
pub struct Surface {
    /// Runs of triangles with the same material, by ascending `first_triangle`; the first starts at
    /// 0. Without a part, all triangles are white and diffuse.
    pub parts: Vec<Part>,
    /// Texture coordinates, one per vertex, or empty. (0, 0) is the image's upper left corner.
    pub uvs: Vec<[f32; 2]>,
    /// Linear RGBA that multiplies the base colour, one per vertex, or empty.
    pub colors: Vec<[f32; 4]>,
}

/// In short: how much there is of it.
impl fmt::Debug for Surface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Surface")
            .field("parts", &self.parts.len())
            .field("uvs", &self.uvs.len())
            .field("colors", &self.colors.len())
            .finish_non_exhaustive()
    }
}

/// A run of triangles of a mesh that share a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// The run goes from this triangle to the next part's first.
    pub first_triangle: u32,
    /// Index into [`MaterialSet::materials`].
    pub material: u32,
}

impl Surface {
    /// A surface of one material.
    pub fn of(material: u32) -> Self {
        Self { parts: vec![Part { first_triangle: 0, material }], ..Self::default() }
    }

    /// The material of a triangle, if any is given.
    pub fn material_of(&self, triangle: u32) -> Option<u32> {
        let after = self.parts.partition_point(|part| part.first_triangle <= triangle);
        after.checked_sub(1).map(|part| self.parts[part].material)
    }
}

/// How a surface scatters, emits and lets through light.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Linear RGB reflectance, each in 0..=1, and alpha.
    pub base_color: [f32; 4],
    /// Multiplies `base_color`.
    pub base_color_texture: Option<TextureRef>,
    /// Radiance that leaves the surface, linear RGB, W/(m^2 sr).
    pub emission: [f32; 3],
    /// Multiplies `emission`.
    pub emission_texture: Option<TextureRef>,
    /// What alpha means.
    pub alpha: Alpha,
    /// What kind of surface it is.
    pub scatter: Scatter,
    /// Emits from both sides; otherwise only from the side from which its winding is
    /// counter-clockwise. Reflection is always two-sided.
    pub two_sided: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            base_color: [1.0; 4],
            base_color_texture: None,
            emission: [0.0; 3],
            emission_texture: None,
            alpha: Alpha::Opaque,
            scatter: Scatter::Diffuse,
            two_sided: true,
        }
    }
}

impl Material {
    /// A diffuse surface of a linear RGB reflectance.
    pub fn diffuse(color: [f32; 3]) -> Self {
        Self { base_color: [color[0], color[1], color[2], 1.0], ..Self::default() }
    }

    /// A black surface that emits a linear RGB radiance.
    pub fn emissive(radiance: [f32; 3]) -> Self {
        Self { base_color: [0.0, 0.0, 0.0, 1.0], emission: radiance, ..Self::default() }
    }

    /// A smooth dielectric, such as glass with an index of refraction of 1.5.
    pub fn glass(ior: f32) -> Self {
        Self { scatter: Scatter::Dielectric { ior }, ..Self::default() }
    }

    /// Whether the material sends out light of its own.
    pub fn is_emissive(&self) -> bool {
        self.emission.iter().any(|&channel| channel > 0.0)
    }
}

/// What kind of surface a material is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scatter {
    /// Lambert's law.
    Diffuse,
    /// A smooth boundary that reflects and refracts by Fresnel's formulas; the base colour tints
    /// what passes.
    Dielectric {
        /// Index of refraction of the inside (the side that the winding faces away from) over that
        /// of the outside.
        ior: f32,
    },
    /// A dielectric sheet without thickness, such as a car window modelled as one layer: reflects
    /// by Fresnel's formulas summed over both boundaries, lets the rest through without bending it.
    ThinDielectric {
        /// Index of refraction of the sheet.
        ior: f32,
    },
}

/// What the alpha of a material means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Alpha {
    /// Nothing: the surface is everywhere.
    Opaque,
    /// The surface is there where alpha is at least the cutoff.
    Mask {
        /// In 0..=1.
        cutoff: f32,
    },
    /// The surface is there with a probability of alpha, decided by a hash of the place on the
    /// surface, the same for every ray that asks about the same place with the same sample.
    Blend,
}

/// A texture as a material uses it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureRef {
    /// Index into [`MaterialSet::textures`].
    pub texture: u32,
    /// Texture coordinates are `scale * uv`, turned by `rotation`, plus `offset`
    /// (KHR_texture_transform).
    pub scale: [f32; 2],
    /// Radians, counter-clockwise as in KHR_texture_transform.
    pub rotation: f32,
    /// Added last.
    pub offset: [f32; 2],
}

impl From<u32> for TextureRef {
    fn from(texture: u32) -> Self {
        Self { texture, scale: [1.0; 2], rotation: 0.0, offset: [0.0; 2] }
    }
}

/// Radiance that arrives from infinity, linear RGB.
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
