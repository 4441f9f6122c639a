//! What a hit says about its frame: the instance, the mesh, the point, the normal, and a ray that
//! goes on from there.

use super::error::ForeignHit;
use super::offset;
use super::snapshot::Snapshot;
use super::views::InstanceView;
use crate::geometry::Ray;
use crate::handle::{InstanceId, MeshId};
use crate::query::Hit;

impl Snapshot {
    /// The instance that was hit.
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

    /// The instance that was hit, if the hit is of this frame.
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
        if hit.stamp() == self.stamp() { Ok(self.instance_at(hit.instance_index())) } else { Err(ForeignHit) }
    }

    /// The handle of the instance that was hit.
    ///
    /// # Panics
    /// As [`Snapshot::instance`].
    #[track_caller]
    pub fn instance_id(&self, hit: &Hit) -> InstanceId {
        self.instance(hit).id()
    }

    /// The handle of the mesh that was hit.
    ///
    /// # Panics
    /// As [`Snapshot::instance`].
    #[track_caller]
    pub fn mesh_id(&self, hit: &Hit) -> MeshId {
        self.instance(hit).mesh_id()
    }

    /// The user id of the instance that was hit: the caller's own number, or 0.
    ///
    /// # Panics
    /// As [`Snapshot::instance`].
    #[track_caller]
    pub fn user_id(&self, hit: &Hit) -> u32 {
        self.instance(hit).user_id()
    }

    /// The point that was hit, metres, world space: the corners weighted by `u` and `v`, in double
    /// precision and rounded once. Its distance from the plane of the triangle is no more than that
    /// rounding. Along the plane it is as exact as the weights, to within 2^-23 of the triangle's
    /// longest edge; on triangles that are much larger than the distance to the hit,
    /// [`Snapshot::position_along`] is more exact.
    ///
    /// # Panics
    /// As [`Snapshot::instance`]; also when `primitive` was changed to a number that the mesh does
    /// not have.
    #[must_use]
    #[track_caller]
    pub fn position(&self, hit: &Hit) -> [f32; 3] {
        let view = self.instance(hit);
        let triangle = view.triangle(hit);
        offset::to_world(view.world_from_object(), offset::point_at(&triangle, hit.u, hit.v)).as_vec3().into()
    }

    /// The point where a ray met the triangle of its hit, metres, world space: on the ray and in
    /// the plane of the triangle, computed in double precision and rounded once. Exact to single
    /// precision, unless the ray runs nearly along the plane. Never farther from
    /// [`Snapshot::position`] than the error of that.
    ///
    /// # Panics
    /// As [`Snapshot::position`].
    #[must_use]
    #[track_caller]
    pub fn position_along(&self, hit: &Hit, ray: &Ray) -> [f32; 3] {
        let view = self.instance(hit);
        let triangle = view.triangle(hit);
        offset::along(view.world_from_object(), &triangle, [hit.u, hit.v], ray).as_vec3().into()
    }

    /// A ray that leaves the surface at the point that was hit: it starts just off the triangle, on
    /// the side that the direction points to, and does not meet the triangle again. It has no end;
    /// give it one with [`Ray::with_range`].
    ///
    /// The origin is [`Snapshot::position`], moved by what rounding demands and no more: about the
    /// spacing of single precision at its coordinates, and for a transformed instance at its
    /// coordinates in object space too. Near an edge it stays on the inner side, so that closed
    /// rooms stay closed. A direction that rounding would turn into the surface is turned out of it
    /// by as much. The origin is farther off where the mesh is tested with
    /// [`Precision::Fast`](crate::Precision::Fast), by a millionth of the triangle's size.
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
        let triangle = view.triangle(hit);
        let triangle = (&triangle, view.precision());
        offset::leave(view.world_from_object(), view.record, triangle, [hit.u, hit.v], direction)
    }

    /// The normal of the triangle, unit length, world space, on the side from which its vertices
    /// run counter-clockwise. Zero for a triangle without area, which no ray hits.
    ///
    /// # Panics
    /// As [`Snapshot::position`].
    #[must_use]
    #[track_caller]
    pub fn normal(&self, hit: &Hit) -> [f32; 3] {
        let view = self.instance(hit);
        let normal = glam::Vec3::from(view.triangle(hit).normal());
        // Normalised before it is transformed, so that tiny and huge triangles neither vanish nor
        // overflow.
        let world = view.world_from_object().transform_normal(unit(normal).into());
        unit(world.into()).into()
    }
}

/// Unit length, in double precision; zero stays zero.
fn unit(v: glam::Vec3) -> glam::Vec3 {
    v.as_dvec3().normalize_or_zero().as_vec3()
}
