//! What an engine implements to be measured.
//!
//! An engine brings triangles into its preferred form ([`Engine::prepare`], not timed), builds a
//! tree ([`Prepared::build`], timed) and traces sets of rays ([`Tree`]). The loop over the rays is
//! inside the engine, so that no engine pays for a virtual call per ray; each reads the same 28
//! bytes and writes distance, weights, triangle and mesh.

use kinetree::{Coherence, Work};

use super::thread_pool::ThreadPool;
use crate::failure::Failure;
use crate::level::OWN_BUILD;
use crate::ray::{Answer, Ray};
use crate::rays::QueryKind;
use crate::soup::Soup;

/// The kind of tree; trees are compared within a class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum Class {
    /// Built as quickly as possible.
    Fastest,
    /// A good tree at a build time that a loading screen allows.
    Fast,
    /// The best tree, at any build time.
    Best,
}

/// A ray tracer with its settings.
pub(crate) trait Engine {
    /// Name and settings; the names of kinetree's settings begin with `kinetree`.
    fn name(&self) -> &str;

    /// The kind of its trees.
    fn class(&self) -> Class;

    /// The instructions that it uses: the level that it was forced to, or [`OWN_BUILD`] if it
    /// cannot be forced.
    fn instructions(&self) -> &str {
        OWN_BUILD
    }

    /// Whether it promises watertight hits: no ray passes between neighbouring triangles.
    fn is_robust(&self) -> bool {
        false
    }

    /// Whether another setting of the same engine builds the same trees, so that its builds need
    /// not be timed.
    fn shares_builds(&self) -> bool {
        false
    }

    /// Brings triangles into the form that the engine prefers.
    ///
    /// # Errors
    /// The engine cannot build these triangles.
    fn prepare(&self, soup: &Soup) -> Result<Box<dyn Prepared>, Failure>;

    /// A tree that is refitted when vertices move; `None` if the engine cannot refit.
    ///
    /// # Errors
    /// The engine cannot build these triangles.
    fn refitter(&self, _soup: &Soup, _pool: &ThreadPool) -> Result<Option<Box<dyn Refit>>, Failure> {
        Ok(None)
    }
}

/// Triangles in an engine's own form.
pub(crate) trait Prepared {
    /// Gets ready for another build on these threads: makes devices, scenes, and copies that a
    /// build consumes. Not timed.
    ///
    /// # Errors
    /// The engine cannot build these triangles.
    fn set_up(&mut self, _pool: &ThreadPool) -> Result<(), Failure> {
        Ok(())
    }

    /// Builds a tree that is ready for tracing.
    ///
    /// # Errors
    /// The build failed.
    fn build(&mut self, pool: &ThreadPool) -> Result<Box<dyn Tree>, Failure>;

    /// The expected cost of a ray as in [`Facts::cost`], for engines that report it only when asked
    /// before a build: builds once more.
    fn measure_cost(&mut self, _pool: &ThreadPool) -> Option<f32> {
        None
    }
}

/// A tree that traces rays.
pub(crate) trait Tree: Send + Sync {
    /// The nearest hit of each ray, one call per ray.
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]);

    /// Whether each ray hits anything, one call per ray.
    fn occluded(&self, rays: &[Ray], answers: &mut [bool]);

    /// The ways of tracing many rays at once.
    fn batches(&self) -> Vec<&dyn Batch> {
        Vec::new()
    }

    /// What is known about the tree.
    fn facts(&self) -> Facts {
        Facts::default()
    }

    /// Counts the work of tracing these rays, if the engine can.
    fn count(&self, _rays: &[Ray], _question: QueryKind) -> Option<Work> {
        None
    }
}

/// A way of tracing many rays at once. Bringing rays and answers into another order or layout is
/// part of it.
pub(crate) trait Batch: Sync {
    /// Follows the engine's name, such as `x16`.
    fn suffix(&self) -> &'static str;

    /// `packet` or `batch`.
    fn mode(&self) -> Mode;

    /// Whether it is meant for such rays.
    fn suits(&self, coherence: Coherence) -> bool;

    /// The nearest hit of each ray.
    fn closest(&self, rays: &[Ray], answers: &mut [Answer], coherence: Coherence);

    /// Whether each ray hits anything.
    fn occluded(&self, rays: &[Ray], answers: &mut [bool], coherence: Coherence);
}

/// How rays are handed to an engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Mode {
    /// One call per ray.
    Single,
    /// Many rays per call, in an order of the engine's own.
    Batch,
    /// Packets: rays side by side in vector registers.
    #[cfg_attr(not(feature = "embree"), allow(dead_code))]
    Packet,
}

/// A tree that is refitted when its vertices move.
pub(crate) trait Refit {
    /// Takes new positions, as many as before, and refits the tree.
    ///
    /// # Errors
    /// The refit failed, or the engine rebuilt the tree instead.
    fn refit(&mut self, positions: &[[f32; 3]]) -> Result<(), Failure>;
}

/// What is known about a tree.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Facts {
    /// Bytes of the finished tree with its leaves; `None` if only the allocator knows.
    pub(crate) bytes: Option<usize>,
    /// The peak of the build in bytes, if the engine counts its memory itself.
    pub(crate) peak: Option<usize>,
    /// Expected cost of a ray by Embree's formula: the sum over wide nodes and triangle blocks of
    /// their areas, over the root's, without further factors. For engines that do not expose their
    /// wide trees: binary nodes and triangles.
    pub(crate) cost: Option<f32>,
    /// Summed area of the intersections of sibling boxes, over the root's.
    pub(crate) overlap: Option<f32>,
}
