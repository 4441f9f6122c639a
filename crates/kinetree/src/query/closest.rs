//! The nearest hit.

use std::ops::ControlFlow;

use super::Hit;
use super::trace_ray::HitCollector;
use crate::traverse::FrameStamp;

/// The nearest hit so far; at equal distance the one with the smaller (instance, primitive).
pub(crate) struct Closest {
    t_max: f32,
    hit: Option<Hit>,
}

impl HitCollector for Closest {
    const ANY: bool = false;
    type Answer = Option<Hit>;

    #[inline(always)]
    fn within(t_max: f32) -> Self {
        Self { t_max, hit: None }
    }

    #[inline(always)]
    fn answer(self, stamp: FrameStamp) -> Option<Hit> {
        self.hit.map(|hit| hit.stamped(stamp))
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn collect(&mut self, hit: Hit) -> ControlFlow<()> {
        if self.hit.is_none_or(|best| hit.key() < best.key()) {
            self.t_max = hit.t;
            self.hit = Some(hit);
        }
        ControlFlow::Continue(())
    }
}
