//! A broken promise of a tree: one type for every kind of tree.

use std::fmt;

use thiserror::Error;

/// The first promise of a tree that is broken, and where. The documentation of the tree's type
/// lists the promises by number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("promise {promise}: {what}, at {location}")]
pub struct Violation {
    /// The number of the promise.
    pub promise: u32,
    /// What was found.
    pub what: &'static str,
    /// Where it was found.
    pub location: Location,
}

/// A location in a tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Location {
    /// A node, by index.
    Node(usize),
    /// One of the eight boxes of a wide node.
    Lane {
        /// The index of the node.
        node: usize,
        /// The index of the box in the node.
        lane: usize,
    },
    /// An entry of the list that leaves link to.
    Item(usize),
    /// A primitive, by the caller's index.
    Primitive(u32),
}

impl Violation {
    pub(crate) fn new(promise: u32, what: &'static str, location: Location) -> Self {
        Self { promise, what, location }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Node(node) => write!(f, "node {node}"),
            Self::Lane { node, lane } => write!(f, "node {node}, lane {lane}"),
            Self::Item(item) => write!(f, "item {item}"),
            Self::Primitive(primitive) => write!(f, "primitive {primitive}"),
        }
    }
}
