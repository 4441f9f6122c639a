//! The hierarchy that frames hold, made anew only when nodes or instances were added or removed.

use std::sync::Arc;

use super::graph::{Instance, Node};
use super::slots::Slots;
use crate::handle::Handle;
use crate::traverse::Hierarchy;

/// The hierarchy of the last commit.
#[derive(Debug, Default)]
pub(crate) struct HierarchyCache {
    hierarchy: Arc<Hierarchy>,
    /// How many additions and removals of nodes, and of instances, it takes into account.
    changes: Option<[u64; 2]>,
}

impl HierarchyCache {
    /// The hierarchy as it is now.
    pub(crate) fn updated(&mut self, nodes: &Slots<Node>, instances: &Slots<Instance>) -> &Arc<Hierarchy> {
        let changes = Some([nodes.changes(), instances.changes()]);
        if self.changes != changes {
            let instances: Vec<_> =
                instances.iter().map(|(slot, instance)| (instances.handle_of(slot), instance.node)).collect();
            *self = Self { hierarchy: Arc::new(Hierarchy::new(&depth_first(nodes), &instances)), changes };
        }
        &self.hierarchy
    }
}

/// All nodes, each with the slot of its parent and right before what is below it. Without
/// recursion: chains may be long.
fn depth_first(nodes: &Slots<Node>) -> Vec<(Handle, Option<u32>)> {
    let mut order = Vec::new();
    let mut open: Vec<u32> = nodes.iter().filter(|(_, node)| node.parent.is_none()).map(|(slot, _)| slot).collect();
    while let Some(slot) = open.pop() {
        let node = nodes.at(slot).expect("a child is in the list of its parent as long as it exists");
        order.push((nodes.handle_of(slot), node.parent));
        open.extend(node.children.slots());
    }
    order
}
