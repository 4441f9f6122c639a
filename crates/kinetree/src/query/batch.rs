//! Many rays at once: packets for rays that go alike, a better order for those that do not. The answers are those of single calls, to the bit.

use super::packet_collector::{Any, Nearest, PacketCollector};
use super::trace_packet::TracePacket;
use super::trace_ray::{Rules, trace_ray};
use super::{Closest, Coherence, Filter, Hit, Occluded, Query, sort};
use crate::geometry::Ray;
use crate::simd::{Isa, Kernel, Level};
use crate::traverse::{Column, FrameBvh, PACKET, Work};

/// The nearest hit of each ray.
///
/// # Panics
/// When there are not as many hits as rays.
pub(super) fn closest_hits<F: Filter>(
    world: &FrameBvh,
    rays: &[Ray],
    rules: Rules<F>,
    hits: &mut [Option<Hit>],
    coherence: Coherence,
) {
    assert_eq!(rays.len(), hits.len(), "one hit per ray");
    let alone = |number: usize, ray: &Ray| trace_ray::<F, Closest, ()>(world, ray, rules.for_ray(number), &mut ());
    let sampled = |ray: &Ray, work: &mut Work| _ = Query::new(world).closest_hit_counted(ray, work);
    each(world, rays, rules, hits, coherence, (alone, sampled), Nearest::new);
}

/// Whether each ray hits anything.
///
/// # Panics
/// When there are not as many answers as rays.
pub(super) fn occluded_each<F: Filter>(
    world: &FrameBvh,
    rays: &[Ray],
    rules: Rules<F>,
    answers: &mut [bool],
    coherence: Coherence,
) {
    assert_eq!(rays.len(), answers.len(), "one answer per ray");
    let alone = |number: usize, ray: &Ray| trace_ray::<F, Occluded, ()>(world, ray, rules.for_ray(number), &mut ());
    let sampled = |ray: &Ray, work: &mut Work| _ = Query::new(world).occluded_counted(ray, work);
    each(world, rays, rules, answers, coherence, (alone, sampled), Any::new);
}

/// `alone` answers for the ray of a number; `sampled` traces one for what it costs, without any rules.
fn each<F: Filter, G: PacketCollector>(
    world: &FrameBvh,
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
                let left = world.level.run(TracePacket { world, rays, rules, first, answers: answered, within });
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
        for (group, here) in some.chunks(PREFETCH_BATCH).enumerate() {
            let first = group * PREFETCH_BATCH;
            let next = &next[next.len().min(first)..next.len().min(first + PREFETCH_BATCH)];
            level.run(Prefetch { rays, answers, here, next });
            answered.extend(here.iter().zip(&gathered[first..]).map(|(place, ray)| alone(place.ray(), ray)));
        }
        for (place, answer) in some.iter().zip(answered.drain(..)) {
            answers[place.ray()] = answer;
        }
    }
}

/// For how many rays at a time memory is asked.
const PREFETCH_BATCH: usize = 8;

/// Asks for the memory of rays that come next, and of answers that come soon. Each may begin on one cache line and end on another.
struct Prefetch<'a, A> {
    rays: &'a [Ray],
    answers: &'a [A],
    here: &'a [sort::Place],
    next: &'a [sort::Place],
}

impl<A> Kernel for Prefetch<'_, A> {
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
