//! Animations: which property of which node follows which keys.

use serde::Deserialize;

use super::geometry::Accessor;
use super::scene::Node;
use super::{Index, Name};

/// Channels that are played together.
#[derive(Deserialize)]
pub(crate) struct Animation {
    pub(crate) name: Option<Name>,
    pub(crate) channels: Vec<Channel>,
    pub(crate) samplers: Vec<Keys>,
}

/// A property and its keys.
#[derive(Deserialize)]
pub(crate) struct Channel {
    /// Among the samplers of the animation.
    pub(crate) sampler: u32,
    pub(crate) target: Target,
}

/// What a channel moves.
#[derive(Deserialize)]
pub(crate) struct Target {
    /// A channel without one is meant for an extension.
    pub(crate) node: Option<Index<Node>>,
    pub(crate) path: Path,
}

/// A property of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Path {
    Translation,
    Rotation,
    Scale,
    Weights,
    #[serde(other)]
    Unknown,
}

/// Values at times.
#[derive(Deserialize)]
pub(crate) struct Keys {
    pub(crate) input: Index<Accessor>,
    pub(crate) output: Index<Accessor>,
    #[serde(default)]
    pub(crate) interpolation: Interpolation,
}

/// How to get from one key to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) enum Interpolation {
    #[default]
    Linear,
    Step,
    CubicSpline,
    #[serde(other)]
    Unknown,
}
