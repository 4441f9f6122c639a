//! A builder of meshes: vertices with all their attributes, triangles sorted by material.
//!
//! Triangles are counter-clockwise when seen from outside. Shapes that need more than this are in
//! `shapes`.

use glam::{Vec2, Vec3};
use kinetree::{Mesh, MeshError};
use kinetree_world::{Part, Surface};

/// A mesh under construction, with its surface.
#[derive(Clone, Default)]
pub(crate) struct Sketch {
    /// The material of the next triangles.
    pub(crate) material: u32,
    /// The colour of the next vertices, linear RGB, which multiplies that of the material.
    pub(crate) color: [f32; 3],
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    colors: Vec<[f32; 4]>,
    triangles: Vec<(u32, [u32; 3])>,
}

impl Sketch {
    /// An empty mesh that begins with a material and white vertices.
    pub(crate) fn new(material: u32) -> Self {
        Self { material, color: [1.0; 3], ..Self::default() }
    }

    /// Changes the material of the next triangles and the colour of the next vertices.
    pub(crate) fn set_material(&mut self, material: u32, color: [f32; 3]) -> &mut Self {
        self.material = material;
        self.color = color;
        self
    }

    /// Adds a vertex in the current colour.
    pub(crate) fn vertex(&mut self, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        let index = self.positions.len() as u32;
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        self.colors.push([self.color[0], self.color[1], self.color[2], 1.0]);
        index
    }

    /// Adds a triangle of the current material, unless it has no area.
    pub(crate) fn triangle(&mut self, a: u32, b: u32, c: u32) {
        let [p, q, r] = [a, b, c].map(|index| self.positions[index as usize]);
        if (q - p).cross(r - p).length_squared() > 1e-16 {
            self.triangles.push((self.material, [a, b, c]));
        }
    }

    /// Two triangles; the corners go round counter-clockwise.
    pub(crate) fn quad(&mut self, a: u32, b: u32, c: u32, d: u32) {
        self.triangle(a, b, c);
        self.triangle(a, c, d);
    }

    /// A flat four-sided face with its own vertices. The image stands upright when the corners
    /// begin at its lower left.
    pub(crate) fn panel(&mut self, corners: [Vec3; 4]) {
        let normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]).normalize_or_zero();
        let uvs = [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.0)];
        let [a, b, c, d] = std::array::from_fn(|i| self.vertex(corners[i], normal, uvs[i]));
        self.quad(a, b, c, d);
    }

    /// Gives the vertices from `first` on the mean normal of their triangles, weighted by area.
    /// `same` lists pairs of vertices at the same position, which share a normal.
    pub(crate) fn smooth(&mut self, first: u32, same: &[[u32; 2]]) {
        let first = first as usize;
        self.normals[first..].fill(Vec3::ZERO);
        for &(_, triangle) in &self.triangles {
            if triangle.iter().all(|&index| index as usize >= first) {
                let [p, q, r] = triangle.map(|index| self.positions[index as usize]);
                let weighted = (q - p).cross(r - p);
                for index in triangle {
                    self.normals[index as usize] += weighted;
                }
            }
        }
        for &[a, b] in same {
            let both = self.normals[a as usize] + self.normals[b as usize];
            self.normals[a as usize] = both;
            self.normals[b as usize] = both;
        }
        for normal in &mut self.normals[first..] {
            *normal = normal.normalize_or(Vec3::Y);
        }
    }

    /// The number of vertices.
    pub(crate) fn vertex_count(&self) -> u32 {
        self.positions.len() as u32
    }

    /// The positions of the vertices.
    pub(crate) fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Unit normals, one per vertex.
    pub(crate) fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Adds a layer of another material over all triangles of one material, at a distance above
    /// them.
    pub(crate) fn coat(&mut self, over: u32, coat: u32, distance: f32) {
        let first = self.vertex_count();
        let (positions, normals) = (self.positions.clone(), self.normals.clone());
        self.color = [1.0; 3];
        for (&position, &normal) in positions.iter().zip(&normals) {
            self.vertex(position + normal * distance, normal, Vec2::ZERO);
        }
        let covered: Vec<[u32; 3]> =
            self.triangles.iter().filter(|&&(material, _)| material == over).map(|&(_, triangle)| triangle).collect();
        self.triangles.extend(covered.into_iter().map(|triangle| (coat, triangle.map(|index| index + first))));
    }

    /// The mesh and its surface; triangles of the same material keep their order.
    pub(crate) fn finish(mut self) -> Result<(Mesh, Surface), MeshError> {
        self.triangles.sort_by_key(|&(material, _)| material);
        let mut parts: Vec<Part> = Vec::new();
        for (index, &(material, _)) in self.triangles.iter().enumerate() {
            if parts.last().is_none_or(|part| part.material != material) {
                parts.push(Part { first_triangle: index as u32, material });
            }
        }
        let positions: Vec<[f32; 3]> = self.positions.iter().map(|position| position.to_array()).collect();
        let normals: Vec<[f32; 3]> = self.normals.iter().map(|normal| normal.to_array()).collect();
        let triangles: Vec<[u32; 3]> = self.triangles.iter().map(|&(_, triangle)| triangle).collect();
        let mesh = Mesh::new(&positions, &triangles)?.with_normals(&normals)?;
        let uvs = self.uvs.iter().map(|uv| uv.to_array()).collect();
        Ok((mesh, Surface { parts, uvs, colors: self.colors }))
    }
}
