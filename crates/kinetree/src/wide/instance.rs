//! Instance records: the placement of an instance, in one cache line.

use crate::geometry::{Affine, Ray};

/// The data that a ray needs to enter an instance.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct InstanceRecord {
    /// The transform of rays from world space to the mesh's space.
    pub object_from_world: Affine,
    /// The index of the mesh.
    pub mesh: u32,
    /// Visible to queries whose mask has a bit in common with this.
    pub mask: u32,
    /// The caller's id.
    pub user_id: u32,
    /// Filters are not called for an opaque instance.
    pub opaque: bool,
    /// The transform is the identity, so rays are not transformed.
    pub identity: bool,
    /// Rays are transformed in double precision, because the placement is flat or ill-conditioned.
    pub in_double: bool,
}

const _: () = assert!(size_of::<InstanceRecord>() == 64);

impl InstanceRecord {
    /// The ray in the mesh's space. Its direction is not normalised, so `t` is the same in both
    /// spaces. `None` if the transformed ray cannot hit anything.
    pub(crate) fn enter(&self, ray: &Ray) -> Option<Ray> {
        if self.identity {
            return Some(*ray);
        }
        let origin = self.object_from_world.transform_point(ray.origin);
        let direction = self.object_from_world.transform_vector(ray.direction);
        Ray { origin, direction, ..*ray }.validated()
    }
}
