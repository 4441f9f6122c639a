//! Values that are found by handle (a generational arena).

use std::sync::atomic::{AtomicU32, Ordering};

use super::EditError;
use crate::handle::Handle;

/// A number that no other scene of the process has, until 2^32 - 1 scenes have been made. Never 0.
pub(crate) fn fresh_scene_number() -> u32 {
    static NEXT: AtomicU32 = AtomicU32::new(1);
    loop {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        if number != 0 {
            return number;
        }
    }
}

/// Values in numbered slots; a slot that is used again has another generation.
#[derive(Debug)]
pub(crate) struct Slots<T> {
    scene: u32,
    slots: Vec<Slot<T>>,
    free: Vec<u32>,
    changes: u64,
}

#[derive(Debug)]
struct Slot<T> {
    generation: u32,
    value: Option<T>,
}

impl<T> Slots<T> {
    pub(crate) fn new(scene: u32) -> Self {
        Self { scene, slots: Vec::new(), free: Vec::new(), changes: 0 }
    }

    pub(crate) fn insert(&mut self, value: T) -> Result<Handle, EditError> {
        let slot = match self.free.pop() {
            Some(slot) => slot,
            None => {
                // Walks number instances with 27 bits.
                let slot = u32::try_from(self.slots.len()).ok().filter(|&slot| slot < 1 << 27);
                self.slots.push(Slot { generation: 0, value: None });
                slot.ok_or(EditError::SceneFull)?
            }
        };
        let place = &mut self.slots[slot as usize];
        place.value = Some(value);
        self.changes += 1;
        Ok(Handle { slot, generation: place.generation, scene: self.scene })
    }

    /// # Errors
    /// The handle is stale, or of another scene.
    pub(crate) fn get(&self, handle: Handle) -> Result<&T, EditError> {
        self.check(handle)?;
        self.at(handle.slot).ok_or(EditError::StaleHandle)
    }

    /// # Errors
    /// The handle is stale, or of another scene.
    pub(crate) fn get_mut(&mut self, handle: Handle) -> Result<&mut T, EditError> {
        self.check(handle)?;
        self.at_mut(handle.slot).ok_or(EditError::StaleHandle)
    }

    /// # Errors
    /// The handle is stale, or of another scene.
    pub(crate) fn remove(&mut self, handle: Handle) -> Result<T, EditError> {
        self.check(handle)?;
        self.remove_at(handle.slot).ok_or(EditError::StaleHandle)
    }

    pub(crate) fn remove_at(&mut self, slot: u32) -> Option<T> {
        let place = self.slots.get_mut(slot as usize)?;
        let value = place.value.take()?;
        self.changes += 1;
        // A slot whose generations are used up is never used again.
        if let Some(next) = place.generation.checked_add(1) {
            place.generation = next;
            self.free.push(slot);
        }
        Some(value)
    }

    /// How many values have been added and removed in all.
    pub(crate) fn changes(&self) -> u64 {
        self.changes
    }

    pub(crate) fn at(&self, slot: u32) -> Option<&T> {
        self.slots.get(slot as usize)?.value.as_ref()
    }

    pub(crate) fn at_mut(&mut self, slot: u32) -> Option<&mut T> {
        self.slots.get_mut(slot as usize)?.value.as_mut()
    }

    pub(crate) fn handle_of(&self, slot: u32) -> Handle {
        Handle { slot, generation: self.slots[slot as usize].generation, scene: self.scene }
    }

    /// The handles of all values, by slot number.
    pub(crate) fn handles(&self) -> impl Iterator<Item = Handle> {
        self.iter().map(|(slot, _)| self.handle_of(slot))
    }

    /// Slot numbers and values, by number.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, &T)> {
        self.slots.iter().zip(0..).filter_map(|(slot, number)| Some((number, slot.value.as_ref()?)))
    }

    /// Slot numbers and values, by number.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = (u32, &mut T)> {
        self.slots.iter_mut().zip(0..).filter_map(|(slot, number)| Some((number, slot.value.as_mut()?)))
    }

    /// One more than the largest slot number.
    pub(crate) fn end(&self) -> usize {
        self.slots.len()
    }

    fn check(&self, handle: Handle) -> Result<(), EditError> {
        if handle.scene != self.scene {
            return Err(EditError::OtherScene);
        }
        let slot = self.slots.get(handle.slot as usize).ok_or(EditError::StaleHandle)?;
        if slot.generation == handle.generation { Ok(()) } else { Err(EditError::StaleHandle) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_old_handle_is_recognised_as_old() {
        let mut slots = Slots::new(1);
        let first = slots.insert('a').unwrap();
        assert_eq!(slots.remove(first), Ok('a'));
        let second = slots.insert('b').unwrap();
        assert_eq!(second.slot, first.slot);
        assert_eq!(slots.get(first), Err(EditError::StaleHandle));
        assert_eq!(slots.get(second), Ok(&'b'));
        assert_eq!(Slots::<char>::new(2).get(second), Err(EditError::OtherScene));
    }
}
