//! What a query keeps of the hits that a walk brings.

use std::ops::ControlFlow;

use super::Hit;
use crate::traverse::FrameStamp;

/// Receives the hits of one ray, each at least once, in no particular order.
pub(crate) trait HitCollector: Sized {
    /// What a query has to say about the hits that it wants; `()` where the type says it all.
    type Wanted: Copy;

    /// The result. The default is that of a ray that cannot hit anything.
    type Answer: Default;

    /// No hit yet, of a ray that ends at `t_max`.
    fn new(wanted: Self::Wanted, t_max: f32) -> Self;

    /// Whether any hit will do, so that the order of children does not matter.
    fn wants_any(&self) -> bool;

    /// Hits beyond this do not matter (any more).
    fn t_max(&self) -> f32;

    /// Receives a hit that counts. `Break` when no other is needed.
    fn collect(&mut self, hit: Hit) -> ControlFlow<()>;

    /// The result, of the frame with this stamp.
    fn answer(self, stamp: FrameStamp) -> Self::Answer;

    /// The same state in the form that the rare paths are compiled for.
    fn to_dynamic(&self) -> DynamicCollector;

    /// Takes over what a rare path has found.
    fn update_from(&mut self, dynamic: DynamicCollector);
}

/// Which hits a query wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// The nearest one; at equal distance the one with the smaller (instance, primitive).
    Closest,
    /// Any one.
    Any,
    /// Every one.
    All,
}

/// Decides at run time which hits it keeps: for queries with filters or counters, and for rare
/// paths, all of which are compiled once.
#[derive(Debug)]
pub(crate) struct DynamicCollector {
    wanted: Wanted,
    t_max: f32,
    hit: Option<Hit>,
    all: Vec<Hit>,
}

impl DynamicCollector {
    /// A state in which `hit` has been found already.
    #[inline(always)]
    pub(super) fn with_hit(wanted: Wanted, t_max: f32, hit: Option<Hit>) -> Self {
        Self { wanted, t_max, hit, all: Vec::new() }
    }

    /// The hit that was kept, of the frame with this stamp.
    pub(super) fn hit(self, stamp: FrameStamp) -> Option<Hit> {
        self.hit.map(|hit| hit.stamped(stamp))
    }

    /// Whether there was a hit.
    #[inline(always)]
    pub(super) fn is_hit(&self) -> bool {
        self.hit.is_some()
    }

    /// All hits, near to far; at equal distance by (instance, primitive). A triangle that stands in
    /// several leaves is met more than once, and listed once.
    pub(super) fn all_hits(mut self, stamp: FrameStamp) -> Vec<Hit> {
        self.all.sort_unstable_by(|a, b| {
            let ((t, instance, primitive), (u, other_instance, other_primitive)) = (a.key(), b.key());
            t.total_cmp(&u).then((instance, primitive).cmp(&(other_instance, other_primitive)))
        });
        self.all.dedup_by_key(|hit| hit.key());
        self.all.iter_mut().for_each(|hit| *hit = hit.stamped(stamp));
        self.all
    }
}

impl HitCollector for DynamicCollector {
    type Wanted = Wanted;
    type Answer = Option<Self>;

    #[inline(always)]
    fn new(wanted: Wanted, t_max: f32) -> Self {
        Self::with_hit(wanted, t_max, None)
    }

    #[inline(always)]
    fn wants_any(&self) -> bool {
        self.wanted == Wanted::Any
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline]
    fn collect(&mut self, hit: Hit) -> ControlFlow<()> {
        match self.wanted {
            Wanted::Closest => {
                if self.hit.is_none_or(|best| hit.key() < best.key()) {
                    self.t_max = hit.t;
                    self.hit = Some(hit);
                }
            }
            Wanted::Any => {
                self.hit = Some(hit);
                return ControlFlow::Break(());
            }
            Wanted::All => self.all.push(hit),
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn answer(self, _: FrameStamp) -> Option<Self> {
        Some(self)
    }

    #[inline(always)]
    fn to_dynamic(&self) -> DynamicCollector {
        Self { all: Vec::new(), ..*self }
    }

    #[inline(always)]
    fn update_from(&mut self, mut dynamic: DynamicCollector) {
        (self.t_max, self.hit) = (dynamic.t_max, dynamic.hit);
        self.all.append(&mut dynamic.all);
    }
}

/// The nearest hit so far; at equal distance the one with the smaller (instance, primitive).
pub(crate) struct Closest {
    t_max: f32,
    hit: Option<Hit>,
}

impl HitCollector for Closest {
    type Wanted = ();
    type Answer = Option<Hit>;

    #[inline(always)]
    fn new((): (), t_max: f32) -> Self {
        Self { t_max, hit: None }
    }

    #[inline(always)]
    fn wants_any(&self) -> bool {
        false
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

    #[inline(always)]
    fn answer(self, stamp: FrameStamp) -> Option<Hit> {
        self.hit.map(|hit| hit.stamped(stamp))
    }

    // Inlined, so that no address of the collector is taken and it stays in registers.
    #[inline(always)]
    fn to_dynamic(&self) -> DynamicCollector {
        DynamicCollector::with_hit(Wanted::Closest, self.t_max, self.hit)
    }

    #[inline(always)]
    fn update_from(&mut self, dynamic: DynamicCollector) {
        (self.t_max, self.hit) = (dynamic.t_max, dynamic.hit);
    }
}

/// Is there anything between a point and a light? Ends at the first hit.
pub(crate) struct Occluded {
    t_max: f32,
    found: bool,
}

impl HitCollector for Occluded {
    type Wanted = ();
    type Answer = bool;

    #[inline(always)]
    fn new((): (), t_max: f32) -> Self {
        Self { t_max, found: false }
    }

    #[inline(always)]
    fn wants_any(&self) -> bool {
        true
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

    #[inline(always)]
    fn answer(self, _: FrameStamp) -> bool {
        self.found
    }

    // Inlined, so that no address of the collector is taken and it stays in registers.
    #[inline(always)]
    fn to_dynamic(&self) -> DynamicCollector {
        DynamicCollector::with_hit(Wanted::Any, self.t_max, None)
    }

    #[inline(always)]
    fn update_from(&mut self, dynamic: DynamicCollector) {
        self.found |= dynamic.is_hit();
    }
}
