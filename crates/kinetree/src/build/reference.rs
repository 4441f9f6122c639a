//! References to primitives, which builders partition.

use glam::Vec3A;

use crate::geometry::Aabb;
use crate::memory::{ChunkWriter, fill_in_chunks, vec_in_large_pages};
use crate::threads::Threads;

/// A primitive's index and box. The size is two whole 16-byte vectors: a copy of 28 bytes would use
/// two overlapping stores, and a load right after it would miss store forwarding (decision 13).
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(16))]
pub(crate) struct Reference {
    pub(crate) bounds: Aabb,
    pub(crate) id: u32,
    rest: u32,
}

const _: () = assert!(size_of::<Reference>() == 32);

impl Reference {
    #[inline(always)]
    pub(crate) fn new(bounds: Aabb, id: u32) -> Self {
        Self { bounds, id, rest: 0 }
    }

    /// The corners of the box, and two unused lanes.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> &[f32; 8] {
        bytemuck::cast_ref(self)
    }

    #[inline]
    pub(crate) fn center(&self, axis: usize) -> f32 {
        self.bounds.min[axis] * 0.5 + self.bounds.max[axis] * 0.5
    }
}

/// References per parallel task.
pub(crate) const GRAIN: usize = 16 * 1024;

/// References to primitives 0 to `count - 1`, with spare capacity for `more`. Primitives with an
/// empty box are left out.
pub(crate) fn references(
    count: usize,
    more: usize,
    bounds_of: &(impl Fn(u32) -> Aabb + Sync),
    threads: &Threads,
) -> Vec<Reference> {
    let write = |first: usize, chunk: &mut ChunkWriter<'_, Reference>| {
        for id in first as u32..(first + chunk.size()) as u32 {
            chunk.push(Reference::new(bounds_of(id), id));
        }
    };
    let (mut all, _) = fill_in_chunks(vec_in_large_pages(count + more), count, GRAIN, threads, &write);
    all.retain(|reference| !reference.bounds.is_empty());
    all
}

/// The bounding box of references.
pub(crate) fn bounds_of(references: &[Reference], threads: &Threads) -> Aabb {
    let around = |chunk: &[Reference]| {
        let (mut min, mut max) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        for reference in chunk {
            min = min.min(reference.bounds.min.into());
            max = max.max(reference.bounds.max.into());
        }
        Aabb::new(min.into(), max.into())
    };
    threads.reduce(references, GRAIN, &around, &|a, b| a.union(&b))
}
