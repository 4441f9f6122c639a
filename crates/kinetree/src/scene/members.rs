//! What hangs on a node. Every member knows its place in the list, so that any of them is taken out
//! in one step.

/// Slots of nodes or instances, in no particular order.
#[derive(Debug, Default)]
pub(crate) struct Members {
    slots: Vec<u32>,
    /// How many members were looked at or moved, for tests.
    #[cfg(test)]
    pub(crate) steps: u64,
}

impl Members {
    /// Adds a member, and gives the place that it has to remember.
    pub(crate) fn add(&mut self, slot: u32) -> u32 {
        self.count_step();
        self.slots.push(slot);
        self.slots.len() as u32 - 1
    }

    /// Takes out the member of a place. The last one moves there: it is returned, and has to
    /// remember its new place.
    pub(crate) fn remove(&mut self, place: u32) -> Option<u32> {
        self.count_step();
        self.slots.swap_remove(place as usize);
        self.slots.get(place as usize).copied()
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
