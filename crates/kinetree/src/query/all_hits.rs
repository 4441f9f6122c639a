//! Every hit, near to far.

use std::ops::ControlFlow;

use super::Hit;
use super::trace_ray::HitCollector;
use crate::traverse::FrameStamp;

/// Keeps all. A triangle that stands in several leaves is met more than once, and reported once.
pub(crate) struct AllHits {
    t_max: f32,
    met: Vec<Hit>,
}

impl HitCollector for AllHits {
    const ANY: bool = false;
    type Answer = Vec<Hit>;

    #[inline]
    fn within(t_max: f32) -> Self {
        Self { t_max, met: Vec::new() }
    }

    /// Near to far; at equal distance by (instance, primitive).
    fn answer(mut self, stamp: FrameStamp) -> Vec<Hit> {
        self.met.sort_unstable_by(|a, b| {
            let ((t, instance, primitive), (u, other_instance, other_primitive)) = (a.key(), b.key());
            t.total_cmp(&u).then((instance, primitive).cmp(&(other_instance, other_primitive)))
        });
        self.met.dedup_by_key(|hit| hit.key());
        self.met.iter_mut().for_each(|hit| *hit = hit.stamped(stamp));
        self.met
    }

    #[inline]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    fn collect(&mut self, hit: Hit) -> ControlFlow<()> {
        self.met.push(hit);
        ControlFlow::Continue(())
    }
}
