//! A better order for rays that have nothing in common: those that start and go alike one after another, so that they find in the caches what the one before
//! fetched.
//!
//! Sorted by octant, then by origin along a Morton curve, then by direction.

use crate::geometry::{Aabb, Ray};
use crate::traverse::TwoLevel;

/// Fewer rays than this meet too few others of their kind.
const LEAST_RAYS: usize = 4096;

/// Trees below this many bytes stay in the caches near a core, and order does not matter.
const LEAST_TREE: usize = 8 << 20;

/// How many rays are sorted together. What is needed for it stays in the second cache, and large batches need no large buffers.
pub(crate) const BLOCK: usize = 1 << 16;

/// How many rays are fetched together: they stay in the first cache.
pub(crate) const FETCHED: usize = 256;

/// Whether the order may pay.
pub(crate) fn is_worth_while(world: &TwoLevel, rays: usize) -> bool {
    rays >= LEAST_RAYS && world.meshes.iter().map(|mesh| mesh.bvh.memory()).sum::<usize>() > LEAST_TREE
}

/// A ray's key in the upper half, its number in the lower half.
#[derive(Clone, Copy, Default)]
pub(crate) struct Place(u64);

impl Place {
    /// Number of the ray.
    #[inline(always)]
    pub(crate) fn ray(self) -> usize {
        self.0 as u32 as usize
    }
}

/// Sorts rays, block by block, in the same memory.
pub(crate) struct Sorter {
    bounds: Aabb,
    places: Vec<Place>,
    spare: Vec<Place>,
}

impl Sorter {
    /// For rays in a scene within these bounds.
    pub(crate) fn new(bounds: Aabb) -> Self {
        Self { bounds, places: Vec::new(), spare: Vec::new() }
    }

    /// In which order the rays are best traced. There are at most [`BLOCK`].
    pub(crate) fn order(&mut self, rays: &[Ray]) -> &[Place] {
        let Self { bounds, places, spare } = self;
        places.clear();
        places.extend(rays.iter().zip(0..).map(|(ray, number)| Place(u64::from(key(ray, bounds)) << 32 | number)));
        spare.resize(places.len(), Place::default());
        for shift in [32, 43, 54] {
            pass(places, spare, shift);
            std::mem::swap(places, spare);
        }
        places
    }
}

/// Eleven bits of a radix sort: stable, so that the passes before count for what is equal in this one.
fn pass(from: &[Place], to: &mut [Place], shift: u32) {
    let digit = |entry: Place| (entry.0 >> shift & 0x7ff) as usize;
    let mut starts = [0_usize; 0x801];
    from.iter().for_each(|&entry| starts[digit(entry) + 1] += 1);
    for at in 1..starts.len() {
        starts[at] += starts[at - 1];
    }
    for &entry in from {
        let place = &mut starts[digit(entry)];
        to[*place] = entry;
        *place += 1;
    }
}

/// Three bits of octant, 21 of origin, eight of direction. What is no number counts as zero.
fn key(ray: &Ray, bounds: &Aabb) -> u32 {
    let octant = (0..3).fold(0, |bits, axis| bits | u32::from(ray.direction[axis].is_sign_negative()) << axis);
    let origin = (0..3).fold(0, |bits, axis| {
        let part = (ray.origin[axis] - bounds.min[axis]) / (bounds.max[axis] - bounds.min[axis]);
        // Casts saturate.
        bits | spread(((part * 128.0) as u32).min(127)) << axis
    });
    let [x, y, z] = ray.direction.map(f32::abs);
    let sum = x + y + z;
    let direction = ((x / sum * 16.0) as u32).min(15) << 4 | ((y / sum * 16.0) as u32).min(15);
    octant << 29 | origin << 8 | direction
}

/// Seven bits, two places between each.
fn spread(x: u32) -> u32 {
    (0..7).fold(0, |bits, at| bits | (x >> at & 1) << (3 * at))
}
