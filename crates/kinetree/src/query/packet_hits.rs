//! What queries keep of the hits of a packet, row by row.

use super::Hit;
use crate::geometry::{LaneHits, TriangleHit};
use crate::simd::Isa;
use crate::traverse::{Column, FrameStamp};

/// The hits of a packet that are wanted: of each ray the nearest so far, at equal distance the one
/// with the smaller (instance, primitive); or whether it has hit anything.
pub(super) struct PacketHits {
    wants_any: bool,
    /// For each ray: hits beyond this do not matter (any more).
    t_max: Column,
    u: Column,
    v: Column,
    back: u64,
    found: u64,
    /// Indices, as bits.
    primitive: Column,
    instance: Column,
}

impl PacketHits {
    /// No hits yet. Any hit will do if `wants_any`.
    #[inline(always)]
    pub(super) fn new(wants_any: bool) -> Self {
        let zero = Column::splat(0.0);
        let none = Column::splat(f32::from_bits(u32::MAX));
        Self { wants_any, t_max: zero, u: zero, v: zero, back: 0, found: 0, primitive: none, instance: none }
    }

    /// No hits yet, of rays that end at `t_max`.
    #[inline(always)]
    pub(super) fn restart(&mut self, t_max: Column) {
        let none = Column::splat(f32::from_bits(u32::MAX));
        (self.t_max, self.primitive, self.instance) = (t_max, none, none);
        (self.back, self.found) = (0, 0);
    }

    #[inline(always)]
    pub(super) fn wants_any(&self) -> bool {
        self.wants_any
    }

    #[inline(always)]
    pub(super) fn t_max(&self) -> &Column {
        &self.t_max
    }

    /// Instance and primitive.
    #[inline(always)]
    fn indices(&self, ray: usize) -> (u32, u32) {
        (self.instance.get(ray).to_bits(), self.primitive.get(ray).to_bits())
    }

    /// Receives the hits of a row that count.
    #[inline(always)]
    pub(super) fn collect<I: Isa>(
        &mut self,
        isa: I,
        row: usize,
        hits: &LaneHits<I::F16>,
        primitive: u32,
        instance: u32,
    ) {
        let mut lanes = hits.hits;
        if self.wants_any {
            // A ray that has hit anything wants nothing any more.
            isa.store_masked(&mut self.t_max.0[row], lanes, isa.splat(f32::NEG_INFINITY));
            self.found |= u64::from(lanes) << (16 * row);
            return;
        }
        let t = hits.t(isa);
        let mut ties = lanes & isa.eq(t, isa.load(&self.t_max.0[row]));
        while ties != 0 {
            let lane = ties.trailing_zeros() as usize & 15;
            ties &= ties - 1;
            let ray = row * 16 + lane;
            // The first hit of a ray can be as far as its end; no indices are larger than those of
            // no hit.
            if self.indices(ray) <= (instance, primitive) {
                lanes &= !(1 << lane);
            }
        }
        let [u, v] = hits.weights(isa);
        isa.store_masked(&mut self.t_max.0[row], lanes, t);
        isa.store_masked(&mut self.u.0[row], lanes, u);
        isa.store_masked(&mut self.v.0[row], lanes, v);
        isa.store_masked(&mut self.primitive.0[row], lanes, isa.splat(f32::from_bits(primitive)));
        isa.store_masked(&mut self.instance.0[row], lanes, isa.splat(f32::from_bits(instance)));
        let lanes = u64::from(lanes) << (16 * row);
        self.found |= lanes;
        self.back = self.back & !lanes | u64::from(hits.back(isa)) << (16 * row) & lanes;
    }

    /// Receives a hit of one ray that counts.
    #[inline]
    pub(super) fn collect_one(&mut self, ray: usize, hit: &TriangleHit, primitive: u32, instance: u32) {
        if self.wants_any {
            self.t_max.set(ray, f32::NEG_INFINITY);
            self.found |= 1 << ray;
        } else if (hit.t, (instance, primitive)) < (self.t_max.get(ray), self.indices(ray)) {
            self.t_max.set(ray, hit.t);
            self.u.set(ray, hit.u);
            self.v.set(ray, hit.v);
            self.primitive.set(ray, f32::from_bits(primitive));
            self.instance.set(ray, f32::from_bits(instance));
            self.found |= 1 << ray;
            self.back = self.back & !(1 << ray) | u64::from(hit.back) << ray;
        }
    }

    /// The nearest hit of a ray, of the frame with this stamp.
    #[inline]
    pub(super) fn hit(&self, ray: usize, stamp: FrameStamp) -> Option<Hit> {
        let (t, u, v) = (self.t_max.get(ray), self.u.get(ray), self.v.get(ray));
        let hit = TriangleHit { t, u, v, back: self.back >> ray & 1 == 1 };
        let (instance, primitive) = self.indices(ray);
        self.is_hit(ray).then(|| Hit::new(&hit, primitive, instance).stamped(stamp))
    }

    /// Whether a ray has hit anything.
    #[inline]
    pub(super) fn is_hit(&self, ray: usize) -> bool {
        self.found >> ray & 1 == 1
    }
}
