//! Where an instance stands, in one cache line.

use crate::geometry::{Affine, Ray};

/// All that a ray needs to enter an instance.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct InstanceRecord {
    /// Takes rays from the world to the mesh.
    pub object_from_world: Affine,
    /// Which mesh.
    pub mesh: u32,
    /// Seen by queries whose mask shares a bit with this.
    pub mask: u32,
    /// The caller's own number.
    pub user_id: u32,
    /// Filters are not asked about an opaque instance.
    pub opaque: bool,
    /// The mesh stands where it was made: rays need not be transformed.
    pub identity: bool,
    /// Rays enter in double precision, since the placement is flat or badly skewed.
    pub in_double: bool,
}

const _: () = assert!(size_of::<InstanceRecord>() == 64);

impl InstanceRecord {
    /// The ray in the space of the mesh. Its direction is not renormalised, so `t` means the same in both spaces. `None` when nothing can be hit.
    pub(crate) fn enter(&self, ray: &Ray) -> Option<Ray> {
        if self.identity {
            return Some(*ray);
        }
        let origin = self.object_from_world.transform_point(ray.origin);
        let direction = self.object_from_world.transform_vector(ray.direction);
        Ray { origin, direction, ..*ray }.validated()
    }
}
