//! A frame that stays what it is: what queries are asked of.

use std::fmt;

use super::error::ForeignHit;
use super::frame::{Frame, PlacedInstance};
use super::offset;
use super::published::Published;
use super::report::FrameReport;
use crate::geometry::{Aabb, Affine, Ray};
use crate::handle::{InstanceId, MeshId};
use crate::query::{Coherence, Hit, Query};
use crate::simd::Level;
use crate::traverse::{FrameBvh, MeshFrame};
use crate::update::Motion;
use crate::wide::{InstanceRecord, MeshBvh, TopLevelBvh};

/// One frame of a scene. It borrows nothing: keep it, send it, drop it anywhere. Clones share the frame.
///
/// Queries need no lock. Any thread may trace a snapshot while the next frame is edited and committed.
#[derive(Clone)]
pub struct Snapshot(Published<Frame>);

const _: () = {
    const fn travels<T: Clone + Send + Sync + 'static>() {}
    travels::<Snapshot>();
};

impl Snapshot {
    pub(crate) fn of(frame: Published<Frame>) -> Self {
        Self(frame)
    }

    /// The nearest hit; at equal distance the one with the smaller (instance, primitive).
    #[doc(alias = "intersect")]
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.query().closest_hit(ray)
    }

    /// Whether anything is hit.
    #[doc(alias = "any-hit")]
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.query().occluded(ray)
    }

    /// A question with a mask, culling or a filter.
    pub fn query(&self) -> Query<'_> {
        Query::new(&self.0.world)
    }

    /// The nearest hit of each ray, on the calling thread. What the caller knows about the rays changes the speed, never the hits.
    ///
    /// # Panics
    /// When there are not as many hits as rays.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>], coherence: Coherence) {
        self.query().closest_hits(rays, hits, coherence);
    }

    /// Whether each ray hits anything, on the calling thread.
    ///
    /// # Panics
    /// When there are not as many answers as rays.
    pub fn occluded_each(&self, rays: &[Ray], answers: &mut [bool], coherence: Coherence) {
        self.query().occluded_each(rays, answers, coherence);
    }

    /// The same frame, its queries compiled for another level. For tests: answers are the same at every level.
    #[doc(hidden)]
    #[must_use]
    pub fn at_level(&self, level: Level) -> Self {
        let world = FrameBvh { level, ..self.0.world.clone() };
        let (normals, placed, boxes) = (self.0.normals.clone(), self.0.placed.clone(), self.0.boxes.clone());
        let (report, original) = (self.0.report.clone(), Some(self.0.clone()));
        Self(Published::alone(Frame { world, normals, placed, boxes, report, owners: Vec::new(), original }))
    }

    /// What the commit did that made this frame.
    pub fn report(&self) -> &FrameReport {
        &self.0.report
    }

    /// The box around everything that can be hit, world space.
    pub fn bounds(&self) -> Aabb {
        self.0.world.top.bounds()
    }

    /// The tree over the instances.
    #[doc(alias = "TLAS")]
    pub fn top_level(&self) -> &TopLevelBvh {
        &self.0.world.top
    }

    /// Everything about the instance that was hit.
    ///
    /// # Panics
    /// When the hit is of another frame: neither of this snapshot nor of a clone of it. See
    /// [`Snapshot::try_instance`].
    #[track_caller]
    pub fn instance(&self, hit: &Hit) -> InstanceView<'_> {
        match self.try_instance(hit) {
            Ok(view) => view,
            Err(foreign) => panic!("{foreign}"),
        }
    }

    /// Everything about the instance that was hit, if the hit is of this frame.
    ///
    /// ```
    /// use kinetree::{Affine, ForeignHit, Mesh, Motion, Ray, Scene};
    ///
    /// # fn main() -> Result<(), kinetree::EditError> {
    /// let mut scene = Scene::new();
    /// let triangle = Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
    /// let mesh = scene.add_mesh(triangle, Motion::Rigid)?;
    /// let flag = scene.add_instance(scene.root(), mesh, Affine::IDENTITY)?;
    ///
    /// let before = scene.commit();
    /// let hit = before.closest_hit(&Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0])).unwrap();
    /// assert_eq!(before.try_instance(&hit).map(|view| view.id()), Ok(flag));
    ///
    /// let after = scene.commit();
    /// assert_eq!(after.try_instance(&hit).map(|view| view.id()), Err(ForeignHit));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// The hit is of another frame: neither of this snapshot nor of a clone of it.
    pub fn try_instance(&self, hit: &Hit) -> Result<InstanceView<'_>, ForeignHit> {
        if hit.stamp() == self.0.world.stamp { Ok(self.instance_at(hit.instance_index())) } else { Err(ForeignHit) }
    }

    /// Which instance was hit.
    ///
    /// # Panics
    /// As [`Snapshot::instance`].
    #[track_caller]
    pub fn instance_id(&self, hit: &Hit) -> InstanceId {
        self.instance(hit).id()
    }

    /// Which mesh was hit.
    ///
    /// # Panics
    /// As [`Snapshot::instance`].
    #[track_caller]
    pub fn mesh_id(&self, hit: &Hit) -> MeshId {
        self.instance(hit).mesh_id()
    }

    /// The caller's own number of what was hit.
    ///
    /// # Panics
    /// As [`Snapshot::instance`].
    #[track_caller]
    pub fn user_id(&self, hit: &Hit) -> u32 {
        self.instance(hit).user_id()
    }

    /// Where the triangle was hit, metres, world space: the corners weighted by `u` and `v`, in double precision and rounded
    /// once. It is off the plane of the triangle by no more than that rounding. Along the plane it is as exact as the weights,
    /// to within 2^-23 of the triangle's longest edge; on triangles that are much larger than the way of the ray,
    /// [`Snapshot::position_along`] is more exact.
    ///
    /// # Panics
    /// As [`Snapshot::instance`]; also when the number of the triangle was changed to one that is not there.
    #[must_use]
    #[track_caller]
    pub fn position(&self, hit: &Hit) -> [f32; 3] {
        let view = self.instance(hit);
        let triangle = view.posed.triangles.get(hit.primitive);
        offset::to_world(view.world_from_object(), offset::place(&triangle, hit.u, hit.v)).as_vec3().into()
    }

    /// Where a ray met the triangle of its hit, metres, world space: on the ray and in the plane of the triangle, computed in
    /// double precision and rounded once. As exact as single precision can say it, unless the ray runs nearly along the plane.
    /// Never farther from [`Snapshot::position`] than that may be off.
    ///
    /// # Panics
    /// As [`Snapshot::position`].
    #[must_use]
    #[track_caller]
    pub fn position_along(&self, hit: &Hit, ray: &Ray) -> [f32; 3] {
        let view = self.instance(hit);
        let triangle = view.posed.triangles.get(hit.primitive);
        offset::along(view.world_from_object(), &triangle, [hit.u, hit.v], ray).as_vec3().into()
    }

    /// A ray that leaves the surface at the place of a hit: it starts just off the triangle, on the side that the direction
    /// points to, and does not meet the triangle again. It has no end; give it one with [`Ray::with_range`].
    ///
    /// The origin is [`Snapshot::position`] moved by what rounding demands and no more: about the spacing of single precision
    /// at its coordinates, for a placed instance that of its coordinates in the space of the object on the way. Near an edge it stays on the inner side,
    /// so that closed rooms stay closed. A direction that rounding would turn into the surface is turned out of it by as much.
    /// The origin is farther off where the mesh is tested with [`Precision::Fast`](crate::Precision::Fast), by a millionth of the triangle's size.
    ///
    /// ```
    /// # use kinetree::{Affine, Mesh, Motion, Ray, Scene};
    /// # let mut scene = Scene::new();
    /// # let floor = Mesh::new(&[[-1e6, 0.0, -1e6], [0.0, 0.0, 1e6], [1e6, 0.0, -1e6]], &[[0, 1, 2]])?;
    /// # let floor = scene.add_mesh(floor, Motion::Static)?;
    /// # scene.add_instance(scene.root(), floor, Affine::IDENTITY)?;
    /// # let view = scene.commit();
    /// let hit = view.closest_hit(&Ray::new([1.0, 2.0, 3.0], [0.3, -1.0, 0.2])).ok_or("a floor")?;
    /// let toward_sun = view.leave(&hit, [0.0, 1.0, 0.0]);
    /// assert!(toward_sun.origin[1] > 0.0 && !view.occluded(&toward_sun));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// As [`Snapshot::position`].
    #[must_use]
    #[track_caller]
    pub fn leave(&self, hit: &Hit, direction: [f32; 3]) -> Ray {
        let view = self.instance(hit);
        let triangle = view.posed.triangles.get(hit.primitive);
        offset::leave(&view, view.record, (&triangle, view.posed.precision), [hit.u, hit.v], direction)
    }

    /// The normal of the triangle, unit length, world space, on the side from which its vertices run counter-clockwise. Zero for a triangle
    /// without area, which no ray hits.
    ///
    /// # Panics
    /// As [`Snapshot::position`].
    #[must_use]
    #[track_caller]
    pub fn normal(&self, hit: &Hit) -> [f32; 3] {
        let view = self.instance(hit);
        let normal = glam::Vec3::from(view.posed.triangles.get(hit.primitive).normal());
        // Brought to length one before it is transformed, so that tiny and huge triangles neither vanish nor overflow.
        let world = view.world_from_object().transform_normal(unit(normal).into());
        unit(world.into()).into()
    }

    /// The meshes of the scene, shown or not, in the order in which they were added.
    pub fn meshes(&self) -> impl ExactSizeIterator<Item = MeshView<'_>> {
        let view = |report: &crate::scene::MeshReport| MeshView {
            id: report.mesh,
            posed: &self.0.world.meshes[report.mesh.0.slot as usize],
            normals: self.0.normals_of(report.mesh.0.slot),
        };
        self.report().meshes.iter().map(view)
    }

    /// The instances of this frame.
    pub fn instances(&self) -> impl ExactSizeIterator<Item = InstanceView<'_>> {
        (0..self.0.placed.len()).map(|index| self.instance_at(index as u32))
    }

    /// An instance by its number in this frame.
    ///
    /// # Panics
    /// When there are not as many.
    pub fn instance_at(&self, index: u32) -> InstanceView<'_> {
        let record = &self.0.world.instances[index as usize];
        let posed = &self.0.world.meshes[record.mesh as usize];
        let normals = self.0.normals_of(record.mesh);
        InstanceView { index, record, placed: &self.0.placed[index as usize], posed, normals }
    }
}

/// In short: which frame, and how large it is.
impl fmt::Debug for Snapshot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Snapshot")
            .field("frame", &self.report().frame)
            .field("meshes", &self.report().meshes.len())
            .field("instances", &self.0.placed.len())
            .finish_non_exhaustive()
    }
}

/// Unit length, in double precision; zero stays zero.
fn unit(v: glam::Vec3) -> glam::Vec3 {
    v.as_dvec3().normalize_or_zero().as_vec3()
}

/// An instance as it is in one frame.
#[derive(Clone, Copy)]
pub struct InstanceView<'a> {
    index: u32,
    record: &'a InstanceRecord,
    placed: &'a PlacedInstance,
    posed: &'a MeshFrame,
    normals: &'a [[f32; 3]],
}

/// In short: which, and how large it is.
impl fmt::Debug for InstanceView<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("InstanceView")
            .field("index", &self.index)
            .field("id", &self.placed.id)
            .field("mesh_id", &self.placed.mesh)
            .field("triangles", &self.triangles().len())
            .finish_non_exhaustive()
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
        self.placed.mesh
    }

    /// The caller's own number.
    pub fn user_id(&self) -> u32 {
        self.record.user_id
    }

    /// Queries see it when their mask shares a bit with this.
    pub fn mask(&self) -> u32 {
        self.record.mask
    }

    /// Whether filters are not asked about it.
    pub fn is_opaque(&self) -> bool {
        self.record.opaque
    }

    /// How its mesh was announced to move.
    pub fn motion(&self) -> Motion {
        self.placed.motion
    }

    /// Where it stands.
    pub fn world_from_object(&self) -> &'a Affine {
        &self.placed.world_from_object
    }

    /// The way back, as rays take it; of a flat placement, for points of its plane.
    pub fn object_from_world(&self) -> &'a Affine {
        &self.record.object_from_world
    }

    /// A ray in the space of the object, by the operations of the queries: hits of it have the same `t`. `None` when
    /// it can hit nothing there, and when queries enter the instance in double precision, since it is flat or badly skewed.
    pub fn ray_in_object(&self, ray: &Ray) -> Option<Ray> {
        (!self.record.in_double).then(|| self.record.enter(ray))?
    }

    /// As posed for this frame, metres, object space.
    pub fn positions(&self) -> &'a [[f32; 3]] {
        self.posed.triangles.positions()
    }

    /// As posed for this frame, one per vertex, if there are any.
    pub fn normals(&self) -> Option<&'a [[f32; 3]]> {
        (!self.normals.is_empty()).then_some(self.normals)
    }

    /// Vertex numbers.
    pub fn triangles(&self) -> &'a [[u32; 3]] {
        self.posed.triangles.indices()
    }

    /// The tree over its triangles.
    #[doc(alias = "BLAS")]
    pub fn bvh(&self) -> &'a MeshBvh {
        &self.posed.bvh
    }
}

/// A mesh as it is in one frame, whether or not an instance shows it.
#[derive(Clone, Copy)]
pub struct MeshView<'a> {
    id: MeshId,
    posed: &'a MeshFrame,
    normals: &'a [[f32; 3]],
}

/// In short: which, and how large it is.
impl fmt::Debug for MeshView<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles = self.triangles().len();
        f.debug_struct("MeshView").field("id", &self.id).field("triangles", &triangles).finish_non_exhaustive()
    }
}

impl<'a> MeshView<'a> {
    /// Its handle in the scene.
    pub fn id(&self) -> MeshId {
        self.id
    }

    /// As posed for this frame, metres, object space.
    pub fn positions(&self) -> &'a [[f32; 3]] {
        self.posed.triangles.positions()
    }

    /// As posed for this frame, one per vertex, if there are any.
    pub fn normals(&self) -> Option<&'a [[f32; 3]]> {
        (!self.normals.is_empty()).then_some(self.normals)
    }

    /// Vertex numbers.
    pub fn triangles(&self) -> &'a [[u32; 3]] {
        self.posed.triangles.indices()
    }

    /// The tree over its triangles.
    #[doc(alias = "BLAS")]
    pub fn bvh(&self) -> &'a MeshBvh {
        &self.posed.bvh
    }
}
