//! What a caller can choose about a build.

use crate::threads::Threads;
use crate::tree::Link;

/// How much build time to trade for traversal speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Quality {
    /// For what is rebuilt every frame: clustering along a Morton curve, with leaves of a size of its own choice.
    Fastest,
    /// For what is built while the game runs: clustering, then reinsertion of the worst.
    #[default]
    Fast,
    /// For what is built while a level loads: clustering, then more reinsertion.
    Balanced,
    /// For what is built once and traced for long: spatial splits, then reinsertion. Takes several times as long, and more memory where triangles are long and thin.
    Best,
}

impl Quality {
    /// How many there are.
    pub(crate) const COUNT: usize = Self::Best as usize + 1;
}

/// How a tree is grown. Each option acts on every tree that is built with it.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct BuildOptions {
    /// How much build time to trade for traversal speed.
    pub quality: Quality,
    /// Where the build runs. The tree does not depend on it.
    pub threads: Threads,
    /// Cost of visiting a node, in units of one primitive test. A larger one gives larger leaves.
    /// Not for callers: the collapse into eight-way nodes decides anew what is a leaf.
    pub(crate) node_cost: f32,
    /// The most primitives in a leaf; at least 1, at most [`Link::MAX_COUNT`].
    pub(crate) max_leaf: u32,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { quality: Quality::default(), node_cost: 1.0, max_leaf: 2, threads: Threads::default() }
    }
}

impl BuildOptions {
    /// For trees whose primitives are dear, such as instances: one in each leaf.
    pub(crate) fn single() -> Self {
        Self { max_leaf: 1, ..Self::default() }
    }

    pub(crate) fn leaf_limit(&self) -> usize {
        self.max_leaf.clamp(1, Link::MAX_COUNT) as usize
    }
}
