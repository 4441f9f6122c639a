//! What questions keep of the hits of a packet, row by row.

use super::Hit;
use crate::geometry::TriangleHit;
use crate::simd::Isa;
use crate::traverse::{Column, FrameStamp, RowHits};

/// What a question does with the hits of a packet.
pub(super) trait PacketCollector {
    /// Of each ray.
    type Answer;

    /// Whether any hit will do.
    const ANY: bool;

    /// For each ray: hits beyond this do not matter (any more).
    fn t_max(&self) -> &Column;

    fn take<I: Isa>(&mut self, isa: I, row: usize, hits: &RowHits<I>, primitive: u32, instance: u32);

    fn take_one(&mut self, ray: usize, hit: &TriangleHit, primitive: u32, instance: u32);

    /// That of one ray, in the frame of this stamp.
    fn answer(&self, ray: usize, stamp: FrameStamp) -> Self::Answer;
}

/// The nearest hit of each ray so far; at equal distance the one with the smaller (instance, primitive).
pub(super) struct Nearest {
    t: Column,
    u: Column,
    v: Column,
    back: u64,
    found: u64,
    /// Numbers, as bits.
    primitive: Column,
    instance: Column,
}

impl Nearest {
    #[inline(always)]
    pub(super) fn new(t_max: Column) -> Self {
        let zero = Column::splat(0.0);
        let none = Column::splat(f32::from_bits(u32::MAX));
        Self { t: t_max, u: zero, v: zero, back: 0, found: 0, primitive: none, instance: none }
    }

    /// Instance and primitive.
    #[inline(always)]
    fn numbers(&self, ray: usize) -> (u32, u32) {
        (self.instance.get(ray).to_bits(), self.primitive.get(ray).to_bits())
    }
}

impl PacketCollector for Nearest {
    type Answer = Option<Hit>;

    const ANY: bool = false;

    #[inline(always)]
    fn t_max(&self) -> &Column {
        &self.t
    }

    #[inline(always)]
    fn take<I: Isa>(&mut self, isa: I, row: usize, hits: &RowHits<I>, primitive: u32, instance: u32) {
        let mut lanes = hits.lanes;
        let mut ties = lanes & isa.eq16(hits.t, isa.load16(&self.t.0[row]));
        while ties != 0 {
            let lane = ties.trailing_zeros() as usize & 15;
            ties &= ties - 1;
            let ray = row * 16 + lane;
            // The first hit of a ray can be as far as its end; no numbers are larger than those of no hit.
            if self.numbers(ray) <= (instance, primitive) {
                lanes &= !(1 << lane);
            }
        }
        let [u, v] = hits.weights(isa);
        isa.store_masked16(&mut self.t.0[row], lanes, hits.t);
        isa.store_masked16(&mut self.u.0[row], lanes, u);
        isa.store_masked16(&mut self.v.0[row], lanes, v);
        isa.store_masked16(&mut self.primitive.0[row], lanes, isa.splat16(f32::from_bits(primitive)));
        isa.store_masked16(&mut self.instance.0[row], lanes, isa.splat16(f32::from_bits(instance)));
        let lanes = u64::from(lanes) << (16 * row);
        self.found |= lanes;
        self.back = self.back & !lanes | u64::from(hits.back) << (16 * row) & lanes;
    }

    #[inline]
    fn take_one(&mut self, ray: usize, hit: &TriangleHit, primitive: u32, instance: u32) {
        if (hit.t, (instance, primitive)) < (self.t.get(ray), self.numbers(ray)) {
            self.t.set(ray, hit.t);
            self.u.set(ray, hit.u);
            self.v.set(ray, hit.v);
            self.primitive.set(ray, f32::from_bits(primitive));
            self.instance.set(ray, f32::from_bits(instance));
            self.found |= 1 << ray;
            self.back = self.back & !(1 << ray) | u64::from(hit.back) << ray;
        }
    }

    #[inline(always)]
    fn answer(&self, ray: usize, stamp: FrameStamp) -> Option<Hit> {
        let hit =
            TriangleHit { t: self.t.get(ray), u: self.u.get(ray), v: self.v.get(ray), back: self.back >> ray & 1 == 1 };
        let (instance, primitive) = self.numbers(ray);
        if self.found >> ray & 1 == 1 { Some(Hit::new(&hit, primitive, instance).stamped(stamp)) } else { None }
    }
}

/// Whether each ray has hit anything. One that has wants nothing any more.
pub(super) struct Any {
    t_max: Column,
    found: u64,
}

impl Any {
    #[inline(always)]
    pub(super) fn new(t_max: Column) -> Self {
        Self { t_max, found: 0 }
    }
}

impl PacketCollector for Any {
    type Answer = bool;

    const ANY: bool = true;

    #[inline(always)]
    fn t_max(&self) -> &Column {
        &self.t_max
    }

    #[inline(always)]
    fn take<I: Isa>(&mut self, isa: I, row: usize, hits: &RowHits<I>, _: u32, _: u32) {
        isa.store_masked16(&mut self.t_max.0[row], hits.lanes, isa.splat16(f32::NEG_INFINITY));
        self.found |= u64::from(hits.lanes) << (16 * row);
    }

    #[inline]
    fn take_one(&mut self, ray: usize, _: &TriangleHit, _: u32, _: u32) {
        self.t_max.set(ray, f32::NEG_INFINITY);
        self.found |= 1 << ray;
    }

    #[inline(always)]
    fn answer(&self, ray: usize, _: FrameStamp) -> bool {
        self.found >> ray & 1 == 1
    }
}
