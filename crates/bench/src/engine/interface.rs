//! What an engine has to offer to be measured.
//!
//! An engine brings triangles into the form that it likes best ([`Engine::prepare`], not timed),
//! builds a tree ([`Prepared::build`], timed) and traces sets of rays ([`Tree`]). The loop over the
//! rays is inside the engine, so that no engine pays for a virtual call per ray; each reads the
//! same 28 bytes and writes distance, weights, triangle and mesh.

use kinetree::{Coherence, Work};

use super::thread_pool::ThreadPool;
use crate::failure::Failure;
use crate::level::OWN_BUILD;
use crate::ray::{Answer, Ray};
use crate::rays::Question;
use crate::soup::Soup;

/// What a tree was built for: like is compared with like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum Class {
    /// As quickly as can be.
    Fastest,
    /// Good trees at a price that a loading screen can pay.
    Fast,
    /// The best tree, whatever it takes.
    Best,
}

/// A ray tracer with its settings.
pub(crate) trait Engine {
    /// Name and settings; those of ours begin with `kinetree`.
    fn name(&self) -> &str;

    /// What its trees are for.
    fn class(&self) -> Class;

    /// The instructions that it runs with: the level that it was forced to, or [`OWN_BUILD`] where
    /// it has no switch.
    fn instructions(&self) -> &str {
        OWN_BUILD
    }

    /// Whether it promises that no ray slips between neighbouring triangles.
    fn is_robust(&self) -> bool {
        false
    }

    /// Whether another setting of the same engine builds the very same trees, so that timing this
    /// one as well would say nothing new.
    fn shares_builds(&self) -> bool {
        false
    }

    /// Brings triangles into the form that it likes best.
    ///
    /// # Errors
    /// What keeps it from building.
    fn prepare(&self, soup: &Soup) -> Result<Box<dyn Prepared>, Failure>;

    /// Something whose tree follows moving vertices by refit, if the engine can do that.
    ///
    /// # Errors
    /// What keeps it from building.
    fn refitter(&self, _soup: &Soup, _pool: &ThreadPool) -> Result<Option<Box<dyn Refit>>, Failure> {
        Ok(None)
    }
}

/// Triangles in an engine's own form.
pub(crate) trait Prepared {
    /// Makes ready for another build, by as many threads as it is going to have: devices, scenes,
    /// copies that a build uses up. Not timed.
    ///
    /// # Errors
    /// What keeps it from building.
    fn set_up(&mut self, _pool: &ThreadPool) -> Result<(), Failure> {
        Ok(())
    }

    /// Builds, up to a tree that can be traced.
    ///
    /// # Errors
    /// What went wrong.
    fn build(&mut self, pool: &ThreadPool) -> Result<Box<dyn Tree>, Failure>;

    /// The expected cost of a ray by the formula of [`Facts::cost`], where the engine tells it only
    /// on request: it builds once more.
    fn measure_cost(&mut self, _pool: &ThreadPool) -> Option<f32> {
        None
    }
}

/// A tree that answers rays.
pub(crate) trait Tree: Send + Sync {
    /// The nearest hit of each ray, one call per ray.
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]);

    /// Whether each ray hits anything, one call per ray.
    fn occluded(&self, rays: &[Ray], answers: &mut [bool]);

    /// Ways of answering many rays at once.
    fn batches(&self) -> Vec<&dyn Batch> {
        Vec::new()
    }

    /// What is known about the tree.
    fn facts(&self) -> Facts {
        Facts::default()
    }

    /// How much work a set of rays is, if the engine can tell.
    fn count(&self, _rays: &[Ray], _question: Question) -> Option<Work> {
        None
    }
}

/// A way of answering many rays at once. Bringing rays and answers into another order or layout is
/// part of it.
pub(crate) trait Batch: Sync {
    /// Added to the engine's name, such as `x16`.
    fn suffix(&self) -> &'static str;

    /// `packet` or `batch`.
    fn mode(&self) -> Mode;

    /// Whether it is any use for such rays.
    fn suits(&self, coherence: Coherence) -> bool;

    /// The nearest hit of each ray.
    fn closest(&self, rays: &[Ray], answers: &mut [Answer], coherence: Coherence);

    /// Whether each ray hits anything.
    fn occluded(&self, rays: &[Ray], answers: &mut [bool], coherence: Coherence);
}

/// How rays are handed over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Mode {
    /// One call per ray.
    Single,
    /// Many rays, in the engine's own order.
    Batch,
    /// Some rays side by side in registers.
    #[cfg_attr(not(feature = "embree"), allow(dead_code))]
    Packet,
}

/// A tree that follows its vertices.
pub(crate) trait Refit {
    /// Takes new positions, as many as before, and brings the tree up to date.
    ///
    /// # Errors
    /// What went wrong, such as that the engine built anew instead.
    fn refit(&mut self, positions: &[[f32; 3]]) -> Result<(), Failure>;
}

/// What is known about a tree.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Facts {
    /// Bytes of the finished tree with its leaves; the allocator's count, when the engine does not
    /// say.
    pub(crate) bytes: Option<usize>,
    /// The most bytes at a time while it was built, when the engine keeps its own count.
    pub(crate) peak: Option<usize>,
    /// Expected cost of a ray: wide nodes and blocks of triangles, each weighed by its area over
    /// the root's and by nothing else, as Embree's own formula has it. Of engines that do not tell
    /// about their wide trees: binary nodes and triangles.
    pub(crate) cost: Option<f32>,
    /// Summed area of the common boxes of siblings over the root's.
    pub(crate) overlap: Option<f32>,
}
