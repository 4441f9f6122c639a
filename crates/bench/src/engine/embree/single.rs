//! Calls with one ray each.

use super::api::{Api, Arguments, Handle, INVALID, RtcRay, RtcRayHit};
use super::denormals::NoDenormals;
use crate::ray::{Answer, Ray};

#[inline]
fn engine_ray(ray: &Ray) -> RtcRay {
    let Ray { origin, t_max, direction } = *ray;
    RtcRay { origin, t_near: 0.0, direction, time: 0.0, t_far: t_max, mask: u32::MAX, id: 0, flags: 0 }
}

/// The nearest hits in a committed scene, one call per ray.
pub(super) fn closest(api: &Api, scene: Handle, rays: &[Ray], answers: &mut [Answer]) {
    let _no_denormals = NoDenormals::begin();
    let intersect = api.intersect1;
    let no_arguments: *mut Arguments = std::ptr::null_mut();
    for (ray, slot) in rays.iter().zip(answers) {
        let mut query = RtcRayHit {
            ray: engine_ray(ray),
            normal: [0.0; 3],
            u: 0.0,
            v: 0.0,
            primitive: INVALID,
            geometry: INVALID,
            instances: [INVALID; 5],
        };
        // SAFETY: the scene is committed, the ray has the layout and alignment of `RTCRayHit`, and
        // null selects the default arguments.
        unsafe { intersect(scene, (&raw mut query).cast(), no_arguments) };
        let RtcRayHit { u, v, primitive, geometry: mesh, .. } = query;
        *slot = if mesh == INVALID { Answer::MISS } else { Answer { t: query.ray.t_far, u, v, primitive, mesh } };
    }
}

/// Whether there is any hit in a committed scene, one call per ray.
pub(super) fn occluded(api: &Api, scene: Handle, rays: &[Ray], answers: &mut [bool]) {
    let _no_denormals = NoDenormals::begin();
    let occluded = api.occluded1;
    for (ray, slot) in rays.iter().zip(answers) {
        let mut query = engine_ray(ray);
        // SAFETY: as in `closest`; the ray has the layout and alignment of `RTCRay`.
        unsafe { occluded(scene, (&raw mut query).cast(), std::ptr::null_mut()) };
        // Embree marks an occluded ray by the distance minus infinity.
        *slot = query.t_far < 0.0;
    }
}
