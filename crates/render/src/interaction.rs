//! From a hit to a place that can be shaded: where it is, which way it faces, what it wears.

use glam::{DVec3, Vec3};
use kinetree::{Affine, Hit, InstanceView, Ray};

use crate::shading_attributes::ShadingAttributes;
use crate::{Frame, Material};

/// A place on a surface, as seen from somewhere.
#[derive(Clone, Copy)]
pub(crate) struct SurfaceInteraction<'a> {
    /// World space.
    pub(crate) position: Vec3,
    /// Where rays start that leave on the viewer's side.
    offset_origin: Vec3,
    /// Unit geometric normal, on the side of the viewer.
    pub(crate) geometric_normal: Vec3,
    /// Unit normal for shading, on the side of the viewer.
    pub(crate) shading_normal: Vec3,
    /// Whether the viewer sees the side from which the winding is counter-clockwise.
    pub(crate) front: bool,
    /// What the surface is made of.
    pub(crate) material: &'a Material,
    /// Base colour, linear RGB in 0..=1.
    pub(crate) color: Vec3,
    /// Radiance that the surface itself sends to the viewer.
    pub(crate) emission: Vec3,
    /// Dense index of the instance within the frame.
    pub(crate) instance: u32,
    /// Index of the triangle within its mesh.
    pub(crate) primitive: u32,
    frame: &'a Frame,
    hit: Hit,
}

impl<'a> SurfaceInteraction<'a> {
    /// What a ray of unit direction `direction` sees where it hits.
    pub(crate) fn new(frame: &'a Frame, hit: &Hit, direction: Vec3) -> Self {
        let instance = frame.view.instance(hit);
        let triangle = instance.triangles()[hit.primitive as usize].map(|vertex| vertex as usize);
        let corners = triangle.map(|vertex| Vec3::from(instance.positions()[vertex]));
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let winding_normal = geometric_normal(&instance, corners).unwrap_or(-direction);
        let front = winding_normal.dot(direction) <= 0.0;
        let geometric_normal = if front { winding_normal } else { -winding_normal };
        let shading_normal = shading_normal(&instance, triangle, weights, geometric_normal);

        let attributes = ShadingAttributes::at(&frame.material_set, &instance, hit.primitive, [hit.u, hit.v]);
        let emits = front || attributes.material.two_sided;
        Self {
            position: frame.view.position(hit).into(),
            offset_origin: frame.view.leave(hit, geometric_normal.into()).origin.into(),
            geometric_normal,
            shading_normal,
            front,
            material: attributes.material,
            color: attributes.base_color(),
            emission: if emits { attributes.emission() } else { Vec3::ZERO },
            instance: hit.instance_index(),
            primitive: hit.primitive,
            frame,
            hit: *hit,
        }
    }

    /// The ray in a unit direction, out to a distance.
    pub(crate) fn ray(&self, direction: Vec3, distance: f32) -> Ray {
        Ray::new(self.origin(direction).into(), direction.into()).with_range(0.0, distance)
    }

    /// Where a ray in a direction starts: just off the surface, on the side that the direction points to.
    pub(crate) fn origin(&self, direction: Vec3) -> Vec3 {
        if self.geometric_normal.dot(direction) < 0.0 {
            self.frame.view.leave(&self.hit, (-self.geometric_normal).into()).origin.into()
        } else {
            self.offset_origin
        }
    }
}

/// A weighted sum of three vectors.
fn blend(corners: [Vec3; 3], weights: [f32; 3]) -> Vec3 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

/// A normal of the object in the world, of length one; `None` when nothing is left of it.
fn placed_normal(world_from_object: &Affine, normal: DVec3) -> Option<Vec3> {
    // Brought to a moderate size first, so that it neither vanishes nor overflows in single precision.
    let normal = normal / normal.abs().max_element();
    let world = Vec3::from(world_from_object.transform_normal(normal.as_vec3().into()));
    Some(world.as_dvec3().normalize().as_vec3()).filter(|unit| unit.is_finite())
}

/// Unit normal in the world, on the side from which the corners run counter-clockwise; `None` for a triangle without area.
/// In double precision, where the products of `f32` edges neither vanish nor overflow.
pub(crate) fn geometric_normal(instance: &InstanceView<'_>, [a, b, c]: [Vec3; 3]) -> Option<Vec3> {
    let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
    placed_normal(instance.world_from_object(), (b - a).cross(c - a))
}

/// The least cosine between the normals for shading and of the geometry: beyond, the mesh's normals are of no use.
const MIN_COSINE: f32 = 0.01;

/// The mesh's own normals blended, where it has any that make sense, on the side of `facing`.
fn shading_normal(
    instance: &InstanceView<'_>,
    triangle: [usize; 3],
    weights: [f32; 3],
    geometric_normal: Vec3,
) -> Vec3 {
    let Some(normals) = instance.normals() else { return geometric_normal };
    let local = blend(triangle.map(|vertex| Vec3::from(normals[vertex])), weights);
    let Some(normal) = placed_normal(instance.world_from_object(), local.as_dvec3()) else { return geometric_normal };
    let cosine = normal.dot(geometric_normal);
    if cosine.abs() < MIN_COSINE {
        geometric_normal
    } else if cosine < 0.0 {
        -normal
    } else {
        normal
    }
}
