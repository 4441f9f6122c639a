//! Which instances of a frame are below which node: what queries need to leave out a whole subtree.
//!
//! Instances are numbered in depth-first order of their nodes, so that those below a node are an
//! interval, and belonging to it is one comparison.

use crate::handle::{Handle, Placed};

/// The instances of a scene, numbered in depth-first order, and the interval of each node.
#[derive(Debug, Default)]
pub(crate) struct Hierarchy {
    /// By slot. Slots without a node have an empty interval.
    nodes: Vec<Entry>,
    /// By slot. Slots without an instance have an empty interval.
    instances: Vec<Entry>,
    scene: u32,
}

#[derive(Debug, Clone, Copy, Default)]
struct Entry {
    generation: u32,
    interval: Interval,
}

/// Instances that follow each other in depth-first order; none, unless told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Interval {
    first: u32,
    count: u32,
}

impl Interval {
    #[inline(always)]
    pub(crate) fn is_empty(self) -> bool {
        self.count == 0
    }

    #[inline(always)]
    pub(crate) fn contains(self, number: u32) -> bool {
        number.wrapping_sub(self.first) < self.count
    }
}

impl Hierarchy {
    /// `nodes` in depth-first order, each with the slot of its parent; `instances` in any order,
    /// each with the slot of its node. All are of one scene.
    pub(crate) fn new(nodes: &[(Handle, Option<u32>)], instances: &[(Handle, u32)]) -> Self {
        let slots = |handles: &mut dyn Iterator<Item = &Handle>| handles.map(|handle| handle.slot as usize + 1).max();
        let node_slots = slots(&mut nodes.iter().map(|(handle, _)| handle)).unwrap_or(0);
        let instance_slots = slots(&mut instances.iter().map(|(handle, _)| handle)).unwrap_or(0);
        let mut all = Self {
            nodes: vec![Entry::default(); node_slots],
            instances: vec![Entry::default(); instance_slots],
            scene: nodes.first().map_or(0, |(handle, _)| handle.scene),
        };
        for &(_, node) in instances {
            all.nodes[node as usize].interval.count += 1;
        }
        let mut next = vec![0; node_slots];
        let mut first = 0;
        for (handle, _) in nodes {
            let Entry { generation, interval } = &mut all.nodes[handle.slot as usize];
            (*generation, interval.first, next[handle.slot as usize]) = (handle.generation, first, first);
            first += interval.count;
        }
        for (handle, node) in instances {
            let number = &mut next[*node as usize];
            let interval = Interval { first: *number, count: 1 };
            all.instances[handle.slot as usize] = Entry { generation: handle.generation, interval };
            *number += 1;
        }
        // What is below a node comes right after it, so intervals only grow at their ends. Children
        // come before parents.
        for &(handle, parent) in nodes.iter().rev() {
            let count = all.nodes[handle.slot as usize].interval.count;
            if let Some(parent) = parent {
                all.nodes[parent as usize].interval.count += count;
            }
        }
        all
    }

    /// The number of the instance in a slot.
    pub(crate) fn number_of(&self, slot: u32) -> u32 {
        self.instances[slot as usize].interval.first
    }

    /// The instance, or the instances below the node; none when the handle is stale or of another
    /// scene.
    #[inline]
    pub(crate) fn interval_of(&self, what: Placed) -> Interval {
        let (entries, handle) = match what {
            Placed::Node(node) => (&self.nodes, node.0),
            Placed::Instance(instance) => (&self.instances, instance.0),
        };
        match entries.get(handle.slot as usize) {
            Some(entry) if (entry.generation, self.scene) == (handle.generation, handle.scene) => entry.interval,
            _ => Interval::default(),
        }
    }

    /// Bytes held.
    pub(crate) fn heap_bytes(&self) -> usize {
        (self.nodes.capacity() + self.instances.capacity()) * size_of::<Entry>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::handle::{InstanceId, NodeId};

    fn handle(slot: u32, generation: u32) -> Handle {
        Handle { slot, generation, scene: 7 }
    }

    /// A root in slot 2 with two children, of which the one in slot 0 has a child in slot 4.
    fn hierarchy() -> Hierarchy {
        let nodes = [(handle(2, 0), None), (handle(0, 5), Some(2)), (handle(4, 0), Some(0)), (handle(1, 0), Some(2))];
        let instances = [(handle(0, 0), 4), (handle(2, 3), 1), (handle(3, 0), 0), (handle(5, 0), 4)];
        Hierarchy::new(&nodes, &instances)
    }

    #[test]
    fn what_is_below_a_node_is_an_interval() {
        let all = hierarchy();
        let below = |slot, generation| {
            let interval = all.interval_of(NodeId(handle(slot, generation)).into());
            [0, 2, 3, 5].into_iter().filter(|&slot| interval.contains(all.number_of(slot))).collect::<Vec<_>>()
        };
        assert_eq!(below(2, 0), [0, 2, 3, 5]);
        assert_eq!(below(0, 5), [0, 3, 5]);
        assert_eq!(below(4, 0), [0, 5]);
        assert_eq!(below(1, 0), [2]);
        let mut numbers = [0, 2, 3, 5].map(|slot| all.number_of(slot));
        numbers.sort_unstable();
        assert_eq!(numbers, [0, 1, 2, 3]);
    }

    #[test]
    fn what_is_not_there_has_nothing_below_it() {
        let all = hierarchy();
        let foreign = |slot| Handle { scene: 8, ..handle(slot, 0) };
        for node in [handle(0, 4), handle(3, 0), handle(99, 0), foreign(2)] {
            assert!(all.interval_of(NodeId(node).into()).is_empty(), "{node:?}");
        }
        for instance in [handle(2, 2), handle(1, 0), handle(99, 0), foreign(0)] {
            assert!(all.interval_of(InstanceId(instance).into()).is_empty(), "{instance:?}");
        }
        assert!(Hierarchy::new(&[], &[]).interval_of(NodeId(handle(0, 0)).into()).is_empty());
    }
}
