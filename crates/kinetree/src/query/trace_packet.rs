//! A packet of rays through both levels: compiled once for each vector level.

use std::ops::ControlFlow;

use super::Cull;
use super::candidate::{Filter, QueryFilter};
use super::packet_hits::PacketHits;
use super::two_level::{EntersInstances, Instance, Rules, enter_instances};
use crate::geometry::slab::ErrorBound;
use crate::geometry::{LaneHits, Precision, Ray, TriangleHit, exact};
use crate::simd::{Isa, Kernel, Row};
use crate::traverse::{
    Column, FrameBvh, Interval, PACKET, PacketPlanes, PacketVisitor, RayPacket, WatertightPacket, lanes_of, octants,
    walk_packet,
};
use crate::wide::{TriangleBlock, WideLink};

/// Finds the hits of a packet. Returns which rays have to be traced alone.
pub(super) struct TracePacket<'a> {
    pub(super) world: &'a FrameBvh,
    pub(super) rays: &'a [Ray],
    pub(super) rules: Rules<QueryFilter<'a>>,
    /// Index of the first ray in its batch.
    pub(super) first: usize,
    pub(super) hits: &'a mut PacketHits,
}

impl Kernel for TracePacket<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> u64 {
        let (rays, set, t_max) = RayPacket::gather(isa, self.rays);
        self.hits.restart(t_max);
        let Self { world, rules, first, hits, .. } = self;
        let mut visitor = TopLevelVisitor { world, rays: &rays, rules, first, hits, alone: 0 };
        if world.top.instances().len() == 1 {
            // The boxes in the root of its mesh say as much as its own.
            visitor.leaf(isa, WideLink::items(0..1), set);
        } else {
            let bound = ErrorBound::instances(world.top.far());
            let planes = PacketPlanes::new(isa, &rays, set, &world.top.bounds(), bound);
            visitor.alone = planes.in_double;
            for set in octants(set & !planes.in_double, rays.negative) {
                let interval = Interval::new(isa, &rays, &planes, set);
                walk_packet(isa, world.top.tree(), &rays, &planes, &interval, &mut visitor);
            }
        }
        visitor.alone
    }
}

struct TopLevelVisitor<'a> {
    world: &'a FrameBvh,
    rays: &'a RayPacket,
    rules: Rules<QueryFilter<'a>>,
    first: usize,
    hits: &'a mut PacketHits,
    /// Rays that have to be traced alone, since somewhere they need double precision.
    alone: u64,
}

impl<I: Isa> PacketVisitor<I> for TopLevelVisitor<'_> {
    #[inline(always)]
    fn wants_any(&self) -> bool {
        self.hits.wants_any()
    }

    #[inline(always)]
    fn t_max(&self) -> &Column {
        self.hits.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, set: u64) -> bool {
        let _ = enter_instances(isa, self.world, link, self, set, &mut ());
        true
    }
}

impl<'a, I: Isa> EntersInstances<'a, I, ()> for TopLevelVisitor<'a> {
    type Set = u64;

    #[inline(always)]
    fn mask(&self) -> u32 {
        self.rules.mask
    }

    #[inline(always)]
    fn seeing(&self, instance: u32, set: u64) -> Option<u64> {
        let set = self.rules.filter.seeing(instance, self.first, set);
        (set != 0).then_some(set)
    }

    #[inline(always)]
    fn enter(&mut self, isa: I, instance: Instance<'a>, set: u64, (): &mut ()) -> ControlFlow<()> {
        let Instance { record, mesh, .. } = instance;
        let counts =
            Counts { rules: self.rules, first: self.first, instance, may_refuse: self.rules.filter.may_refuse(record) };
        let moved;
        let (rays, set) = if record.identity {
            (self.rays, set)
        } else {
            let (rays, valid) = self.rays.moved(isa, &record.object_from_world);
            moved = rays;
            (&moved, set & valid)
        };
        let planes = PacketPlanes::new(isa, rays, set, &mesh.bvh.bounds(), ErrorBound::TRIANGLES);
        self.alone |= planes.in_double;
        let watertight = WatertightPacket::new(isa, rays);
        let bottom_level = BottomLevelVisitor::<true> { rays, watertight: &watertight, counts, hits: &mut *self.hits };
        let set = set & !planes.in_double;
        match mesh.precision {
            Precision::Watertight => bottom_level.walk(isa, &planes, set),
            Precision::Fast => bottom_level.in_single_precision().walk(isa, &planes, set),
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn enter_in_double(&mut self, _: u32, set: u64, (): &mut ()) -> ControlFlow<()> {
        self.alone |= set;
        ControlFlow::Continue(())
    }
}

/// So few rays are tested against four triangles at a time each, instead of sixteen against one.
const FEW: u32 = 6;

struct BottomLevelVisitor<'a, const WATERTIGHT: bool> {
    rays: &'a RayPacket,
    watertight: &'a WatertightPacket,
    counts: Counts<'a>,
    hits: &'a mut PacketHits,
}

impl<I: Isa, const WATERTIGHT: bool> PacketVisitor<I> for BottomLevelVisitor<'_, WATERTIGHT> {
    #[inline(always)]
    fn wants_any(&self) -> bool {
        self.hits.wants_any()
    }

    #[inline(always)]
    fn t_max(&self) -> &Column {
        self.hits.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, set: u64) -> bool {
        let mut is_nearer = false;
        for item in link.item_index()..link.item_index() + link.item_count() {
            let block = self.counts.instance.mesh.bvh.block(item);
            for along in 0..3 {
                let set = set & self.watertight.along[along];
                if set == 0 {
                    continue;
                }
                // All rays of the set share an octant.
                let downwards = self.rays.negative[along] & set != 0;
                let axes = WatertightPacket::axes(along, downwards);
                if set.count_ones() <= FEW {
                    is_nearer |= self.one_by_one(isa, block, set, axes);
                    continue;
                }
                for lane in 0..block.count as usize {
                    let mut corners = [[isa.splat(0.0); 3]; 3];
                    for corner in 0..3 {
                        for axis in 0..3 {
                            corners[corner][axis] = isa.splat(block.corners[corner][axes[axis] % 3][lane & 3]);
                        }
                    }
                    let primitive = block.primitives[lane & 3];
                    for row in 0..PACKET / 16 {
                        let lanes = lanes_of(set, row);
                        if lanes == 0 {
                            continue;
                        }
                        let hits = self.watertight.hits::<I, WATERTIGHT>(
                            isa,
                            self.rays,
                            axes,
                            (&corners, block.extents()[lane & 3]),
                            (row, lanes),
                            self.hits.t_max(),
                        );
                        let Some(mut hits) = hits else { continue };
                        if hits.hits | hits.ambiguous == 0 {
                            continue;
                        }
                        is_nearer = true;
                        hits.hits = self.counts.of(isa, row, &hits, primitive);
                        if hits.hits != 0 {
                            self.hits.collect(isa, row, &hits, primitive, self.counts.instance.index);
                        }
                        if hits.ambiguous != 0 {
                            self.test_exactly(row, hits.ambiguous, primitive);
                        }
                    }
                }
            }
        }
        is_nearer
    }
}

impl<'a, const WATERTIGHT: bool> BottomLevelVisitor<'a, WATERTIGHT> {
    fn in_single_precision(self) -> BottomLevelVisitor<'a, false> {
        let Self { rays, watertight, counts, hits } = self;
        BottomLevelVisitor { rays, watertight, counts, hits }
    }

    #[inline(always)]
    fn walk<I: Isa>(mut self, isa: I, planes: &PacketPlanes, set: u64) {
        for set in octants(set, self.rays.negative) {
            let interval = Interval::new(isa, self.rays, planes, set);
            walk_packet(isa, self.counts.instance.mesh.bvh.tree(), self.rays, planes, &interval, &mut self);
        }
    }

    /// Four triangles against each ray of the set; whether anything was hit.
    #[inline(always)]
    fn one_by_one<I: Isa>(&mut self, isa: I, block: &TriangleBlock, mut set: u64, axes: [usize; 3]) -> bool {
        let mut is_nearer = false;
        while set != 0 {
            let ray = set.trailing_zeros() as usize & 63;
            set &= set - 1;
            let local = self.rays.ray(ray);
            let hits = self.watertight.alone::<I, WATERTIGHT>(isa, ray, &local, axes).hits(
                isa,
                block,
                self.hits.t_max().get(ray),
            );
            let mut mask = hits.mask;
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize & 3;
                mask &= mask - 1;
                let (hit, primitive) = (hits.lane(lane), block.primitives[lane]);
                if self.counts.one(ray, &hit, primitive) {
                    is_nearer = true;
                    self.hits.collect_one(ray, &hit, primitive, self.counts.instance.index);
                }
            }
        }
        is_nearer
    }

    /// Decides without rounding errors what single precision cannot.
    #[cold]
    fn test_exactly(&mut self, row: usize, lanes: u32, primitive: u32) {
        for ray in (0..16).filter(|lane| lanes >> lane & 1 == 1).map(|lane| row * 16 + lane) {
            let local = self.rays.ray(ray);
            let triangle = self.counts.instance.mesh.triangles.get(primitive);
            let hit = exact::hit(&local, &triangle, local.t_min, self.hits.t_max().get(ray));
            if let Some(hit) = hit.filter(|hit| self.counts.one(ray, hit, primitive)) {
                self.hits.collect_one(ray, &hit, primitive, self.counts.instance.index);
            }
        }
    }
}

/// Which hits of a packet on an instance count.
struct Counts<'a> {
    rules: Rules<QueryFilter<'a>>,
    /// Index of the packet's first ray in its batch.
    first: usize,
    instance: Instance<'a>,
    /// Whether the filter may refuse hits on the instance.
    may_refuse: bool,
}

impl Counts<'_> {
    /// The lanes of a row whose hits count.
    #[inline(always)]
    fn of<I: Isa>(&self, isa: I, row: usize, hits: &LaneHits<I::F16>, primitive: u32) -> u32 {
        let lanes = match self.rules.cull {
            Cull::None => hits.hits,
            Cull::Back => hits.hits & !hits.back(isa),
            Cull::Front => hits.hits & hits.back(isa),
        };
        if !self.may_refuse || lanes == 0 {
            return lanes;
        }
        let [u, v] = hits.weights(isa);
        let columns = [isa.store(hits.t(isa)), isa.store(u), isa.store(v)];
        self.accepted((row, lanes), &columns, hits.back(isa), primitive)
    }

    #[inline(never)]
    fn accepted(&self, (row, lanes): (usize, u32), [t, u, v]: &[Row; 3], back: u32, primitive: u32) -> u32 {
        let (mut left, mut accepted) = (lanes, 0);
        while left != 0 {
            let lane = left.trailing_zeros() as usize & 15;
            left &= left - 1;
            let hit = TriangleHit { t: t.0[lane], u: u.0[lane], v: v.0[lane], back: back >> lane & 1 == 1 };
            accepted |= u32::from(self.is_accepted(row * 16 + lane, &hit, primitive)) << lane;
        }
        accepted
    }

    /// Whether the hit of one ray of the packet counts.
    fn one(&self, ray: usize, hit: &TriangleHit, primitive: u32) -> bool {
        self.rules.cull.keeps(hit) && self.is_accepted(ray, hit, primitive)
    }

    fn is_accepted(&self, ray: usize, hit: &TriangleHit, primitive: u32) -> bool {
        !self.may_refuse || self.rules.for_ray(self.first + ray).filter.accepts(hit, primitive, &self.instance)
    }
}
