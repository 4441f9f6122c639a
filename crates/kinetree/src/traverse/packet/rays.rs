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

    /// The largest number of those in the set, and at least `least`.
    #[inline(always)]
    pub(crate) fn largest<I: Isa>(&self, isa: I, set: u64, least: f32) -> f32 {
        let mut all = Row([least; 16]);
        for (row, lanes) in rows_of(set) {
            let most = isa.max16(isa.load16(&self.0[row]), isa.load16(&all));
            isa.keep16(&mut all, lanes, most);
        }
        across(&all, |a, b| if a > b { a } else { b })
    }

    /// The smallest number of those in the set, and at most `most`.
    #[inline(always)]
    pub(crate) fn smallest<I: Isa>(&self, isa: I, set: u64, most: f32) -> f32 {
        let mut all = Row([most; 16]);
        for (row, lanes) in rows_of(set) {
            let least = isa.min16(isa.load16(&self.0[row]), isa.load16(&all));
            isa.keep16(&mut all, lanes, least);
        }
        across(&all, |a, b| if a < b { a } else { b })
    }

    /// The rays whose number is above zero.
    #[inline(always)]
    pub(crate) fn positive<I: Isa>(&self, isa: I) -> u64 {
        let zero = isa.splat16(0.0);
        let mut set = 0;
        for row in 0..ROWS {
            set |= u64::from(!isa.le16(isa.load16(&self.0[row]), zero)) << (16 * row);
        }
        set
    }
}

/// Halves, quarters, ...: four steps instead of fifteen.
#[inline(always)]
pub(super) fn across(row: &Row, pick: impl Fn(f32, f32) -> f32) -> f32 {
    let mut all = row.0;
    for width in [8, 4, 2, 1] {
        for lane in 0..width {
            all[lane] = pick(all[lane], all[lane + width]);
        }
    }
    all[0]
}

/// The rows in which the set has rays, each with its sixteen bits.
#[inline(always)]
pub(crate) fn rows_of(set: u64) -> impl Iterator<Item = (usize, u16)> {
    (0..ROWS).map(move |row| (row, (set >> (16 * row)) as u16)).filter(|(_, lanes)| *lanes != 0)
}

/// One coordinate of some vectors after the linear part of a map.
#[inline(always)]
fn turned<I: Isa>(isa: I, vectors: &[Column; 3], row: usize, map: &Affine, axis: usize) -> I::F16 {
    let x = isa.mul16(isa.splat16(map.x_axis[axis]), isa.load16(&vectors[0].0[row]));
    let y = isa.mul16(isa.splat16(map.y_axis[axis]), isa.load16(&vectors[1].0[row]));
    let z = isa.mul16(isa.splat16(map.z_axis[axis]), isa.load16(&vectors[2].0[row]));
    isa.add16(isa.add16(x, y), z)
}

/// The rays of a packet in one space. Their far ends belong to the question, as it moves them.
#[derive(Clone)]
pub(crate) struct RayPacket {
    pub(crate) origin: [Column; 3],
    pub(crate) direction: [Column; 3],
    pub(crate) t_min: Column,
    /// Rays that run down each axis.
    pub(crate) negative: [u64; 3],
}

impl RayPacket {
    /// The rays that can hit anything, and their far ends. Those of the others are before everything.
    ///
    /// # Panics
    /// When there are more than [`PACKET`].
    #[inline(always)]
    pub(crate) fn gather<I: Isa>(isa: I, rays: &[Ray]) -> (Self, u64, Column) {
        assert!(rays.len() <= PACKET);
        let mut packet = Self {
            origin: [Column::splat(0.0); 3],
            direction: [Column::splat(1.0); 3],
            t_min: Column::splat(0.0),
            negative: [0; 3],
        };
        let (mut set, mut far) = (0, Column::splat(f32::NEG_INFINITY));
        for (at, ray) in rays.iter().enumerate() {
            let Some(ray) = ray.sane() else { continue };
            set |= 1 << at;
            for axis in 0..3 {
                packet.origin[axis].set(at, ray.origin[axis]);
                packet.direction[axis].set(at, ray.direction[axis]);
            }
            packet.t_min.set(at, ray.t_min);
            far.set(at, ray.t_max);
        }
        packet.negative = packet.downwards(isa);
        (packet, set, far)
    }

    /// One of the rays, in the space of the packet.
    #[inline]
    pub(crate) fn ray(&self, at: usize) -> Ray {
        let [origin, direction] = [&self.origin, &self.direction].map(|v| [0, 1, 2].map(|axis| v[axis].get(at)));
        Ray::new(origin, direction).with_range(self.t_min.get(at), f32::INFINITY)
    }

    /// The rays in another space, by the operations of [`Affine::transform_point`] and [`Affine::transform_vector`], and which of them can hit anything there.
    #[inline(always)]
    pub(crate) fn moved<I: Isa>(&self, isa: I, map: &Affine) -> (Self, u64) {
        let mut packet = self.clone();
        let mut sane = Column::splat(0.0);
        for row in 0..ROWS {
            for axis in 0..3 {
                let origin = turned(isa, &self.origin, row, map, axis);
                packet.origin[axis].0[row] = isa.store16(isa.add16(origin, isa.splat16(map.translation[axis])));
                packet.direction[axis].0[row] = isa.store16(turned(isa, &self.direction, row, map, axis));
            }
            for lane in 0..16 {
                let (mut finite, mut forward) = (true, false);
                for axis in 0..3 {
                    let (o, d) = (packet.origin[axis].0[row].0[lane], packet.direction[axis].0[row].0[lane]);
                    finite &= o.abs() <= f32::MAX && d.abs() <= f32::MAX;
                    forward |= d != 0.0;
                }
                sane.0[row].0[lane] = if finite & forward { 1.0 } else { 0.0 };
            }
        }
        packet.negative = packet.downwards(isa);
        (packet, sane.positive(isa))
    }

    #[inline(always)]
    fn downwards<I: Isa>(&self, isa: I) -> [u64; 3] {
        let mut negative = [0; 3];
        for axis in 0..3 {
            let mut signs = Column::splat(0.0);
            for row in 0..ROWS {
                for lane in 0..16 {
                    // A negative zero runs down too.
                    signs.0[row].0[lane] = -1.0_f32.copysign(self.direction[axis].0[row].0[lane]);
                }
            }
            negative[axis] = signs.positive(isa);
        }
        negative
    }
}
