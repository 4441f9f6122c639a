//! Sampled triangles of a frame, which represent its surfaces.

use glam::Vec3;
use kinetree_world::Frame;

/// The approximate number of triangles that are sampled.
const SAMPLES: usize = 20_000;

/// A triangle that represents its neighbours in the order of the mesh.
pub(super) struct Sample {
    /// Dense index of its instance.
    pub(super) instance: u32,
    /// World space.
    pub(super) corners: [Vec3; 3],
    /// World space.
    pub(super) center: Vec3,
    /// Square metres.
    pub(super) area: f64,
    /// The number of triangles that it represents.
    pub(super) represents: f64,
}

/// Samples triangles at a constant stride through all instances, in order, without those that have
/// no area.
pub(super) fn samples(frame: &Frame) -> Vec<Sample> {
    let total: usize = frame.snapshot.instances().map(|instance| instance.triangles().len()).sum();
    let stride = total.div_ceil(SAMPLES).max(1);
    let mut samples = Vec::new();
    // Index of the next sample, counted from the first triangle of the instance.
    let mut next = 0;
    for instance in frame.snapshot.instances() {
        let (triangles, placement) = (instance.triangles(), instance.world_from_object());
        while next < triangles.len() {
            let corners = triangles[next]
                .map(|vertex| Vec3::from(placement.transform_point(instance.positions()[vertex as usize])));
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let (center, area) = ((a + b + c) / 3.0, 0.5 * (b - a).cross(c - a).length());
            if center.is_finite() && area.is_finite() && area > 0.0 {
                let (instance, center) = (instance.index(), center.as_vec3());
                samples.push(Sample { instance, corners, center, area, represents: stride as f64 });
            }
            next += stride;
        }
        next -= triangles.len();
    }
    samples
}

/// The bounding box of points.
pub(super) fn bounding_box(points: &[Vec3]) -> (Vec3, Vec3) {
    points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), &point| (min.min(point), max.max(point)))
}
