//! The children or the instances of a node. Every member stores its index in the list, so that any
//! of them is removed in one step.

/// Slots of nodes or instances, in no particular order.
#[derive(Debug, Default)]
pub(crate) struct Members {
    slots: Vec<u32>,
    /// How many members were looked at or moved, for tests.
    #[cfg(test)]
    pub(crate) steps: u64,
}

impl Members {
    /// Adds a member, and returns the index that it has to store.
    pub(crate) fn add(&mut self, slot: u32) -> u32 {
        self.count_step();
        self.slots.push(slot);
        self.slots.len() as u32 - 1
    }

    /// Removes the member at an index. The last one moves there: it is returned, and has to store
    /// its new index.
    pub(crate) fn remove(&mut self, index: u32) -> Option<u32> {
        self.count_step();
        self.slots.swap_remove(index as usize);
        self.slots.get(index as usize).copied()
    }

    pub(crate) fn slots(&self) -> &[u32] {
        &self.slots
    }

    fn count_step(&mut self) {
        #[cfg(test)]
        {
            self.steps += 1;
        }
    }
}
