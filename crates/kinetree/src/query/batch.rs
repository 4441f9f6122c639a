//! Many rays at once: packets for rays that go alike, a better order for those that do not. The answers are those of single calls, to the bit.

use super::ask::{Rules, gathered};
use super::{Closest, Coherence, Cull, Filter, Hit, Occluded, Query, sort};
use crate::geometry::slab::Lean;
use crate::geometry::{Ray, Sheared, TriangleHit};
use crate::simd::{Isa, Kernel, Level, Row};
use crate::traverse::{
    Column, Interval, PACKET, PacketPlanes, PacketVisitor, Posed, RayPacket, RowHits, ShearedPacket, TwoLevel, Work,
    lanes_of, octants, walk_packet,
};
use crate::wide::{InstanceRecord, WideLink};

/// The nearest hit of each ray.
///
/// # Panics
/// When there are not as many hits as rays.
pub(super) fn closest_hits<F: Filter>(
    world: &TwoLevel,
    rays: &[Ray],
    rules: Rules<F>,
    hits: &mut [Option<Hit>],
    coherence: Coherence,
) {
    assert_eq!(rays.len(), hits.len(), "one hit per ray");
    let alone = |number: usize, ray: &Ray| gathered(world, ray, rules.for_ray(number), &mut (), Closest::within)?.hit;
    let sampled = |ray: &Ray, work: &mut Work| _ = Query::new(world).closest_hit_counted(ray, work);
    each(world, rays, rules, hits, coherence, (alone, sampled), Nearest::new);
}

/// Whether each ray hits anything.
///
/// # Panics
/// When there are not as many answers as rays.
pub(super) fn occluded_each<F: Filter>(
    world: &TwoLevel,
    rays: &[Ray],
    rules: Rules<F>,
    answers: &mut [bool],
    coherence: Coherence,
) {
    assert_eq!(rays.len(), answers.len(), "one answer per ray");
    let alone = |number: usize, ray: &Ray| {
        gathered(world, ray, rules.for_ray(number), &mut (), Occluded::within).is_some_and(|occluded| occluded.found)
    };
    let sampled = |ray: &Ray, work: &mut Work| _ = Query::new(world).occluded_counted(ray, work);
    each(world, rays, rules, answers, coherence, (alone, sampled), Any::new);
}

/// `alone` answers for the ray of a number; `sampled` traces one for what it costs, without any rules.
fn each<F: Filter, G: GatherRows>(
    world: &TwoLevel,
    rays: &[Ray],
    rules: Rules<F>,
    answers: &mut [G::Answer],
    coherence: Coherence,
    (alone, sampled): (impl Fn(usize, &Ray) -> G::Answer, impl Fn(&Ray, &mut Work)),
    within: impl Fn(Column) -> G,
) {
    match coherence {
        Coherence::Coherent => {
            for (packet, (rays, answers)) in rays.chunks(PACKET).zip(answers.chunks_mut(PACKET)).enumerate() {
                let first = packet * PACKET;
                let (within, answered) = (&within, &mut *answers);
                let left = world.level.run(Together { world, rays, rules, first, answers: answered, within });
                for at in (0..rays.len()).filter(|at| left >> at & 1 == 1) {
                    answers[at] = alone(first + at, &rays[at]);
                }
            }
        }
        Coherence::Incoherent if sort::is_worth_while(world, rays, sampled) => {
            let mut sorter = sort::Sorter::new(world.top.bounds());
            let blocks = rays.chunks(sort::BLOCK).zip(answers.chunks_mut(sort::BLOCK)).enumerate();
            for (block, (rays, answers)) in blocks {
                let alone = |number: usize, ray: &Ray| alone(block * sort::BLOCK + number, ray);
                in_order(world.level, rays, answers, sorter.order(rays), alone);
            }
        }
        _ => {
            for (number, (ray, answer)) in rays.iter().zip(answers).enumerate() {
                *answer = alone(number, ray);
            }
        }
    }
}

/// Answers rays in another order.
fn in_order<A>(
    level: Level,
    rays: &[Ray],
    answers: &mut [A],
    places: &[sort::Place],
    alone: impl Fn(usize, &Ray) -> A,
) {
    let (mut gathered, mut answered) = (Vec::with_capacity(sort::FETCHED), Vec::with_capacity(sort::FETCHED));
    for (at, some) in places.chunks(sort::FETCHED).enumerate() {
        // Fetched before they are traced, and put away after, so that they wait together for memory. A store that waits alone holds up those
        // to the stack of the next walk: 150 to 250 ns a ray. While some are traced, those that come next are brought near, and the places of answers.
        gathered.clear();
        gathered.extend(some.iter().map(|place| rays[place.ray()]));
        answered.clear();
        let next = &places[places.len().min((at + 1) * sort::FETCHED)..];
        for (group, here) in some.chunks(FORESEEN).enumerate() {
            let first = group * FORESEEN;
            let next = &next[next.len().min(first)..next.len().min(first + FORESEEN)];
            level.run(Foresee { rays, answers, here, next });
            answered.extend(here.iter().zip(&gathered[first..]).map(|(place, ray)| alone(place.ray(), ray)));
        }
        for (place, answer) in some.iter().zip(answered.drain(..)) {
            answers[place.ray()] = answer;
        }
    }
}

/// For how many rays at a time memory is asked.
const FORESEEN: usize = 8;

/// Asks for the memory of rays that come next, and of answers that come soon. Each may begin on one cache line and end on another.
struct Foresee<'a, A> {
    rays: &'a [Ray],
    answers: &'a [A],
    here: &'a [sort::Place],
    next: &'a [sort::Place],
}

impl<A> Kernel for Foresee<'_, A> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        for place in self.next {
            isa.prefetch(self.rays, place.ray());
            isa.prefetch(self.rays, place.ray() + 1);
        }
        for place in self.here {
            isa.prefetch(self.answers, place.ray());
            isa.prefetch(self.answers, place.ray() + 1);
        }
    }
}

/// What a question does with the hits of a packet.
trait GatherRows {
    /// Of each ray.
    type Answer;

    /// For each ray: hits beyond this do not matter (any more).
    fn t_max(&self) -> &Column;

    fn take<I: Isa>(&mut self, isa: I, row: usize, hits: &RowHits<I>, primitive: u32, instance: u32);

    fn take_one(&mut self, ray: usize, hit: &TriangleHit, primitive: u32, instance: u32);

    fn answer(&self, ray: usize) -> Self::Answer;
}

/// The nearest hit of each ray so far; at equal distance the one with the smaller (instance, primitive).
struct Nearest {
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
    fn new(t_max: Column) -> Self {
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

impl GatherRows for Nearest {
    type Answer = Option<Hit>;

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
        isa.keep16(&mut self.t.0[row], lanes, hits.t);
        isa.keep16(&mut self.u.0[row], lanes, u);
        isa.keep16(&mut self.v.0[row], lanes, v);
        isa.keep16(&mut self.primitive.0[row], lanes, isa.splat16(f32::from_bits(primitive)));
        isa.keep16(&mut self.instance.0[row], lanes, isa.splat16(f32::from_bits(instance)));
        let lanes = u64::from(lanes) << (16 * row);
        self.found |= lanes;
        self.back = self.back & !lanes | u64::from(hits.back) << (16 * row) & lanes;
    }

    #[cold]
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
    fn answer(&self, ray: usize) -> Option<Hit> {
        let hit =
            TriangleHit { t: self.t.get(ray), u: self.u.get(ray), v: self.v.get(ray), back: self.back >> ray & 1 == 1 };
        let (instance, primitive) = self.numbers(ray);
        if self.found >> ray & 1 == 1 { Some(Hit::new(&hit, primitive, instance)) } else { None }
    }
}

/// Whether each ray has hit anything. One that has wants nothing any more.
struct Any {
    t_max: Column,
    found: u64,
}

impl Any {
    #[inline(always)]
    fn new(t_max: Column) -> Self {
        Self { t_max, found: 0 }
    }
}

impl GatherRows for Any {
    type Answer = bool;

    #[inline(always)]
    fn t_max(&self) -> &Column {
        &self.t_max
    }

    #[inline(always)]
    fn take<I: Isa>(&mut self, isa: I, row: usize, hits: &RowHits<I>, _: u32, _: u32) {
        isa.keep16(&mut self.t_max.0[row], hits.lanes, isa.splat16(f32::NEG_INFINITY));
        self.found |= u64::from(hits.lanes) << (16 * row);
    }

    #[cold]
    fn take_one(&mut self, ray: usize, _: &TriangleHit, _: u32, _: u32) {
        self.t_max.set(ray, f32::NEG_INFINITY);
        self.found |= 1 << ray;
    }

    #[inline(always)]
    fn answer(&self, ray: usize) -> bool {
        self.found >> ray & 1 == 1
    }
}

impl<F: Filter> Rules<F> {
    fn for_ray(self, number: usize) -> Self {
        Self { filter: self.filter.for_ray(number as u32), ..self }
    }
}

/// Answers a packet, and says which rays are still to be asked alone.
struct Together<'a, F, G: GatherRows, W> {
    world: &'a TwoLevel,
    rays: &'a [Ray],
    rules: Rules<F>,
    /// Number of the first ray in its batch.
    first: usize,
    answers: &'a mut [G::Answer],
    within: &'a W,
}

impl<F: Filter, G: GatherRows, W: Fn(Column) -> G> Kernel for Together<'_, F, G, W> {
    type Output = u64;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> u64 {
        let (rays, set, t_max) = RayPacket::gather(isa, self.rays);
        let gather = (self.within)(t_max);
        let mut visitor =
            InWorld { world: self.world, rays: &rays, rules: self.rules, first: self.first, gather, alone: 0 };
        if self.world.top.instances().len() == 1 {
            // The boxes in the root of its mesh say as much as its own.
            visitor.leaf(isa, WideLink::units(0..1), set);
        } else {
            let planes = PacketPlanes::new(isa, &rays, set, &self.world.top.bounds(), Lean::INSTANCES);
            visitor.alone = planes.careful;
            for set in octants(set & !planes.careful, rays.negative) {
                let interval = Interval::new(isa, &rays, &planes, set);
                walk_packet(isa, self.world.top.tree(), &rays, &planes, &interval, &mut visitor);
            }
        }
        for (at, answer) in self.answers.iter_mut().enumerate() {
            *answer = visitor.gather.answer(at);
        }
        visitor.alone
    }
}

struct InWorld<'a, F, G> {
    world: &'a TwoLevel,
    rays: &'a RayPacket,
    rules: Rules<F>,
    first: usize,
    gather: G,
    /// Rays that only double precision does justice, somewhere.
    alone: u64,
}

impl<I: Isa, F: Filter, G: GatherRows> PacketVisitor<I> for InWorld<'_, F, G> {
    #[inline(always)]
    fn t_max(&self) -> &Column {
        self.gather.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, set: u64) -> bool {
        let units = link.index()..link.index() + link.unit_count();
        for &instance in &self.world.top.instances()[units] {
            let record = &self.world.instances[instance as usize];
            if record.mask & self.rules.mask == 0 {
                continue;
            }
            let moved;
            let (rays, set) = if record.identity {
                (self.rays, set)
            } else {
                let (rays, sane) = self.rays.moved(isa, &record.object_from_world);
                moved = rays;
                (&moved, set & sane)
            };
            let mesh = &*self.world.meshes[record.mesh as usize];
            let planes = PacketPlanes::new(isa, rays, set, &mesh.bvh.bounds(), Lean::TRIANGLES);
            self.alone |= planes.careful;
            let sheared = ShearedPacket::new(isa, rays);
            let counts = Counts { rules: self.rules, first: self.first, instance, record };
            let mut visitor = InMesh { rays, sheared: &sheared, mesh, counts, gather: &mut self.gather };
            for set in octants(set & !planes.careful, rays.negative) {
                let interval = Interval::new(isa, rays, &planes, set);
                walk_packet(isa, mesh.bvh.tree(), rays, &planes, &interval, &mut visitor);
            }
        }
        true
    }
}

struct InMesh<'a, F, G> {
    rays: &'a RayPacket,
    sheared: &'a ShearedPacket,
    mesh: &'a Posed,
    counts: Counts<'a, F>,
    gather: &'a mut G,
}

impl<I: Isa, F: Filter, G: GatherRows> PacketVisitor<I> for InMesh<'_, F, G> {
    #[inline(always)]
    fn t_max(&self) -> &Column {
        self.gather.t_max()
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, set: u64) -> bool {
        let mut is_nearer = false;
        for unit in link.index()..link.index() + link.unit_count() {
            let block = self.mesh.bvh.block(unit);
            for along in 0..3 {
                let set = set & self.sheared.along[along];
                if set == 0 {
                    continue;
                }
                // All rays of the set share an octant.
                let downwards = self.rays.negative[along] & set != 0;
                let axes = ShearedPacket::axes(along, downwards);
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
                        let mut hits =
                            self.sheared.hits(isa, self.rays, axes, &corners, (row, lanes), self.gather.t_max());
                        if hits.lanes | hits.on_edge == 0 {
                            continue;
                        }
                        is_nearer = true;
                        hits.lanes = self.counts.of(isa, row, &hits, primitive);
                        if hits.lanes != 0 {
                            self.gather.take(isa, row, &hits, primitive, self.counts.instance);
                        }
                        if hits.on_edge != 0 {
                            self.look_again(row, hits.on_edge, primitive);
                        }
                    }
                }
            }
        }
        is_nearer
    }
}

impl<F: Filter, G: GatherRows> InMesh<'_, F, G> {
    /// Rays through an edge, or so far beside a triangle that an edge function vanishes, get the second try of the scalar test.
    #[cold]
    fn look_again(&mut self, row: usize, lanes: u16, primitive: u32) {
        for ray in (0..16).filter(|lane| lanes >> lane & 1 == 1).map(|lane| row * 16 + lane) {
            let local = self.rays.ray(ray);
            let hit = Sheared::new(&local).hit(
                &self.mesh.triangles.get(primitive),
                local.t_min,
                self.gather.t_max().get(ray),
            );
            if let Some(hit) = hit.filter(|hit| self.counts.one(ray, hit, primitive)) {
                self.gather.take_one(ray, &hit, primitive, self.counts.instance);
            }
        }
    }
}

/// Which hits of a packet on an instance count.
struct Counts<'a, F> {
    rules: Rules<F>,
    /// Number of the packet's first ray in its batch.
    first: usize,
    instance: u32,
    record: &'a InstanceRecord,
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
        if !F::ASKS || self.record.opaque || lanes == 0 {
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
    fn one(&self, ray: usize, hit: &TriangleHit, primitive: u32) -> bool {
        self.rules.cull.keeps(hit) && self.is_accepted(ray, hit, primitive)
    }

    fn is_accepted(&self, ray: usize, hit: &TriangleHit, primitive: u32) -> bool {
        let filter = self.rules.for_ray(self.first + ray).filter;
        filter.accepts(hit, primitive, self.instance, self.record)
    }
}
