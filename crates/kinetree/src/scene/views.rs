//! Views: what a snapshot holds of an instance and of a mesh.

use std::fmt;
use std::ops::Deref;

use super::frame::PlacedInstance;
use super::report::MeshReport;
use crate::geometry::{Aabb, Affine, Interpolate, Precision, Ray, Triangle};
use crate::handle::{InstanceId, MeshId};
use crate::query::Hit;
use crate::traverse::MeshFrame;
use crate::update::Motion;
use crate::wide::{InstanceRecord, MeshBvh};

/// A mesh as it is in one frame, whether or not an instance shows it.
#[derive(Clone, Copy)]
pub struct MeshView<'a> {
    pub(super) report: &'a MeshReport,
    pub(super) frame: &'a MeshFrame,
    pub(super) normals: &'a [[f32; 3]],
}

/// In short: which, and how large it is.
impl fmt::Debug for MeshView<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles = self.triangles().len();
        f.debug_struct("MeshView").field("id", &self.id()).field("triangles", &triangles).finish_non_exhaustive()
    }
}

impl<'a> MeshView<'a> {
    /// Its handle in the scene.
    pub fn id(&self) -> MeshId {
        self.report.mesh
    }

    /// What the commit of this frame did to it.
    pub fn report(&self) -> &'a MeshReport {
        self.report
    }

    /// How it was announced to move.
    pub fn motion(&self) -> Motion {
        self.report.motion
    }

    /// How exactly rays are tested against its triangles.
    pub fn precision(&self) -> Precision {
        self.frame.precision
    }

    /// Posed for this frame, metres, object space.
    pub fn positions(&self) -> &'a [[f32; 3]] {
        self.frame.triangles.positions()
    }

    /// Posed for this frame, one per vertex, object space, if the mesh has any.
    pub fn normals(&self) -> Option<&'a [[f32; 3]]> {
        (!self.normals.is_empty()).then_some(self.normals)
    }

    /// Vertex numbers, three per triangle.
    pub fn triangles(&self) -> &'a [[u32; 3]] {
        self.frame.triangles.indices()
    }

    /// The tree over its triangles.
    #[doc(alias = "BLAS")]
    pub fn bvh(&self) -> &'a MeshBvh {
        &self.frame.bvh
    }

    /// The value at a hit on this mesh, of a list with one value per vertex: those of the
    /// triangle's corners, weighted by `1 - u - v`, `u` and `v`. Normals come out shorter than unit
    /// length between corners that differ.
    ///
    /// `None` if the list has another length than [`MeshView::positions`], or the mesh has no
    /// triangle of that number.
    ///
    /// ```
    /// # use kinetree::{Affine, Mesh, Motion, Ray, Scene};
    /// # let mut scene = Scene::new();
    /// # let triangle = Mesh::new(&[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]], &[[0, 1, 2]])?;
    /// # let mesh = scene.add_mesh(triangle, Motion::Static)?;
    /// # scene.add_instance(scene.root(), mesh, Affine::IDENTITY)?;
    /// # let view = scene.commit();
    /// let texture_coordinates = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    /// let hit = view.closest_hit(&Ray::new([1.0, 2.0, 9.0], [0.0, 0.0, -1.0])).ok_or("a triangle")?;
    /// assert_eq!(view.instance(&hit).interpolate(&hit, &texture_coordinates), Some([0.25, 0.5]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn interpolate<T: Interpolate>(&self, hit: &Hit, per_vertex: &[T]) -> Option<T> {
        if per_vertex.len() != self.positions().len() {
            return None;
        }
        let corners = self.triangles().get(hit.primitive as usize)?;
        Some(T::weighted(corners.map(|vertex| per_vertex[vertex as usize]), [1.0 - hit.u - hit.v, hit.u, hit.v]))
    }

    /// # Panics
    /// When there is no triangle of the hit's number.
    #[track_caller]
    pub(super) fn triangle(&self, hit: &Hit) -> Triangle {
        self.frame.triangles.get(hit.primitive)
    }
}

/// An instance as it is in one frame, and through [`Deref`] the mesh that it shows.
#[derive(Clone, Copy)]
pub struct InstanceView<'a> {
    pub(super) index: u32,
    pub(super) record: &'a InstanceRecord,
    pub(super) placed: &'a PlacedInstance,
    pub(super) bounds: &'a Aabb,
    pub(super) mesh: MeshView<'a>,
}

/// In short: which, and how large it is.
impl fmt::Debug for InstanceView<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("InstanceView")
            .field("index", &self.index)
            .field("id", &self.id())
            .field("mesh_id", &self.mesh_id())
            .field("triangles", &self.triangles().len())
            .finish_non_exhaustive()
    }
}

/// Positions, normals, triangles and tree of an instance are those of its mesh.
impl<'a> Deref for InstanceView<'a> {
    type Target = MeshView<'a>;

    fn deref(&self) -> &MeshView<'a> {
        &self.mesh
    }
}

impl<'a> InstanceView<'a> {
    /// Number among the instances of the snapshot.
    pub fn index(&self) -> u32 {
        self.index
    }

    /// Its handle in the scene.
    pub fn id(&self) -> InstanceId {
        self.placed.id
    }

    /// The handle of its mesh.
    pub fn mesh_id(&self) -> MeshId {
        self.mesh.id()
    }

    /// The mesh that it shows.
    pub fn mesh(&self) -> MeshView<'a> {
        self.mesh
    }

    /// The caller's own number, its own or that of the nearest node above that has one; else 0.
    pub fn user_id(&self) -> u32 {
        self.record.user_id
    }

    /// The bits that its own mask and those of all nodes above have in common. Queries see the
    /// instance when their mask shares a bit with these.
    pub fn mask(&self) -> u32 {
        self.record.mask
    }

    /// Whether filters are not asked about it.
    pub fn is_opaque(&self) -> bool {
        self.record.opaque
    }

    /// A box around it, metres, world space: the one that the top level holds. It is padded by the
    /// rounding errors that rays make on entering the instance. Empty if the mesh has no triangles.
    pub fn bounds(&self) -> Aabb {
        *self.bounds
    }

    /// Its placement: takes points from object space to the world.
    pub fn world_from_object(&self) -> &'a Affine {
        &self.placed.world_from_object
    }

    /// The inverse of the placement, as rays are transformed by it; of a flat placement, for points
    /// of its plane.
    pub fn object_from_world(&self) -> &'a Affine {
        &self.record.object_from_world
    }

    /// A ray in object space, by the operations of the queries: hits of it have the same `t`.
    /// `None` when it can hit nothing there, and when queries enter the instance in double
    /// precision, since its placement is flat or badly skewed.
    pub fn ray_in_object(&self, ray: &Ray) -> Option<Ray> {
        (!self.record.in_double).then(|| self.record.enter(ray))?
    }
}
