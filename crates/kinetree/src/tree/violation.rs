//! What is wrong with a tree: one type for every kind of tree.

use std::fmt;

use thiserror::Error;

/// The first promise of a tree that does not hold, and where. The promises are numbered on the type
/// of the tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("promise {promise}: {what}, at {location}")]
pub struct Violation {
    /// Its number.
    pub promise: u32,
    /// What was found.
    pub what: &'static str,
    /// Where.
    pub location: Location,
}

/// Where in a tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Location {
    /// A node, by its number.
    Node(usize),
    /// One of the boxes of a node.
    Lane {
        /// The number of the node.
        node: usize,
        /// The number of the box in it.
        lane: usize,
    },
    /// An entry of the list that leaves lead to.
    Item(usize),
    /// A primitive, by the caller's number.
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
