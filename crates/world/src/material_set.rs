//! All materials and textures of a world, and the surfaces that assign them to triangles.
//!
//! A [`MaterialSet`] is made once, when a world is loaded.
//! [`MaterialBindings`](crate::MaterialBindings) give each instance one of
//! [`MaterialSet::surfaces`], and a surface has a material for every triangle of the mesh.

use std::fmt;

use crate::{Material, Texture};

/// What shading needs and does not change from frame to frame.
#[derive(Default, Clone)]
pub struct MaterialSet {
    /// Indexed by [`Part::material`].
    pub materials: Vec<Material>,
    /// Indexed by [`TextureRef::texture`](crate::TextureRef::texture).
    pub textures: Vec<Texture>,
    /// Indexed by what [`MaterialBindings`](crate::MaterialBindings) gives for an instance.
    pub surfaces: Vec<Surface>,
}

/// Prints lengths, not contents.
impl fmt::Debug for MaterialSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MaterialSet")
            .field("materials", &self.materials.len())
            .field("textures", &self.textures.len())
            .field("surfaces", &self.surfaces.len())
            .finish_non_exhaustive()
    }
}

/// The materials and vertex attributes of one mesh.
#[derive(Default, Clone)]
pub struct Surface {
    /// Ranges of triangles with the same material, by ascending `first_triangle`, which is 0 for the
    /// first. Without a part, all triangles have the default material, white and diffuse.
    pub parts: Vec<Part>,
    /// Texture coordinates, one per vertex, or empty. (0, 0) is the image's upper left corner.
    pub uvs: Vec<[f32; 2]>,
    /// Linear RGBA that multiplies the base colour, one per vertex, or empty.
    pub colors: Vec<[f32; 4]>,
}

/// Prints lengths, not contents.
impl fmt::Debug for Surface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Surface")
            .field("parts", &self.parts.len())
            .field("uvs", &self.uvs.len())
            .field("colors", &self.colors.len())
            .finish_non_exhaustive()
    }
}

/// A range of triangles of a mesh that share a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// The range begins at this triangle and ends before the next part's first.
    pub first_triangle: u32,
    /// Index into [`MaterialSet::materials`].
    pub material: u32,
}

impl Surface {
    /// A surface of one material.
    pub fn of(material: u32) -> Self {
        Self { parts: vec![Part { first_triangle: 0, material }], ..Self::default() }
    }

    /// The material of a triangle, an index into [`MaterialSet::materials`]; `None` without parts.
    #[inline]
    pub fn material_of(&self, triangle: u32) -> Option<u32> {
        let after = self.parts.partition_point(|part| part.first_triangle <= triangle);
        after.checked_sub(1).map(|part| self.parts[part].material)
    }
}
