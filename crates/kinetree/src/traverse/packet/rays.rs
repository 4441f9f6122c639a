//! The rays of a packet, number by number instead of ray by ray.

use crate::geometry::{Affine, Ray};
use crate::simd::{Isa, Row};

/// How many rays a packet has room for: an 8x8 tile of a picture. A set of them has a bit each.
pub(crate) const PACKET: usize = 64;

/// Rows of a packet.
const ROWS: usize = PACKET / 16;

/// One number of each ray.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Column(pub(crate) [Row; ROWS]);

impl Column {
    #[inline(always)]
    pub(crate) fn splat(x: f32) -> Self {
        Self([Row([x; 16]); ROWS])
    }

    #[inline(always)]
    pub(crate) fn get(&self, ray: usize) -> f32 {
        self.0[ray >> 4 & 3].0[ray & 15]
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, ray: usize, x: f32) {
        self.0[ray >> 4 & 3].0[ray & 15] = x;
    }

    /// The rays whose number is above zero.
    #[inline(always)]
    pub(crate) fn positive<I: Isa>(&self, isa: I) -> u64 {
        let zero: I::F16 = isa.splat(0.0);
        let mut set = 0;
        for row in 0..ROWS {
            set |= u64::from(!isa.le(isa.load(&self.0[row]), zero) & ALL_LANES) << (16 * row);
        }
        set
    }

    /// The largest number of those in the set; minus infinity when there are none.
    #[inline(always)]
    pub(crate) fn largest<I: Isa>(&self, isa: I, set: u64) -> f32 {
        let mut most = isa.splat(f32::NEG_INFINITY);
        for row in 0..ROWS {
            let lanes = lanes_of(set, row);
            if lanes != 0 {
                most = larger(isa, most, isa.load(&self.0[row]), lanes);
            }
        }
        let [a, b, c, d] = isa.store(quarters(isa, most));
        let (ab, cd) = (if a > b { a } else { b }, if c > d { c } else { d });
        if ab > cd { ab } else { cd }
    }
}

/// Lane by lane the larger number, for those lanes; the others keep the first.
#[inline(always)]
pub(super) fn larger<I: Isa>(isa: I, most: I::F16, x: I::F16, lanes: u32) -> I::F16 {
    let larger = isa.max(x, most);
    if lanes == ALL_LANES {
        return larger;
    }
    let mut kept = isa.store(most);
    isa.store_masked(&mut kept, lanes, larger);
    isa.load(&kept)
}

/// The larger ones of every fourth lane.
#[inline(always)]
fn quarters<I: Isa>(isa: I, x: I::F16) -> I::F4 {
    let row = isa.store(x);
    let fours = row.0.as_chunks::<4>().0;
    let (a, b) = (isa.max(isa.load(&fours[0]), isa.load(&fours[1])), isa.max(isa.load(&fours[2]), isa.load(&fours[3])));
    isa.max(a, b)
}

/// The largest lane of each.
#[inline(always)]
pub(super) fn largest_of_each<I: Isa>(isa: I, rows: [I::F16; 4]) -> I::F4 {
    let quarters = [quarters(isa, rows[0]), quarters(isa, rows[1]), quarters(isa, rows[2]), quarters(isa, rows[3])];
    let [a, b, c, d] = isa.transpose(quarters);
    isa.max(isa.max(a, b), isa.max(c, d))
}

/// The magnitude of each.
#[inline(always)]
pub(super) fn size<I: Isa>(isa: I, x: I::F16) -> I::F16 {
    isa.max(x, isa.sub(isa.splat(0.0), x))
}

/// The lanes of a row, a bit each.
const ALL_LANES: u32 = 0xffff;

/// The sixteen bits of a row.
#[inline(always)]
pub(crate) fn lanes_of(set: u64, row: usize) -> u32 {
    (set >> (16 * (row & 3))) as u32 & ALL_LANES
}

/// One coordinate of some vectors after the linear part of a map.
#[inline(always)]
fn turned<I: Isa>(isa: I, vectors: &[Column; 3], row: usize, map: &Affine, axis: usize) -> I::F16 {
    let x = isa.mul(isa.splat(map.x_axis[axis]), isa.load(&vectors[0].0[row]));
    let y = isa.mul(isa.splat(map.y_axis[axis]), isa.load(&vectors[1].0[row]));
    let z = isa.mul(isa.splat(map.z_axis[axis]), isa.load(&vectors[2].0[row]));
    isa.add(isa.add(x, y), z)
}

/// The rays of a packet in one space. Their far ends belong to the question, as it moves them.
#[derive(Clone)]
pub(crate) struct RayPacket {
    pub(crate) origin: [Column; 3],
    pub(crate) direction: [Column; 3],
    /// One over the direction.
    pub(crate) reciprocal: [Column; 3],
    pub(crate) t_min: Column,
    /// Rays that run down each axis.
    pub(crate) negative: [u64; 3],
}

/// Meets nothing.
const NOTHING: Ray = Ray::new([0.0; 3], [0.0; 3]);

impl RayPacket {
    /// The rays that can hit anything, and their far ends; those of the other rays are minus
    /// infinity.
    ///
    /// # Panics
    /// When there are more than [`PACKET`].
    #[inline(always)]
    pub(crate) fn gather<I: Isa>(isa: I, rays: &[Ray]) -> (Self, u64, Column) {
        let mut room;
        let rays: &[Ray; PACKET] = match rays.first_chunk() {
            Some(all) => all,
            None => {
                room = [NOTHING; PACKET];
                room[..rays.len()].copy_from_slice(rays);
                &room
            }
        };
        let zero = Column::splat(0.0);
        let (origin, direction, reciprocal) = ([zero; 3], [zero; 3], [zero; 3]);
        let mut packet = Self { origin, direction, reciprocal, t_min: zero, negative: [0; 3] };
        let mut far = zero;
        for four in 0..PACKET / 4 {
            let four_rays = [
                rays[4 * four].quads(),
                rays[4 * four + 1].quads(),
                rays[4 * four + 2].quads(),
                rays[4 * four + 3].quads(),
            ];
            let [x, y, z, t_min] = columns(isa, four_rays, 0);
            put(isa, &mut packet.origin[0], four, x);
            put(isa, &mut packet.origin[1], four, y);
            put(isa, &mut packet.origin[2], four, z);
            put(isa, &mut packet.t_min, four, t_min);
            let [x, y, z, t_max] = columns(isa, four_rays, 1);
            put(isa, &mut packet.direction[0], four, x);
            put(isa, &mut packet.direction[1], four, y);
            put(isa, &mut packet.direction[2], four, z);
            put(isa, &mut far, four, t_max);
        }
        let mut set = packet.finish(isa);
        let zero: I::F16 = isa.splat(0.0);
        for row in 0..ROWS {
            // Adding zero turns negative zeros into positive ones, whose bits order like their
            // value.
            let t_min = isa.add(isa.max(zero, isa.load(&packet.t_min.0[row])), zero);
            let t_max = isa.add(isa.load(&far.0[row]), zero);
            let forward = isa.le(t_min, t_max);
            set &= u64::from(forward) << (16 * row) | !(0xffff << (16 * row));
            packet.t_min.0[row] = isa.store(t_min);
            far.0[row] = isa.store(t_max);
            let out = !lanes_of(set, row) & ALL_LANES;
            if out != 0 {
                isa.store_masked(&mut far.0[row], out, isa.splat(f32::NEG_INFINITY));
            }
        }
        (packet, set, far)
    }

    /// One of the rays, in the space of the packet.
    #[inline]
    pub(crate) fn ray(&self, at: usize) -> Ray {
        let [origin, direction] = [&self.origin, &self.direction].map(|v| [0, 1, 2].map(|axis| v[axis].get(at)));
        Ray::new(origin, direction).with_range(self.t_min.get(at), f32::INFINITY)
    }

    /// The rays in another space, by the operations of [`Affine::transform_point`] and
    /// [`Affine::transform_vector`], and which of them can hit anything there.
    #[inline(always)]
    pub(crate) fn moved<I: Isa>(&self, isa: I, map: &Affine) -> (Self, u64) {
        let mut packet = self.clone();
        for row in 0..ROWS {
            for axis in 0..3 {
                let origin = turned(isa, &self.origin, row, map, axis);
                packet.origin[axis].0[row] = isa.store(isa.add(origin, isa.splat(map.translation[axis])));
                packet.direction[axis].0[row] = isa.store(turned(isa, &self.direction, row, map, axis));
            }
        }
        let set = packet.finish(isa);
        (packet, set)
    }

    /// Fills in what follows from origins and directions. Returns the rays for which both are
    /// finite and the direction is not zero.
    #[inline(always)]
    fn finish<I: Isa>(&mut self, isa: I) -> u64 {
        let (zero, one) = (isa.splat(0.0), isa.splat(1.0));
        let mut set = 0;
        self.negative = [0; 3];
        for row in 0..ROWS {
            let (mut nothing, mut largest) = (zero, zero);
            for axis in 0..3 {
                let (origin, direction) = (isa.load(&self.origin[axis].0[row]), isa.load(&self.direction[axis].0[row]));
                // Zero for what is finite, and NaN otherwise.
                nothing = isa.add(nothing, isa.add(isa.mul(origin, zero), isa.mul(direction, zero)));
                largest = isa.max(size(isa, direction), largest);
                // Of a negative zero it is negative, too.
                let reciprocal = isa.div(one, direction);
                self.negative[axis] |= u64::from(isa.le(reciprocal, zero)) << (16 * row);
                self.reciprocal[axis].0[row] = isa.store(reciprocal);
            }
            set |= u64::from(isa.eq(nothing, zero) & !isa.le(largest, zero)) << (16 * row);
        }
        set
    }
}

/// One half of each of four rays, number by number.
#[inline(always)]
fn columns<I: Isa>(isa: I, rays: [&[[f32; 4]; 2]; 4], half: usize) -> [I::F4; 4] {
    let (a, b) = (isa.load(&rays[0][half]), isa.load(&rays[1][half]));
    isa.transpose([a, b, isa.load(&rays[2][half]), isa.load(&rays[3][half])])
}

/// Writes four numbers next to each other.
#[inline(always)]
fn put<I: Isa>(isa: I, column: &mut Column, four: usize, x: I::F4) {
    column.0[four >> 2 & 3].0.as_chunks_mut::<4>().0[four & 3] = isa.store(x);
}
