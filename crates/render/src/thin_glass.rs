//! Bounds of all thin glass in a frame. A shadow ray that is blocked and misses these boxes is
//! blocked by something opaque, so its closest hit need not be found.

use glam::{DVec3, Vec3};
use kinetree::{Aabb, Ray};
use kinetree_world::{Frame, Scatter};

/// More boxes than this are merged into one.
const MAX_BOXES: usize = 16;

/// By how much boxes are enlarged, relative to the largest coordinate of box and ray origin: far
/// more than the error of a hit.
const MARGIN: f64 = 1e-4;

/// World-space boxes around all triangles whose material is thin glass.
#[derive(Debug, Default)]
pub(crate) struct ThinGlass {
    boxes: Vec<Aabb>,
}

impl ThinGlass {
    /// Finds them in all instances, in time proportional to the triangles of those that have any
    /// thin glass.
    pub(crate) fn new(frame: &Frame) -> Self {
        let materials = &frame.material_set.materials;
        let is_thin_glass = |material: Option<u32>| {
            let material = material.and_then(|id| materials.get(id as usize));
            material.is_some_and(|material| matches!(material.scatter, Scatter::ThinDielectric { .. }))
        };
        let mut boxes = Vec::new();
        for instance in frame.snapshot.instances() {
            let Some(surface) = frame.surface(instance.index()) else { continue };
            if !surface.parts.iter().any(|part| is_thin_glass(Some(part.material))) {
                continue;
            }
            let triangles =
                (0_u32..).zip(instance.triangles()).filter(|&(number, _)| is_thin_glass(surface.material_of(number)));
            let corners =
                triangles.flat_map(|(_, corners)| corners.map(|corner| instance.positions()[corner as usize]));
            let bounds = Aabb::from_points(corners.map(|corner| instance.world_from_object().transform_point(corner)));
            if !bounds.is_empty() {
                boxes.push(bounds);
            }
        }
        if boxes.len() > MAX_BOXES {
            boxes = boxes.iter().copied().reduce(|all, one| all.union(&one)).into_iter().collect();
        }
        Self { boxes }
    }

    /// Whether a ray may hit thin glass: conservative, `false` means that it does not.
    pub(crate) fn may_intersect(&self, ray: &Ray) -> bool {
        self.boxes.iter().any(|bounds| may_intersect_box(ray, bounds))
    }
}

/// Conservative slab test in double precision; an axis whose slab gives NaN does not restrict the
/// interval.
fn may_intersect_box(ray: &Ray, bounds: &Aabb) -> bool {
    let wide = |vector: [f32; 3]| Vec3::from(vector).as_dvec3();
    let (origin, direction) = (wide(ray.origin), wide(ray.direction));
    let (low, high) = (wide(bounds.min), wide(bounds.max));
    let margin = DVec3::splat(MARGIN * origin.abs().max(low.abs()).max(high.abs()).max_element());
    let (low, high) = (low - margin - origin, high + margin - origin);
    let (mut entry, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let (one, other) = (low[axis] / direction[axis], high[axis] / direction[axis]);
        if !one.is_nan() && !other.is_nan() {
            entry = entry.max(one.min(other));
            exit = exit.min(one.max(other));
        }
    }
    let reach = f64::from(ray.t_max) * (1.0 + MARGIN);
    !(entry > exit || exit < 0.0 || entry > reach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::unit_hash;

    #[test]
    fn a_ray_to_a_point_in_a_box_is_never_ruled_out() {
        let vector = |seed: u32| Vec3::new(unit_hash(seed), unit_hash(seed ^ 0x100), unit_hash(seed ^ 0x200)) - 0.5;
        let mut missed = 0;
        for seed in (0..30_000).map(|seed| seed * 0x1000) {
            let (low, size) = (vector(seed) * 8.0, vector(seed + 1).abs() * Vec3::new(1.0, 1.0, (seed % 2) as f32));
            let bounds = Aabb::new(low.into(), (low + size).into());
            let (origin, target) = (vector(seed + 2) * 1e3, low + size * (vector(seed + 3) + 0.5));
            let ray = Ray::new(origin.into(), (target - origin).normalize().into());
            let ray = ray.with_range(0.0, origin.distance(target));
            assert!(may_intersect_box(&ray, &bounds), "seed {seed}");
            let short = ray.with_range(0.0, 0.5 * ray.t_max);
            missed += usize::from(!may_intersect_box(&short, &bounds));
            missed +=
                usize::from(!may_intersect_box(&Ray::new(ray.origin, vector(seed + 4).normalize().into()), &bounds));
        }
        assert!(missed > 50_000, "{missed}");
        let flat = Aabb::new([0.0; 3], [1.0, 1.0, 0.0]);
        assert!(
            may_intersect_box(&Ray::new([0.0; 3], [1.0, 0.0, 0.0]), &flat)
                && may_intersect_box(&Ray::new([f32::NAN; 3], [1.0; 3]), &flat)
        );
    }
}
