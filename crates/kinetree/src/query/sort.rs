//! A better order for incoherent rays: those with similar origins and directions follow each other,
//! so that one finds in the caches what the one before fetched.
//!
//! Rays are sorted by origin along a Morton curve, then by octant, then by direction. (Other orders
//! of these, and finer ones, gain no more.)

use crate::geometry::{Aabb, Ray};
use crate::memory::vec_in_large_pages;
use crate::traverse::{FrameBvh, Work};

/// Fewer rays than this have too few similar ones among them.
const LEAST_RAYS: usize = 4096;

/// Trees below this many bytes stay in the caches near a core, and order matters too little. With
/// one of 5 MB shuffled rays gain an eighth, mostly because branches that were taken just before
/// are predicted better.
const LEAST_TREE: usize = 1 << 20;

/// How many rays are sorted together, so that large batches need no large buffers. With a quarter
/// as many, rays have so much fewer similar ones among them that each takes 4 to 8 % longer.
pub const BLOCK: usize = 1 << 20;

/// How many rays are copied together: they stay in the first cache.
pub const FETCHED: usize = 256;

/// Rays that are traced to estimate the cost of a ray.
const SAMPLES: usize = 64;

/// Nodes and leaves that a ray has to visit on average for its order to matter. Sorting and copying
/// take 40 to 50 ns a ray.
const LEAST_VISITS: u64 = 8;

/// Whether sorting may pay: there are many rays and large trees, and rays visit many nodes.
/// `sampled` traces a ray and counts.
pub(crate) fn is_worth_while(world: &FrameBvh, rays: &[Ray], sampled: impl Fn(&Ray, &mut Work)) -> bool {
    let memory = || world.meshes.iter().map(|mesh| mesh.bvh.heap_bytes()).sum::<usize>();
    if rays.len() < LEAST_RAYS || memory() <= LEAST_TREE {
        return false;
    }
    let mut work = Work::default();
    rays.iter().step_by(rays.len() / SAMPLES).take(SAMPLES).for_each(|ray| sampled(ray, &mut work));
    work.nodes + work.leaves >= LEAST_VISITS * SAMPLES as u64
}

/// A ray's key in the upper half, its number in the lower half.
#[derive(Debug, Clone, Copy, Default)]
pub struct SortedRay(u64);

impl SortedRay {
    /// Number of the ray.
    #[inline(always)]
    pub fn ray(self) -> usize {
        self.0 as u32 as usize
    }
}

/// Sorts rays, block by block, in the same memory.
#[derive(Debug)]
pub struct Sorter {
    bounds: Aabb,
    order: Vec<SortedRay>,
    spare: Vec<SortedRay>,
}

/// Bits that one pass sorts by.
const DIGIT: u32 = 11;

/// Bits of a key.
const KEY: u32 = 2 * DIGIT;

/// The index at which each digit begins.
type Starts = [u32; 1 << DIGIT];

impl Sorter {
    /// For rays in a scene within these bounds.
    pub fn new(bounds: Aabb) -> Self {
        Self { bounds, order: Vec::new(), spare: Vec::new() }
    }

    /// In which order the rays are best traced. There are at most [`BLOCK`].
    pub fn order(&mut self, rays: &[Ray]) -> &[SortedRay] {
        let Self { bounds, order, spare } = self;
        if order.capacity() < rays.len() {
            (*order, *spare) = (vec_in_large_pages(rays.len()), vec_in_large_pages(rays.len()));
        }
        let keys = Keys::of(rays, bounds);
        let (mut low, mut high): (Starts, Starts) = ([0; 1 << DIGIT], [0; 1 << DIGIT]);
        order.clear();
        for (ray, number) in rays.iter().zip(0_u64..) {
            let key = keys.of_ray(ray);
            low[(key & DIGIT_MASK) as usize] += 1;
            high[(key >> DIGIT & DIGIT_MASK) as usize] += 1;
            order.push(SortedRay(u64::from(key) << 32 | number));
        }
        spare.resize(order.len(), SortedRay::default());
        pass(order, spare, 32, &mut low);
        pass(spare, order, 32 + DIGIT, &mut high);
        order
    }
}

const DIGIT_MASK: u32 = (1 << DIGIT) - 1;

/// One digit of a radix sort, from the counts of each digit. Stable, so that equal digits keep the
/// order of the pass before.
fn pass(from: &[SortedRay], to: &mut [SortedRay], shift: u32, starts: &mut Starts) {
    let mut start = 0;
    for slot in starts.iter_mut() {
        start += std::mem::replace(slot, start);
    }
    for &entry in from {
        let start = &mut starts[(entry.0 >> shift) as usize & DIGIT_MASK as usize];
        to[*start as usize] = entry;
        *start += 1;
    }
}

/// Makes keys of rays: fifteen bits of origin, three of octant, four of direction. NaN counts as
/// zero.
struct Keys {
    first: [f32; 3],
    /// Cells per metre.
    scale: [f32; 3],
}

/// Cells along an axis.
const CELLS: f32 = 32.0;

/// One of so many rays is sampled for the extent of origins.
const STRIDE: usize = 16;

impl Keys {
    /// Cells cover the origins of rays, which may be a small part of the scene.
    fn of(rays: &[Ray], bounds: &Aabb) -> Self {
        let (mut first, mut last) = (bounds.max, bounds.min);
        for ray in rays.iter().step_by(STRIDE) {
            for axis in 0..3 {
                let at = ray.origin[axis];
                first[axis] = if at < first[axis] { at } else { first[axis] };
                last[axis] = if at > last[axis] { at } else { last[axis] };
            }
        }
        let mut scale = [0.0; 3];
        for axis in 0..3 {
            first[axis] = first[axis].max(bounds.min[axis]);
            let extent = last[axis].min(bounds.max[axis]) - first[axis];
            scale[axis] = if extent > 0.0 { CELLS / extent } else { 0.0 };
        }
        Self { first, scale }
    }

    #[inline(always)]
    fn of_ray(&self, ray: &Ray) -> u32 {
        let mut key = 0;
        for axis in 0..3 {
            let cell = (ray.origin[axis] - self.first[axis]) * self.scale[axis];
            key |= SPREAD[whole(cell, CELLS - 1.0)] << axis;
        }
        for axis in 0..3 {
            key = key << 1 | ray.direction[axis].to_bits() >> 31;
        }
        let [x, y, z] = ray.direction.map(f32::abs);
        let scale = 4.0 / (x + y + z);
        key << 4 | (whole(x * scale, 3.0) << 2 | whole(y * scale, 3.0)) as u32
    }
}

const _: () = assert!(KEY == 15 + 3 + 4);

/// Rounds to an integer between zero and `most`; NaN becomes zero. Adding 2^23 rounds to integers.
#[inline(always)]
fn whole(x: f32, most: f32) -> usize {
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < most { x } else { most };
    ((x + 8_388_608.0).to_bits() & 31) as usize
}

/// Five bits, spread to every third bit.
const SPREAD: [u32; 32] = {
    let mut all = [0; 32];
    let mut x = 0;
    while x < 32 {
        let mut at = 0;
        while at < 5 {
            all[x] |= (x as u32 >> at & 1) << (3 * at);
            at += 1;
        }
        x += 1;
    }
    all
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_names_each_ray_once_by_rising_keys() {
        let bounds = Aabb::new([-1.0; 3], [1.0, 3.0, 1.0]);
        let unit = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 23) as f32 - 1.0;
        let mut rays: Vec<Ray> = (0..5000)
            .map(|i| Ray::new([0, 1, 2].map(|axis| unit(6 * i + axis)), [3, 4, 5].map(|axis| unit(6 * i + axis))))
            .collect();
        rays[77] = Ray::new([f32::NAN; 3], [f32::INFINITY; 3]);
        rays[78] = Ray::new([1e30; 3], [0.0; 3]);
        let mut sorter = Sorter::new(bounds);
        for count in [0, 1, 5000, 300] {
            let keys = Keys::of(&rays[..count], &bounds);
            let order: Vec<usize> = sorter.order(&rays[..count]).iter().map(|entry| entry.ray()).collect();
            assert!(order.windows(2).all(|pair| {
                let [one, other] = [pair[0], pair[1]].map(|at| keys.of_ray(&rays[at]));
                one < other || one == other && pair[0] < pair[1]
            }));
            let mut all = order;
            all.sort_unstable();
            assert!(all.into_iter().eq(0..count));
        }
    }
}
