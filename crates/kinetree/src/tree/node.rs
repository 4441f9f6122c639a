//! One node.

use super::Link;
use crate::geometry::Aabb;

/// A box, and where it leads.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(32))]
pub struct Node {
    /// Contains everything below.
    pub bounds: Aabb,
    /// To two children, or to primitives.
    pub link: Link,
}

const _: () = assert!(size_of::<Node>() == 32);
