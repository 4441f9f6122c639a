//! Many rays at once: packets for coherent rays, a better order for others. The answers
//! are those of single calls, to the bit.

use super::candidate::{Filter, NoFilter, QueryFilter};
use super::collector::Wanted;
use super::packet_hits::PacketHits;
use super::trace_packet::TracePacket;
use super::two_level::Rules;
use super::{Coherence, Cull, Hit, sort, trace_ray};
use crate::geometry::Ray;
use crate::simd::{Isa, Kernel, Level};
use crate::traverse::{FrameBvh, PACKET, Work};

/// The nearest hit of each ray. The filter is called only if `has_filter`.
///
/// # Panics
/// When there are not as many hits as rays.
pub(super) fn closest_hits(
    world: &FrameBvh,
    rays: &[Ray],
    (rules, has_filter): (Rules<QueryFilter<'_>>, bool),
    hits: &mut [Option<Hit>],
    coherence: Coherence,
) {
    assert_eq!(rays.len(), hits.len(), "one hit per ray");
    let of_packet = |packet: &PacketHits, at: usize| packet.hit(at, world.stamp);
    let filtered = |number: usize, ray: &Ray| {
        let (rules, work) = (rules.for_ray(number), &mut Work::default());
        trace_ray::dynamic(world, ray, rules, Wanted::Closest, work)?.hit(world.stamp)
    };
    let batch = Batch { world, rays, rules, wanted: Wanted::Closest, coherence };
    if has_filter {
        batch.trace(hits, of_packet, filtered);
    } else {
        let Rules { mask, cull, .. } = rules;
        let filter = NoFilter;
        batch.trace(hits, of_packet, |_, ray| trace_ray::closest(world, ray, Rules { mask, cull, filter }));
    }
}

/// Whether each ray hits anything. The filter is called only if `has_filter`.
///
/// # Panics
/// When there are not as many answers as rays.
pub(super) fn occluded_each(
    world: &FrameBvh,
    rays: &[Ray],
    (rules, has_filter): (Rules<QueryFilter<'_>>, bool),
    answers: &mut [bool],
    coherence: Coherence,
) {
    assert_eq!(rays.len(), answers.len(), "one answer per ray");
    let of_packet = |packet: &PacketHits, at: usize| packet.is_hit(at);
    let filtered = |number: usize, ray: &Ray| {
        let (rules, work) = (rules.for_ray(number), &mut Work::default());
        trace_ray::dynamic(world, ray, rules, Wanted::Any, work).is_some_and(|collector| collector.is_hit())
    };
    let batch = Batch { world, rays, rules, wanted: Wanted::Any, coherence };
    if has_filter {
        batch.trace(answers, of_packet, filtered);
    } else {
        let Rules { mask, cull, .. } = rules;
        let filter = NoFilter;
        batch.trace(answers, of_packet, |_, ray| trace_ray::occluded(world, ray, Rules { mask, cull, filter }));
    }
}

/// Rays, and what is asked of each.
struct Batch<'a> {
    world: &'a FrameBvh,
    rays: &'a [Ray],
    rules: Rules<QueryFilter<'a>>,
    wanted: Wanted,
    coherence: Coherence,
}

impl Batch<'_> {
    /// Answers all rays. `of_packet` reads the answer of one ray from those of a packet; `alone`
    /// answers for the ray with a number.
    fn trace<A>(
        &self,
        answers: &mut [A],
        of_packet: impl Fn(&PacketHits, usize) -> A,
        alone: impl Fn(usize, &Ray) -> A,
    ) {
        match self.coherence {
            Coherence::Coherent if self.world.level.is_vector() => self.trace_packets(answers, of_packet, alone),
            Coherence::Incoherent if self.is_worth_sorting() => {
                let mut sorter = sort::Sorter::new(self.world.top.bounds());
                let blocks = self.rays.chunks(sort::BLOCK).zip(answers.chunks_mut(sort::BLOCK)).enumerate();
                for (block, (rays, answers)) in blocks {
                    let alone = |number: usize, ray: &Ray| alone(block * sort::BLOCK + number, ray);
                    in_order(self.world.level, rays, answers, sorter.order(rays), alone);
                }
            }
            _ => {
                for (number, (ray, answer)) in self.rays.iter().zip(answers).enumerate() {
                    *answer = alone(number, ray);
                }
            }
        }
    }

    fn trace_packets<A>(
        &self,
        answers: &mut [A],
        of_packet: impl Fn(&PacketHits, usize) -> A,
        alone: impl Fn(usize, &Ray) -> A,
    ) {
        let Self { world, rules, .. } = *self;
        let mut hits = PacketHits::new(self.wanted == Wanted::Any);
        for (packet, (rays, answers)) in self.rays.chunks(PACKET).zip(answers.chunks_mut(PACKET)).enumerate() {
            let first = packet * PACKET;
            // A level without vectors traces every ray alone.
            let kernel = TracePacket { world, rays, rules, first, hits: &mut hits };
            let left = world.level.run_vector(kernel, || u64::MAX);
            for (at, (ray, answer)) in rays.iter().zip(answers).enumerate() {
                *answer = if left >> at & 1 == 1 { alone(first + at, ray) } else { of_packet(&hits, at) };
            }
        }
    }

    /// Whether sorting pays: rays are sampled without any filter.
    fn is_worth_sorting(&self) -> bool {
        let (mask, cull, filter) = (u32::MAX, Cull::None, NoFilter.to_dynamic(self.world));
        let sampled = |ray: &Ray, work: &mut Work| {
            trace_ray::dynamic(self.world, ray, Rules { mask, cull, filter }, self.wanted, work);
        };
        sort::is_worth_while(self.world, self.rays, sampled)
    }
}

/// Traces rays in another order.
fn in_order<A>(
    level: Level,
    rays: &[Ray],
    answers: &mut [A],
    order: &[sort::SortedRay],
    alone: impl Fn(usize, &Ray) -> A,
) {
    let (mut gathered, mut answered) = (Vec::with_capacity(sort::FETCHED), Vec::with_capacity(sort::FETCHED));
    for (at, some) in order.chunks(sort::FETCHED).enumerate() {
        // Rays are copied before they are traced, and answers after, so that cache misses overlap.
        // A store that misses alone stalls those to the stack of the next walk: 150 to 250 ns a
        // ray. While some rays are traced, the next ones and the memory of answers are prefetched.
        gathered.clear();
        gathered.extend(some.iter().map(|entry| rays[entry.ray()]));
        answered.clear();
        let next = &order[order.len().min((at + 1) * sort::FETCHED)..];
        for (group, here) in some.chunks(PREFETCH_BATCH).enumerate() {
            let first = group * PREFETCH_BATCH;
            let next = &next[next.len().min(first)..next.len().min(first + PREFETCH_BATCH)];
            level.run(Prefetch { rays, answers, here, next });
            answered.extend(here.iter().zip(&gathered[first..]).map(|(entry, ray)| alone(entry.ray(), ray)));
        }
        for (entry, answer) in some.iter().zip(answered.drain(..)) {
            answers[entry.ray()] = answer;
        }
    }
}

/// For how many rays at a time memory is asked.
const PREFETCH_BATCH: usize = 8;

/// Prefetches the rays that come next, and the memory of answers that come soon. Each may span two
/// cache lines.
struct Prefetch<'a, A> {
    rays: &'a [Ray],
    answers: &'a [A],
    here: &'a [sort::SortedRay],
    next: &'a [sort::SortedRay],
}

impl<A> Kernel for Prefetch<'_, A> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        for entry in self.next {
            isa.prefetch(self.rays, entry.ray());
            isa.prefetch(self.rays, entry.ray() + 1);
        }
        for entry in self.here {
            isa.prefetch(self.answers, entry.ray());
            isa.prefetch(self.answers, entry.ray() + 1);
        }
    }
}
