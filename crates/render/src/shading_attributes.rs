//! Material, texture coordinates and vertex colour at a point of a triangle, and the textures
//! evaluated there.

use std::sync::LazyLock;

use glam::{Vec2, Vec3, Vec4};
use kinetree::InstanceView;
use kinetree_world::{Alpha, Frame, Material, Texture, TextureRef};

use crate::color::{clamp_positive, reflectance, sanitized};
use crate::sampler::{combine, unit_hash};

/// The material of triangles that have none.
static DEFAULT_MATERIAL: LazyLock<Material> = LazyLock::new(Material::default);

/// What shading needs to know about a point of a triangle, beside its geometry.
#[derive(Clone, Copy)]
pub(crate) struct ShadingAttributes<'a> {
    textures: &'a [Texture],
    /// The material of the triangle.
    pub(crate) material: &'a Material,
    uv: [f32; 2],
    /// The interpolated vertex colour, linear RGBA.
    vertex_color: Vec4,
}

impl<'a> ShadingAttributes<'a> {
    /// The attributes at barycentric coordinates `u` and `v`, the weights of the second and third
    /// vertex.
    pub(crate) fn at(frame: &'a Frame, instance: &InstanceView<'_>, primitive: u32, [u, v]: [f32; 2]) -> Self {
        let material = Self::material_at(frame, instance, primitive);
        let mut attributes =
            Self { textures: &frame.material_set.textures, material, uv: [0.0; 2], vertex_color: Vec4::ONE };
        let Some(surface) = frame.surface(instance.index()) else { return attributes };
        let corners = instance.triangles()[primitive as usize].map(|vertex| vertex as usize);
        let weights = [1.0 - u - v, u, v];
        if let [Some(a), Some(b), Some(c)] = corners.map(|vertex| surface.uvs.get(vertex)) {
            attributes.uv =
                (Vec2::from(*a) * weights[0] + Vec2::from(*b) * weights[1] + Vec2::from(*c) * weights[2]).into();
        }
        if let [Some(a), Some(b), Some(c)] = corners.map(|vertex| surface.colors.get(vertex)) {
            attributes.vertex_color =
                Vec4::from(*a) * weights[0] + Vec4::from(*b) * weights[1] + Vec4::from(*c) * weights[2];
        }
        attributes
    }

    /// The material of a triangle.
    pub(crate) fn material_at(frame: &'a Frame, instance: &InstanceView<'_>, primitive: u32) -> &'a Material {
        let material = frame.surface(instance.index()).and_then(|surface| surface.material_of(primitive));
        material.and_then(|id| frame.material_set.materials.get(id as usize)).unwrap_or(&DEFAULT_MATERIAL)
    }

    fn texture(&self, reference: &Option<TextureRef>) -> Vec4 {
        reference.map_or(Vec4::ONE, |reference| reference.lookup(self.textures, self.uv).into())
    }

    /// Reflectance, linear RGB, each channel in 0..=1.
    pub(crate) fn base_color(&self) -> Vec3 {
        let color =
            Vec4::from(self.material.base_color) * self.vertex_color * self.texture(&self.material.base_color_texture);
        reflectance(color.truncate().into())
    }

    /// Radiance that leaves on an emitting side, linear RGB.
    pub(crate) fn emission(&self) -> Vec3 {
        if !self.material.is_emissive() {
            return Vec3::ZERO;
        }
        sanitized(self.material.emission) * self.texture(&self.material.emission_texture).truncate()
    }

    fn alpha(&self) -> f32 {
        self.material.base_color[3] * self.vertex_color.w * self.texture(&self.material.base_color_texture).w
    }

    /// The probability that a ray hits the surface at this point, in 0..=1, by the alpha mode of
    /// the material.
    pub(crate) fn opacity(&self) -> f32 {
        match self.material.alpha {
            Alpha::Opaque => 1.0,
            Alpha::Mask { cutoff } => f32::from(u8::from(self.alpha() >= cutoff)),
            Alpha::Blend => clamp_positive(self.alpha(), 1.0),
        }
    }
}

/// Stochastic alpha test: whether a ray hits a surface of some opacity, with that probability.
///
/// The random number is a hash of the point and of the sample's salt, so that all rays of one
/// sample that meet the same point get the same answer.
pub(crate) fn alpha_test(opacity: f32, instance: u32, primitive: u32, [u, v]: [f32; 2], salt: u32) -> bool {
    if opacity <= 0.0 || opacity >= 1.0 {
        return opacity > 0.0;
    }
    let point = combine(combine(instance, primitive), combine(u.to_bits(), v.to_bits()));
    unit_hash(combine(point, salt)) < opacity
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blended_surface_is_hit_as_often_as_its_alpha_says() {
        let count = (0..100_000).filter(|&salt| alpha_test(0.3, 1, 2, [0.25, 0.5], salt)).count();
        // Five standard deviations of a binomial are 725.
        assert!(count.abs_diff(30_000) < 725, "{count}");
        assert!(
            (0..1000).all(|salt| alpha_test(1.0, 1, 2, [0.25, 0.5], salt) && !alpha_test(0.0, 1, 2, [0.25, 0.5], salt))
        );
    }
}
