//! A flattened scene: triangles, and the instance that each came from.

use glam::{DVec3, Vec3};
use kinetree::{Aabb, Snapshot};

/// The triangle of the scene that a triangle of the soup was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Source {
    /// The index of the instance in the scene.
    pub(crate) mesh: u32,
    /// The number of the triangle in its mesh.
    pub(crate) primitive: u32,
}

/// Triangles in world space that share vertices within an instance.
#[derive(Debug, Clone, Default)]
pub(crate) struct Soup {
    /// Metres, world space.
    pub(crate) positions: Vec<[f32; 3]>,
    /// Three vertex numbers each.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// One per triangle.
    pub(crate) sources: Vec<Source>,
}

impl Soup {
    /// All instances of a frame, flattened. Triangles whose transformed vertices are not finite are
    /// left out.
    pub(crate) fn flatten(view: &Snapshot) -> Self {
        let mut soup = Self::default();
        for instance in view.instances() {
            let first = soup.positions.len() as u32;
            let placed = instance.positions().iter().map(|p| instance.world_from_object().transform_point(*p));
            soup.positions.extend(placed);
            for (triangle, primitive) in instance.triangles().iter().zip(0..) {
                let triangle = triangle.map(|vertex| vertex + first);
                if triangle.iter().all(|&vertex| Vec3::from(soup.positions[vertex as usize]).is_finite()) {
                    soup.triangles.push(triangle);
                    soup.sources.push(Source { mesh: instance.index(), primitive });
                }
            }
        }
        // A vertex that no triangle uses may still not be finite.
        soup.positions.iter_mut().filter(|p| !Vec3::from(**p).is_finite()).for_each(|p| *p = [0.0; 3]);
        soup
    }

    /// Adds a mesh as the next instance.
    pub(crate) fn add(&mut self, positions: impl IntoIterator<Item = Vec3>, triangles: &[[u32; 3]]) {
        let first = self.positions.len() as u32;
        let mesh = self.sources.last().map_or(0, |last| last.mesh + 1);
        self.positions.extend(positions.into_iter().map(|p| p.to_array()));
        self.triangles.extend(triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
        self.sources.extend((0..triangles.len() as u32).map(|primitive| Source { mesh, primitive }));
    }

    /// The same triangles, each with three vertices of its own.
    pub(crate) fn unindexed(&self) -> Self {
        let positions = self.triangles.iter().flatten().map(|&vertex| self.positions[vertex as usize]).collect();
        let triangles = (0..self.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Self { positions, triangles, sources: self.sources.clone() }
    }

    /// The corners of a triangle.
    pub(crate) fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|vertex| Vec3::from(self.positions[vertex as usize]))
    }

    /// The unit normal of a triangle, computed in double precision; `None` for one without area.
    pub(crate) fn normal(&self, triangle: u32) -> Option<Vec3> {
        let [a, b, c] = self.corners(triangle).map(Vec3::as_dvec3);
        let normal = (b - a).cross(c - a);
        (normal != DVec3::ZERO).then(|| normal.normalize().as_vec3())
    }

    /// The bounding box of all triangles.
    pub(crate) fn bounds(&self) -> Aabb {
        Aabb::from_points(self.triangles.iter().flatten().map(|&vertex| self.positions[vertex as usize]))
    }

    /// The number of triangles.
    pub(crate) fn len(&self) -> usize {
        self.triangles.len()
    }
}
