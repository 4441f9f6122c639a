//! The hierarchy: nodes within nodes, and the instances in them.

use super::members::Members;
use super::slots::Slots;
use crate::geometry::Affine;
use crate::geometry::inverse::Inverse;
use crate::handle::Handle;

/// What nodes and instances have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placement {
    /// Parent from node, or node from instance.
    pub(crate) transform: Affine,
    pub(crate) mask: u32,
    /// `None` means that of the nearest node above that has one.
    pub(crate) user_id: Option<u32>,
}

impl Placement {
    pub(crate) fn at(transform: Affine) -> Self {
        Self { transform, mask: u32::MAX, user_id: None }
    }

    /// The placement of something that is placed in this.
    pub(crate) fn then(&self, inner: &Self) -> Self {
        Self {
            transform: self.transform * inner.transform,
            mask: self.mask & inner.mask,
            user_id: inner.user_id.or(self.user_id),
        }
    }
}

#[derive(Debug)]
pub(crate) struct Node {
    pub(crate) placement: Placement,
    /// `None` for a root.
    pub(crate) parent: Option<u32>,
    /// Index among the children of the parent.
    pub(crate) index: u32,
    pub(crate) children: Members,
    pub(crate) instances: Members,
}

impl Node {
    pub(crate) fn root() -> Self {
        Self {
            placement: Placement::at(Affine::IDENTITY),
            parent: None,
            index: 0,
            children: Members::default(),
            instances: Members::default(),
        }
    }
}

#[derive(Debug)]
pub(crate) struct Instance {
    pub(crate) placement: Placement,
    pub(crate) node: u32,
    /// Index among the instances of the node.
    pub(crate) index: u32,
    pub(crate) mesh: Handle,
    pub(crate) opaque: bool,
    /// The placement that the inverse belongs to.
    pub(crate) inverted: Option<(Affine, Option<Inverse>)>,
}

/// The placement of every node in the world, by slot. Parents come before children, without
/// recursion, since chains may be long.
pub(crate) fn resolve(nodes: &Slots<Node>) -> Vec<Placement> {
    let mut resolved = vec![Placement::at(Affine::IDENTITY); nodes.end()];
    let mut open: Vec<u32> = nodes.iter().filter(|(_, node)| node.parent.is_none()).map(|(slot, _)| slot).collect();
    while let Some(slot) = open.pop() {
        let node = nodes.at(slot).expect("a child is in the list of its parent as long as it exists");
        resolved[slot as usize] = match node.parent {
            Some(parent) => resolved[parent as usize].then(&node.placement),
            None => node.placement,
        };
        open.extend(node.children.slots());
    }
    resolved
}
