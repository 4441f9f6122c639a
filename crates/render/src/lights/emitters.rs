//! Emissive triangles as area lights: finding them, sampling points on them, and the pdf.

use std::f32::consts::PI;

use glam::Vec3;
use kinetree::{InstanceView, Ray};
use kinetree_world::{Frame, Surface};

use super::LightSample;
use crate::color::luminance;
use crate::interaction::geometric_normal;
use crate::shading_attributes::ShadingAttributes;
use crate::warp;

/// An emissive triangle in world space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Emitter {
    /// Dense index of the instance.
    pub(super) instance: u32,
    /// Index of the triangle in its mesh.
    pub(super) primitive: u32,
    corners: [Vec3; 3],
    /// Unit normal, on the side from which the vertices run counter-clockwise.
    normal: Vec3,
    /// Square metres.
    pub(super) area: f32,
    /// Luminance of the emitted flux, of both sides if both emit.
    pub(super) power: f32,
}

/// All emissive triangles of a frame, by ascending instance and primitive.
pub(super) fn collect(frame: &Frame) -> Vec<Emitter> {
    let emits = |material: u32| {
        frame.material_set.materials.get(material as usize).is_some_and(|material| material.is_emissive())
    };
    let mut emitters = Vec::new();
    for instance in frame.snapshot.instances() {
        let Some(surface) = frame.surface(instance.index()) else { continue };
        let count = instance.triangles().len() as u32;
        for (run, material) in runs(surface, count) {
            if emits(material) {
                emitters.extend(run.filter_map(|primitive| Emitter::new(frame, &instance, primitive)));
            }
        }
    }
    emitters.sort_unstable_by_key(|emitter| (emitter.instance, emitter.primitive));
    emitters
}

/// The ranges of triangles with the same material, and that material.
fn runs(surface: &Surface, count: u32) -> impl Iterator<Item = (std::ops::Range<u32>, u32)> + '_ {
    let ends = surface.parts.iter().skip(1).map(|part| part.first_triangle).chain([count]);
    surface.parts.iter().zip(ends).map(move |(part, end)| (part.first_triangle..end.min(count), part.material))
}

/// Rows of the triangular grid of points at which emission and opacity are evaluated to estimate a
/// triangle's power.
const PROBES: u32 = 4;

impl Emitter {
    /// `None` for a triangle without power: without area, or black wherever its texture was
    /// evaluated.
    fn new(frame: &Frame, instance: &InstanceView<'_>, primitive: u32) -> Option<Self> {
        let local =
            instance.triangles()[primitive as usize].map(|vertex| Vec3::from(instance.positions()[vertex as usize]));
        let placement = instance.world_from_object();
        let corners = local.map(|corner| Vec3::from(placement.transform_point(corner.into())));
        let normal = geometric_normal(instance, local)?;
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let area = (0.5 * (b - a).cross(c - a).length()) as f32;

        let mut emitted = 0.0;
        for row in 0..PROBES {
            for column in 0..PROBES - row {
                let at = [(row as f32 + 1.0 / 3.0) / PROBES as f32, (column as f32 + 1.0 / 3.0) / PROBES as f32];
                let attributes = ShadingAttributes::at(frame, instance, primitive, at);
                emitted += luminance(attributes.emission()) * attributes.opacity();
            }
        }
        let sides =
            if ShadingAttributes::at(frame, instance, primitive, [0.3; 2]).material.two_sided { 2.0 } else { 1.0 };
        let power = emitted / (PROBES * (PROBES + 1) / 2) as f32 * area * PI * sides;
        (power > 0.0 && power.is_finite()).then_some(Self {
            instance: instance.index(),
            primitive,
            corners,
            normal,
            area,
            power,
        })
    }

    /// Pdf per steradian, seen from `from`, of a point `at` that is sampled uniformly by area. Zero
    /// for a triangle that is seen edge on.
    pub(super) fn pdf(&self, from: Vec3, at: Vec3) -> f32 {
        let offset = at - from;
        let squared = offset.length_squared();
        let cosine = (self.normal.dot(offset) / squared.sqrt()).abs();
        let pdf = squared / (cosine * self.area);
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// Samples a point of the triangle uniformly by area.
    pub(super) fn sample(&self, frame: &Frame, from: Vec3, u: [f32; 2]) -> Option<LightSample> {
        let [v, w] = warp::triangle(u.into());
        let [a, b, c] = self.corners;
        let at = a * (1.0 - v - w) + b * v + c * w;
        let front = self.normal.dot(from - at) > 0.0;
        let instance = frame.snapshot.instance_at(self.instance);
        let attributes = ShadingAttributes::at(frame, &instance, self.primitive, [v, w]);
        if !front && !attributes.material.two_sided {
            return None;
        }
        let pdf = self.pdf(from, at);
        let direction = (at - from).normalize();
        let ray = Ray::new(from.into(), direction.into());
        let distance = distance_to(&instance, self.primitive, self.corners, &ray)? * SHADOW_RAY_END;
        let radiance = attributes.emission() * attributes.opacity();
        (pdf > 0.0 && distance > 0.0).then_some(LightSample { direction, distance, radiance, pdf, is_delta: false })
    }
}

/// Shadow rays end at this part of the distance to an emissive triangle, so that they do not hit
/// the triangle itself: distances of queries have a relative error of about 2^-22. Occluders within
/// the last 2^-18 of the distance are missed.
const SHADOW_RAY_END: f32 = 1.0 - 1.0 / (1 << 18) as f32;

/// The same where the object-space ray of queries is not available, and the distance is computed in
/// world space.
const WORLD_SHADOW_RAY_END: f64 = 1.0 - 1e-5;

/// The distance along a ray to the plane of a triangle as a query computes it: from the ray that
/// the query transforms into object space. The direction is rounded, and for a triangle that is
/// seen at a grazing angle the distance depends on that rounding.
fn distance_to(instance: &InstanceView<'_>, primitive: u32, corners: [Vec3; 3], ray: &Ray) -> Option<f32> {
    let distance = match instance.ray_in_object(ray) {
        Some(local) => {
            let local_corners =
                instance.triangles()[primitive as usize].map(|vertex| instance.positions()[vertex as usize]);
            distance_to_plane(local_corners, &local)
        }
        None => distance_to_plane(corners.map(Vec3::into), ray) * WORLD_SHADOW_RAY_END,
    };
    distance.is_finite().then_some(distance as f32)
}

fn distance_to_plane(corners: [[f32; 3]; 3], ray: &Ray) -> f64 {
    let wide = |vector: [f32; 3]| Vec3::from(vector).as_dvec3();
    let [a, b, c] = corners.map(wide);
    let normal = (b - a).cross(c - a);
    normal.dot(a - wide(ray.origin)) / normal.dot(wide(ray.direction))
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinetree_world::Part;

    #[test]
    fn runs_end_where_the_next_begins_or_the_mesh_does() {
        let part = |first_triangle, material| Part { first_triangle, material };
        let surface = Surface { parts: vec![part(0, 3), part(4, 1), part(9, 2)], ..Surface::default() };
        let all: Vec<_> = runs(&surface, 6).collect();
        assert_eq!(all[0], (0..4, 3));
        assert_eq!(all[1], (4..6, 1));
        assert!(all[2].0.is_empty());
    }
}
