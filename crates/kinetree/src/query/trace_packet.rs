//! A packet's way through both levels.

use super::packet_collector::PacketCollector;
use super::trace_ray::Rules;
use super::{Cull, Filter};
use crate::geometry::slab::ErrorBound;
use crate::geometry::{Precision, Ray, TriangleHit, exact};
use crate::simd::{Isa, Kernel, Row};
use crate::traverse::{
    Column, FrameBvh, Interval, MeshFrame, PACKET, PacketPlanes, PacketVisitor, RayPacket, RowHits, WatertightPacket,
    lanes_of, octants, walk_packet,
};
use crate::wide::{InstanceRecord, TriangleBlock, WideLink};

/// Answers a packet, and says which rays are still to be asked alone.
pub(super) struct TracePacket<'a, F, G: PacketCollector, W> {
    pub(super) world: &'a FrameBvh,
    pub(super) rays: &'a [Ray],
    pub(super) rules: Rules<F>,
    /// Number of the first ray in its batch.
    pub(super) first: usize,
    pub(super) answers: &'a mut [G::Answer],
    pub(super) within: &'a W,
}

impl<F: Filter, G: PacketCollector, W: Fn(Column) -> G> Kernel for TracePacket<'_, F, G, W> {
    type Output = u64;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> u64 {
        let (rays, set, t_max) = RayPacket::gather(isa, self.rays);
        let collector = (self.within)(t_max);
        let mut visitor = TopLevelVisitor {
            world: self.world,
            rays: &rays,
            rules: self.rules,
            first: self.first,
            collector,
            alone: 0,
        };
        if self.world.top.instances().len() == 1 {
            // The boxes in the root of its mesh say as much as its own.
            visitor.leaf(isa, WideLink::items(0..1), set);
        } else {
            let bound = ErrorBound::instances(self.world.top.far());
            let planes = PacketPlanes::new(isa, &rays, set, &self.world.top.bounds(), bound);
            visitor.alone = planes.in_double;
            for set in octants(set & !planes.in_double, rays.negative) {
                let interval = Interval::new(isa, &rays, &planes, set);
                walk_packet(isa, self.world.top.tree(), &rays, &planes, &interval, &mut visitor);
            }
        }
        for (at, answer) in self.answers.iter_mut().enumerate() {
            *answer = visitor.collector.answer(at, self.world.stamp);
        }
        visitor.alone
    }
}

pub(super) struct TopLevelVisitor<'a, F, G> {
    world: &'a FrameBvh,
    pub(super) rays: &'a RayPacket,
    rules: Rules<F>,
    first: usize,
    pub(super) collector: G,
    /// Rays that only double precision does justice, somewhere.
    pub(super) alone: u64,
}

impl<I: Isa, F: Filter, G: PacketCollector> PacketVisitor<I> for TopLevelVisitor<'_, F, G> {
    const ANY: bool = G::ANY;

    #[inline(always)]
    fn t_max(&self) -> &Column {
        self.collector.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, set: u64) -> bool {
        let items = link.item_index()..link.item_index() + link.item_count();
        for &instance in &self.world.top.instances()[items] {
            let record = &self.world.instances[instance as usize];
            if record.mask & self.rules.mask == 0 {
                continue;
            }
            let set = self.rules.filter.seeing(instance, self.first, set);
            if F::ASKS && set == 0 {
                continue;
            }
            if record.in_double {
                self.alone |= set;
                continue;
            }
            let counts = Counts { rules: self.rules, first: self.first, instance, record };
            let mesh = &*self.world.meshes[record.mesh as usize];
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
            let bottom_level = BottomLevelVisitor::<F, G, true> {
                rays,
                watertight: &watertight,
                mesh,
                counts,
                collector: &mut self.collector,
            };
            let set = set & !planes.in_double;
            match mesh.precision {
                Precision::Watertight => bottom_level.walk(isa, &planes, set),
                Precision::Fast => bottom_level.in_single_precision().walk(isa, &planes, set),
            }
        }
        true
    }
}

/// So few rays are tested against four triangles at a time each, instead of sixteen against one.
const FEW: u32 = 6;

struct BottomLevelVisitor<'a, F, G, const WATERTIGHT: bool> {
    rays: &'a RayPacket,
    watertight: &'a WatertightPacket,
    mesh: &'a MeshFrame,
    counts: Counts<'a, F>,
    collector: &'a mut G,
}

impl<I: Isa, F: Filter, G: PacketCollector, const WATERTIGHT: bool> PacketVisitor<I>
    for BottomLevelVisitor<'_, F, G, WATERTIGHT>
{
    const ANY: bool = G::ANY;

    #[inline(always)]
    fn t_max(&self) -> &Column {
        self.collector.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, set: u64) -> bool {
        let mut is_nearer = false;
        for item in link.item_index()..link.item_index() + link.item_count() {
            let block = self.mesh.bvh.block(item);
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
                    let mut corners = [[isa.splat16(0.0); 3]; 3];
                    for corner in 0..3 {
                        for axis in 0..3 {
                            corners[corner][axis] = isa.splat16(block.corners[corner][axes[axis] % 3][lane & 3]);
                        }
                    }
                    let primitive = block.primitives[lane & 3];
                    for row in 0..PACKET / 16 {
                        let lanes = lanes_of(set, row);
                        if lanes == 0 {
                            continue;
                        }
                        let mut hits = self.watertight.hits::<I, WATERTIGHT>(
                            isa,
                            self.rays,
                            axes,
                            (&corners, block.extents()[lane & 3]),
                            (row, lanes),
                            self.collector.t_max(),
                        );
                        if hits.lanes | hits.ambiguous == 0 {
                            continue;
                        }
                        is_nearer = true;
                        hits.lanes = self.counts.of(isa, row, &hits, primitive);
                        if hits.lanes != 0 {
                            self.collector.take(isa, row, &hits, primitive, self.counts.instance);
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

impl<'a, F: Filter, G: PacketCollector, const WATERTIGHT: bool> BottomLevelVisitor<'a, F, G, WATERTIGHT> {
    fn in_single_precision(self) -> BottomLevelVisitor<'a, F, G, false> {
        let Self { rays, watertight, mesh, counts, collector } = self;
        BottomLevelVisitor { rays, watertight, mesh, counts, collector }
    }

    #[inline(always)]
    fn walk<I: Isa>(mut self, isa: I, planes: &PacketPlanes, set: u64) {
        for set in octants(set, self.rays.negative) {
            let interval = Interval::new(isa, self.rays, planes, set);
            walk_packet(isa, self.mesh.bvh.tree(), self.rays, planes, &interval, &mut self);
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
                self.collector.t_max().get(ray),
            );
            let mut mask = hits.mask;
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize & 3;
                mask &= mask - 1;
                let (hit, primitive) = (hits.lane(lane), block.primitives[lane]);
                if hit.t.is_finite() && self.counts.one(ray, &hit, primitive) {
                    is_nearer = true;
                    self.collector.take_one(ray, &hit, primitive, self.counts.instance);
                }
            }
        }
        is_nearer
    }

    /// Decides without rounding errors what single precision cannot.
    #[cold]
    fn test_exactly(&mut self, row: usize, lanes: u16, primitive: u32) {
        for ray in (0..16).filter(|lane| lanes >> lane & 1 == 1).map(|lane| row * 16 + lane) {
            let local = self.rays.ray(ray);
            let triangle = self.mesh.triangles.get(primitive);
            let hit = exact::hit(&local, &triangle, local.t_min, self.collector.t_max().get(ray));
            if let Some(hit) = hit.filter(|hit| self.counts.one(ray, hit, primitive)) {
                self.collector.take_one(ray, &hit, primitive, self.counts.instance);
            }
        }
    }
}

/// Which hits of a packet on an instance count.
pub(super) struct Counts<'a, F> {
    rules: Rules<F>,
    /// Number of the packet's first ray in its batch.
    first: usize,
    pub(super) instance: u32,
    pub(super) record: &'a InstanceRecord,
}

impl<F: Filter> Counts<'_, F> {
    /// The lanes of a row whose hits count.
    #[inline(always)]
    fn of<I: Isa>(&self, isa: I, row: usize, hits: &RowHits<I>, primitive: u32) -> u16 {
        let lanes = match self.rules.cull {
            Cull::None => hits.lanes,
            Cull::Back => hits.lanes & !hits.back,
            Cull::Front => hits.lanes & hits.back,
        };
        if !F::ASKS || !self.rules.filter.asks_about(self.record) || lanes == 0 {
            return lanes;
        }
        let [u, v] = hits.weights(isa);
        let columns = [isa.store16(hits.t), isa.store16(u), isa.store16(v)];
        self.accepted((row, lanes), &columns, hits.back, primitive)
    }

    #[inline(never)]
    fn accepted(&self, (row, lanes): (usize, u16), [t, u, v]: &[Row; 3], back: u16, primitive: u32) -> u16 {
        let (mut left, mut accepted) = (lanes, 0);
        while left != 0 {
            let lane = left.trailing_zeros() as usize & 15;
            left &= left - 1;
            let hit = TriangleHit { t: t.0[lane], u: u.0[lane], v: v.0[lane], back: back >> lane & 1 == 1 };
            accepted |= u16::from(self.is_accepted(row * 16 + lane, &hit, primitive)) << lane;
        }
        accepted
    }

    /// Whether the hit of one ray of the packet counts.
    pub(super) fn one(&self, ray: usize, hit: &TriangleHit, primitive: u32) -> bool {
        self.rules.cull.keeps(hit) && self.is_accepted(ray, hit, primitive)
    }

    fn is_accepted(&self, ray: usize, hit: &TriangleHit, primitive: u32) -> bool {
        let filter = self.rules.for_ray(self.first + ray).filter;
        filter.accepts(hit, primitive, self.instance, self.record)
    }
}

impl<F: Filter> Rules<F> {
    pub(super) fn for_ray(self, number: usize) -> Self {
        Self { filter: self.filter.for_ray(number as u32), ..self }
    }
}
