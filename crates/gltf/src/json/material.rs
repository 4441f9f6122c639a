//! Materials, textures and images.

use serde::Deserialize;

use super::geometry::View;
use super::{Index, Name, present};

/// A material. Properties that most materials lack are boxed.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Material {
    pub(crate) name: Option<Name>,
    #[serde(rename = "pbrMetallicRoughness")]
    pub(crate) pbr: Option<Box<Pbr>>,
    #[serde(deserialize_with = "present")]
    pub(crate) normal_texture: bool,
    pub(crate) emissive_texture: Option<Box<TextureInfo>>,
    pub(crate) emissive_factor: [f32; 3],
    pub(crate) alpha_mode: AlphaMode,
    pub(crate) alpha_cutoff: Option<f32>,
    pub(crate) double_sided: bool,
    pub(crate) extensions: Option<Box<MaterialExtensions>>,
}

const _: () = assert!(size_of::<Material>() <= 104, "a material takes more memory than its text can justify");

impl Material {
    pub(crate) fn base_color(&self) -> [f32; 4] {
        self.pbr.as_ref().and_then(|pbr| pbr.base_color_factor).unwrap_or([1.0; 4])
    }

    pub(crate) fn base_color_texture(&self) -> Option<&TextureInfo> {
        self.pbr.as_ref()?.base_color_texture.as_ref()
    }
}

/// Colour, metalness and roughness.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Pbr {
    pub(crate) base_color_factor: Option<[f32; 4]>,
    pub(crate) base_color_texture: Option<TextureInfo>,
    pub(crate) metallic_factor: Option<f32>,
    pub(crate) roughness_factor: Option<f32>,
    #[serde(deserialize_with = "present")]
    pub(crate) metallic_roughness_texture: bool,
}

/// What alpha means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) enum AlphaMode {
    #[default]
    Opaque,
    Mask,
    Blend,
    #[serde(other)]
    Unknown,
}

/// A texture as a material uses it.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct TextureInfo {
    pub(crate) index: Index<Texture>,
    #[serde(default)]
    tex_coord: u32,
    #[serde(default)]
    extensions: Option<Box<TextureInfoExtensions>>,
}

impl TextureInfo {
    pub(crate) fn transform(&self) -> Option<&TextureTransform> {
        self.extensions.as_ref()?.transform.as_ref()
    }

    /// The number of its set of texture coordinates.
    pub(crate) fn coordinate_set(&self) -> u32 {
        self.transform().and_then(|transform| transform.tex_coord).unwrap_or(self.tex_coord)
    }
}

/// Extensions of the use of a texture.
#[derive(Deserialize)]
struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<TextureTransform>,
}

/// KHR_texture_transform.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct TextureTransform {
    pub(crate) offset: [f32; 2],
    /// Radians.
    pub(crate) rotation: f32,
    pub(crate) scale: [f32; 2],
    tex_coord: Option<u32>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

/// Extensions of materials. Of those that are not supported, only whether they are there.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(crate) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub(crate) emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_ior")]
    pub(crate) ior: Option<Ior>,
    #[serde(rename = "KHR_materials_transmission")]
    pub(crate) transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_volume")]
    pub(crate) volume: Option<Volume>,
    #[serde(rename = "KHR_materials_unlit", deserialize_with = "present")]
    pub(crate) unlit: bool,
    #[serde(rename = "KHR_materials_specular", deserialize_with = "present")]
    pub(crate) specular: bool,
    #[serde(rename = "KHR_materials_clearcoat", deserialize_with = "present")]
    pub(crate) clearcoat: bool,
    #[serde(rename = "KHR_materials_sheen", deserialize_with = "present")]
    pub(crate) sheen: bool,
    #[serde(rename = "KHR_materials_iridescence", deserialize_with = "present")]
    pub(crate) iridescence: bool,
    #[serde(rename = "KHR_materials_anisotropy", deserialize_with = "present")]
    pub(crate) anisotropy: bool,
    #[serde(rename = "KHR_materials_dispersion", deserialize_with = "present")]
    pub(crate) dispersion: bool,
    #[serde(rename = "KHR_materials_diffuse_transmission", deserialize_with = "present")]
    pub(crate) diffuse_transmission: bool,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness", deserialize_with = "present")]
    pub(crate) specular_glossiness: bool,
}

/// KHR_materials_emissive_strength.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct EmissiveStrength {
    pub(crate) emissive_strength: f32,
}

impl Default for EmissiveStrength {
    fn default() -> Self {
        Self { emissive_strength: 1.0 }
    }
}

/// KHR_materials_ior.
#[derive(Deserialize)]
#[serde(default)]
pub(crate) struct Ior {
    pub(crate) ior: f32,
}

impl Default for Ior {
    fn default() -> Self {
        Self { ior: 1.5 }
    }
}

/// KHR_materials_transmission.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Transmission {
    pub(crate) transmission_factor: f32,
    #[serde(deserialize_with = "present")]
    pub(crate) transmission_texture: bool,
}

/// KHR_materials_volume.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Volume {
    /// Metres; 0 for a surface that is infinitely thin.
    pub(crate) thickness_factor: f32,
    pub(crate) attenuation_distance: Option<f32>,
}

/// An image and how it is sampled.
#[derive(Deserialize)]
pub(crate) struct Texture {
    pub(crate) name: Option<Name>,
    pub(crate) sampler: Option<Index<Sampler>>,
    /// Missing where only an extension knows the image.
    pub(crate) source: Option<Index<Image>>,
}

/// How a texture is sampled: OpenGL's numbers.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Sampler {
    pub(crate) mag_filter: Option<u32>,
    pub(crate) min_filter: Option<u32>,
    pub(crate) wrap_s: Option<u32>,
    pub(crate) wrap_t: Option<u32>,
}

/// A picture.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Image {
    pub(crate) name: Option<Name>,
    pub(crate) buffer_view: Option<Index<View>>,
    pub(crate) uri: Option<Box<str>>,
}
