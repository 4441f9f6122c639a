//! The few rays of a packet that come to an instance: one by one.

use std::ops::ControlFlow;

use super::Filter;
use super::gather_rows::GatherRows;
use super::together::{Counts, InWorld};
use crate::geometry::Ray;
use crate::geometry::slab::Lean;
use crate::simd::Isa;
use crate::traverse::{Posed, RayLanes, RayQuads, ShearedLanes, WideVisitor, walk_wide};
use crate::wide::WideLink;

/// So many rays of a packet go through an instance one by one: to make it ready for all takes longer.
pub(super) const FEW: u32 = 8;

impl<F: Filter, G: GatherRows> InWorld<'_, F, G> {
    #[inline(always)]
    pub(super) fn few<I: Isa>(&mut self, isa: I, mut set: u64, mesh: &Posed, counts: Counts<'_, F>) {
        while set != 0 {
            let ray = set.trailing_zeros() as usize & 63;
            set &= set - 1;
            let t_max = self.gather.t_max().get(ray);
            if t_max < 0.0 {
                continue;
            }
            let there = Ray { t_max, ..self.rays.ray(ray) };
            let quads = if counts.record.identity {
                RayQuads::new(isa, &there)
            } else {
                RayQuads::moved(isa, &there, &counts.record.object_from_world)
            };
            let local = quads.ray(isa);
            let tree = mesh.bvh.tree();
            let Some(boxes) = RayLanes::new(isa, &quads, tree.around(), Lean::TRIANGLES) else {
                self.alone |= 1 << ray;
                continue;
            };
            let triangles = ShearedLanes::new(isa, &local);
            let mut visitor = OneInMesh { ray, triangles, mesh, counts: &counts, gather: &mut self.gather };
            walk_wide(isa, tree, boxes, &mut visitor, &mut ());
        }
    }
}

/// One ray of a packet, by itself.
struct OneInMesh<'a, I: Isa, F, G> {
    ray: usize,
    triangles: ShearedLanes<'a, I>,
    mesh: &'a Posed,
    counts: &'a Counts<'a, F>,
    gather: &'a mut G,
}

impl<I: Isa, F: Filter, G: GatherRows> WideVisitor<I, ()> for OneInMesh<'_, I, F, G> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.gather.t_max().get(self.ray)
    }

    #[inline(always)]
    fn leaf(&mut self, isa: I, link: WideLink, (): &mut ()) -> ControlFlow<()> {
        for unit in link.index()..link.index() + link.unit_count() {
            let block = self.mesh.bvh.block(unit);
            let hits = self.triangles.hits(isa, block, self.gather.t_max().get(self.ray));
            let mut mask = hits.mask;
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize & 3;
                mask &= mask - 1;
                let (hit, primitive) = (hits.lane(lane), block.primitives[lane]);
                if hit.t.is_finite() && self.counts.one(self.ray, &hit, primitive) {
                    self.gather.take_one(self.ray, &hit, primitive, self.counts.instance);
                    if self.gather.t_max().get(self.ray) < 0.0 {
                        return ControlFlow::Break(());
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }
}
