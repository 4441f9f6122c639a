//! Materials.

use crate::TextureRef;

/// How a surface scatters, emits and transmits light.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Linear RGB reflectance, each in 0..=1, and alpha.
    pub base_color: [f32; 4],
    /// Multiplies `base_color`.
    pub base_color_texture: Option<TextureRef>,
    /// Emitted radiance, linear RGB, W/(m^2 sr).
    pub emission: [f32; 3],
    /// Multiplies `emission`.
    pub emission_texture: Option<TextureRef>,
    /// The alpha mode.
    pub alpha: Alpha,
    /// The kind of scattering.
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

    /// Whether the material emits light.
    #[inline]
    pub fn is_emissive(&self) -> bool {
        self.emission.iter().any(|&channel| channel > 0.0)
    }
}

/// The kinds of scattering, pbrt's BxDFs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scatter {
    /// Lambertian reflection.
    Diffuse,
    /// A smooth boundary that reflects and refracts by Fresnel's formulas; the base colour tints
    /// the refracted light.
    Dielectric {
        /// Index of refraction of the inside (the side that the winding faces away from) over that
        /// of the outside.
        ior: f32,
    },
    /// A dielectric sheet without thickness, such as a car window modelled as one layer: reflects
    /// by Fresnel's formulas summed over both boundaries, and transmits the rest without changing
    /// its direction.
    ThinDielectric {
        /// Index of refraction of the sheet.
        ior: f32,
    },
}

/// How the alpha of a material acts on visibility.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Alpha {
    /// Alpha is ignored.
    Opaque,
    /// The surface is hit where alpha is at least the cutoff.
    Mask {
        /// The smallest alpha that is hit, in 0..=1.
        cutoff: f32,
    },
    /// The surface is hit with a probability of alpha.
    Blend,
}
