//! The options of a build.

use crate::threads::Threads;
use crate::tree::Link;

/// How much build time to trade for traversal speed. Ordered from the fastest build to the fastest
/// traversal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Quality {
    /// For trees that are rebuilt every frame: clustering along a Morton curve, starting from
    /// leaves of several primitives.
    Fastest,
    /// For trees that are built while the game runs: clustering, then reinsertion of the largest
    /// nodes.
    #[default]
    Fast,
    /// For trees that are built while a level loads: clustering, then more reinsertion.
    Balanced,
    /// For trees that are built once: spatial splits, then reinsertion. Takes several times as
    /// long, and more memory where triangles are long and thin.
    Best,
}

impl Quality {
    /// The number of qualities.
    pub(crate) const COUNT: usize = Self::Best as usize + 1;
}

/// How a tree is built.
///
/// ```
/// use kinetree::{BuildOptions, Quality, Threads};
///
/// let options = BuildOptions::new().quality(Quality::Best).threads(Threads::one());
/// assert_eq!(options.quality, Quality::Best);
/// ```
#[derive(Debug, Clone)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct BuildOptions {
    /// How much build time to trade for traversal speed.
    pub quality: Quality,
    /// Where the build runs. The tree does not depend on it.
    /// Not serialized.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub threads: Threads,
    /// The cost of visiting a node, relative to one primitive test. A larger cost gives larger
    /// leaves. Private, because the collapse into eight-way nodes chooses the final leaves.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) node_cost: f32,
    /// The largest number of primitives in a leaf, clamped to 1 to [`Link::MAX_COUNT`].
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) max_leaf: u32,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { quality: Quality::default(), node_cost: 1.0, max_leaf: 2, threads: Threads::default() }
    }
}

impl BuildOptions {
    /// The default quality, on all threads.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// How much build time to trade for traversal speed.
    #[must_use]
    pub fn quality(self, quality: Quality) -> Self {
        Self { quality, ..self }
    }

    /// Where the build runs. The tree does not depend on it.
    #[must_use]
    pub fn threads(self, threads: Threads) -> Self {
        Self { threads, ..self }
    }

    /// For trees whose primitives are costly, such as instances: one in each leaf.
    pub(crate) fn single() -> Self {
        Self { max_leaf: 1, ..Self::default() }
    }

    pub(crate) fn leaf_limit(&self) -> usize {
        self.max_leaf.clamp(1, Link::MAX_COUNT) as usize
    }
}
