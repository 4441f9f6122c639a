//! From a hit to what shading needs: position, normals, material, colours.
//!
//! "Viewer" is where the ray came from: the camera, or the previous vertex of a path.

use glam::{DVec3, Vec3};
use kinetree::{Affine, Hit, InstanceView, Ray};
use kinetree_world::{Frame, Material};

use crate::shading_attributes::ShadingAttributes;

/// A point on a surface that a ray has hit, with all that shading needs.
#[derive(Clone, Copy)]
pub(crate) struct SurfaceInteraction<'a> {
    /// World space.
    pub(crate) position: Vec3,
    /// The origin of rays that leave on the viewer's side, world space.
    viewer_side_origin: Vec3,
    /// Unit normal of the triangle, on the side of the viewer, world space.
    pub(crate) geometric_normal: Vec3,
    /// Unit interpolated normal, on the side of the viewer, world space.
    pub(crate) shading_normal: Vec3,
    /// Whether the viewer sees the side from which the winding is counter-clockwise.
    pub(crate) front: bool,
    /// The material of the triangle.
    pub(crate) material: &'a Material,
    /// Base colour, linear RGB in 0..=1.
    pub(crate) color: Vec3,
    /// Radiance emitted towards the viewer, linear RGB.
    pub(crate) emission: Vec3,
    /// Dense index of the instance within the frame.
    pub(crate) instance: u32,
    /// Index of the triangle within its mesh.
    pub(crate) primitive: u32,
    frame: &'a Frame,
    hit: Hit,
}

impl<'a> SurfaceInteraction<'a> {
    /// For a hit of a ray of unit direction `direction`.
    pub(crate) fn new(frame: &'a Frame, hit: &Hit, direction: Vec3) -> Self {
        let instance = frame.snapshot.instance(hit);
        let triangle = instance.triangles()[hit.primitive as usize].map(|vertex| vertex as usize);
        let corners = triangle.map(|vertex| Vec3::from(instance.positions()[vertex]));
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let winding_normal = geometric_normal(&instance, corners).unwrap_or(-direction);
        let front = winding_normal.dot(direction) <= 0.0;
        let geometric_normal = if front { winding_normal } else { -winding_normal };
        let shading_normal = shading_normal(&instance, triangle, weights, geometric_normal);

        let attributes = ShadingAttributes::at(frame, &instance, hit.primitive, [hit.u, hit.v]);
        let emits = front || attributes.material.two_sided;
        Self {
            position: frame.snapshot.position(hit).into(),
            viewer_side_origin: frame.snapshot.leave(hit, geometric_normal.into()).origin.into(),
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

    /// A ray that leaves in a unit direction, up to a distance in metres.
    pub(crate) fn ray(&self, direction: Vec3, distance: f32) -> Ray {
        Ray::new(self.offset_origin(direction).into(), direction.into()).with_range(0.0, distance)
    }

    /// The origin of a ray that leaves in a direction: off the surface, on the side of the
    /// direction, so that the ray does not hit the triangle again.
    pub(crate) fn offset_origin(&self, direction: Vec3) -> Vec3 {
        if self.geometric_normal.dot(direction) < 0.0 {
            self.frame.snapshot.leave(&self.hit, (-self.geometric_normal).into()).origin.into()
        } else {
            self.viewer_side_origin
        }
    }
}

/// The vertex values interpolated by barycentric weights.
fn interpolate(corners: [Vec3; 3], weights: [f32; 3]) -> Vec3 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

/// An object-space normal as a unit vector in world space; `None` if it vanishes or is not finite.
fn placed_normal(world_from_object: &Affine, normal: DVec3) -> Option<Vec3> {
    // Normalised first, so that it neither underflows nor overflows in single precision.
    let normal = normal / normal.abs().max_element();
    let world = Vec3::from(world_from_object.transform_normal(normal.as_vec3().into()));
    Some(world.as_dvec3().normalize().as_vec3()).filter(|unit| unit.is_finite())
}

/// Unit normal in world space, on the side from which the vertices run counter-clockwise; `None`
/// for a triangle without area. Computed in double precision, where products of `f32` edges neither
/// underflow nor overflow.
pub(crate) fn geometric_normal(instance: &InstanceView<'_>, [a, b, c]: [Vec3; 3]) -> Option<Vec3> {
    let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
    placed_normal(instance.world_from_object(), (b - a).cross(c - a))
}

/// The smallest cosine between an interpolated normal and the geometric one for which the former is
/// used.
const MIN_COSINE: f32 = 0.01;

/// The interpolated vertex normal on the side of `geometric_normal`, or that normal itself if the
/// mesh has no usable normals.
fn shading_normal(
    instance: &InstanceView<'_>,
    triangle: [usize; 3],
    weights: [f32; 3],
    geometric_normal: Vec3,
) -> Vec3 {
    let Some(normals) = instance.normals() else { return geometric_normal };
    let local = interpolate(triangle.map(|vertex| Vec3::from(normals[vertex])), weights);
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
