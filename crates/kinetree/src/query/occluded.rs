//! Is there anything between a point and a light?

use std::ops::ControlFlow;

use super::Hit;
use super::trace_ray::HitCollector;
use crate::traverse::FrameStamp;

/// Ends at the first hit.
pub(crate) struct Occluded {
    t_max: f32,
    found: bool,
}

impl HitCollector for Occluded {
    const ANY: bool = true;
    type Answer = bool;

    #[inline(always)]
    fn within(t_max: f32) -> Self {
        Self { t_max, found: false }
    }

    #[inline(always)]
    fn answer(self, _: FrameStamp) -> bool {
        self.found
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn collect(&mut self, _: Hit) -> ControlFlow<()> {
        self.found = true;
        ControlFlow::Break(())
    }
}
