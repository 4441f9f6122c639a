//! Tracing through snapshots, ray by ray and in batches.

use std::cell::RefCell;

use kinetree::query::sort::BLOCK;
use kinetree::{Coherence, Hit, Snapshot, Work};

use crate::engine::interface::{Batch, Facts, Mode, Tree};
use crate::ray::{Answer, Ray};
use crate::rays::QueryKind;

/// A committed frame.
pub(super) struct BuiltTree {
    pub(super) view: Snapshot,
}

#[inline]
fn engine_ray(ray: &Ray) -> kinetree::Ray {
    kinetree::Ray::new(ray.origin, ray.direction).with_range(0.0, ray.t_max)
}

#[inline]
fn answer(hit: Option<Hit>) -> Answer {
    hit.map_or(Answer::MISS, |hit| Answer {
        t: hit.t,
        u: hit.u,
        v: hit.v,
        primitive: hit.primitive,
        mesh: hit.instance_index(),
    })
}

impl Tree for BuiltTree {
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]) {
        for (ray, slot) in rays.iter().zip(answers) {
            *slot = answer(self.view.closest_hit(&engine_ray(ray)));
        }
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        for (ray, slot) in rays.iter().zip(answers) {
            *slot = self.view.occluded(&engine_ray(ray));
        }
    }

    fn batches(&self) -> Vec<&dyn Batch> {
        vec![self]
    }

    fn facts(&self) -> Facts {
        let trees = || self.view.instances().map(|instance| instance.bvh());
        Facts {
            bytes: Some(trees().map(|tree| tree.heap_bytes()).sum()),
            peak: None,
            cost: trees().map(|tree| tree.cost(1.0, 1.0)).next(),
            overlap: trees().map(|tree| tree.overlap()).next(),
        }
    }

    fn count(&self, rays: &[Ray], query_kind: QueryKind) -> Option<Work> {
        let mut work = Work::default();
        let query = self.view.query();
        for ray in rays {
            match query_kind {
                QueryKind::Closest => drop(query.closest_hit_counted(&engine_ray(ray), &mut work)),
                QueryKind::Occluded => drop(query.occluded_counted(&engine_ray(ray), &mut work)),
            }
        }
        Some(work)
    }
}

impl Batch for BuiltTree {
    fn suffix(&self) -> &'static str {
        ""
    }

    fn mode(&self) -> Mode {
        Mode::Batch
    }

    fn suits(&self, _: Coherence) -> bool {
        true
    }

    fn closest(&self, rays: &[Ray], answers: &mut [Answer], coherence: Coherence) {
        BUFFERS.with_borrow_mut(|BatchBuffers { block, hits }| {
            for (rays, answers) in rays.chunks(block_length(coherence)).zip(answers.chunks_mut(block_length(coherence)))
            {
                block.clear();
                block.extend(rays.iter().map(engine_ray));
                hits.resize(rays.len(), None);
                self.view.closest_hits(block, hits, coherence);
                answers.iter_mut().zip(hits.iter()).for_each(|(slot, hit)| *slot = answer(*hit));
            }
        });
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool], coherence: Coherence) {
        BUFFERS.with_borrow_mut(|BatchBuffers { block, .. }| {
            for (rays, answers) in rays.chunks(block_length(coherence)).zip(answers.chunks_mut(block_length(coherence)))
            {
                block.clear();
                block.extend(rays.iter().map(engine_ray));
                self.view.occluded_each(block, answers, coherence);
            }
        });
    }
}

/// Rays and hits in the library's types. A thread keeps them from batch to batch, as a renderer
/// does.
#[derive(Default)]
struct BatchBuffers {
    block: Vec<kinetree::Ray>,
    hits: Vec<Option<Hit>>,
}

thread_local! {
    static BUFFERS: RefCell<BatchBuffers> = RefCell::default();
}

/// How many rays are converted at a time: as many as caches hold, or, for rays that will be sorted,
/// as many as the library sorts together.
fn block_length(coherence: Coherence) -> usize {
    if coherence == Coherence::Incoherent { BLOCK } else { 1024 }
}
