//! Instances that rays do not see, whatever else a query asks for.

use crate::handle::Placed;
use crate::traverse::{FrameBvh, InstanceInterval};

/// What is left out: for all rays, and for each ray of a batch.
#[derive(Clone, Copy, Default)]
pub(super) struct Without<'a> {
    pub(super) all_rays: InstanceInterval,
    pub(super) each_ray: Option<&'a [Placed]>,
}

impl Without<'_> {
    #[inline(always)]
    pub(super) fn is_nothing(&self) -> bool {
        self.all_rays.is_empty() && self.each_ray.is_none()
    }

    /// Whether a ray of a batch sees an instance.
    pub(super) fn is_seen(&self, world: &FrameBvh, instance: u32, ray: u32) -> bool {
        let number = world.numbers[instance as usize];
        let excluded = |each: &[Placed]| world.hierarchy.interval_of(each[ray as usize]).contains(number);
        !self.all_rays.contains(number) && !self.each_ray.is_some_and(excluded)
    }

    /// Those rays of a packet that see an instance.
    pub(super) fn seeing(&self, world: &FrameBvh, instance: u32, first_ray: usize, set: u64) -> u64 {
        if self.each_ray.is_none() {
            return if self.is_seen(world, instance, 0) { set } else { 0 };
        }
        let sees = |at: &u32| set >> at & 1 == 1 && self.is_seen(world, instance, first_ray as u32 + at);
        (0..u64::BITS).filter(sees).fold(0, |seeing, at| seeing | 1 << at)
    }
}
