//! A node of the binary tree.

use super::Link;
use crate::geometry::Aabb;

/// A box with a link to two children or to primitives.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(32))]
pub struct Node {
    /// Contains everything below.
    pub bounds: Aabb,
    /// The two children, or the primitives of a leaf.
    pub link: Link,
}

const _: () = assert!(size_of::<Node>() == 32);
