//! Buffers that take turns: one is current, others may be held by snapshots, the rest is free for the next commit.
//!
//! A commit writes only into a buffer that nobody else holds. Buffers stay in the ring until a commit frees them, so no thread that traces
//! ever frees memory while the scene lives.

use std::sync::Arc;

/// How many free buffers are kept for later; more were only needed while somebody held many snapshots.
const SPARES: usize = 2;

#[derive(Debug)]
pub(crate) struct Ring<T> {
    current: Option<Arc<T>>,
    others: Vec<Arc<T>>,
}

impl<T> Default for Ring<T> {
    fn default() -> Self {
        Self { current: None, others: Vec::new() }
    }
}

impl<T: Default> Ring<T> {
    /// What was published last.
    pub(crate) fn current(&self) -> Option<&Arc<T>> {
        self.current.as_ref()
    }

    /// A buffer that nobody else holds, with whatever it held; a new one if all are held, and then `true`.
    pub(crate) fn claim(&mut self) -> (T, bool) {
        for i in 0..self.others.len() {
            if Arc::get_mut(&mut self.others[i]).is_some() {
                let buffer = self.others.swap_remove(i);
                if let Some(buffer) = Arc::into_inner(buffer) {
                    return (buffer, false);
                }
            }
        }
        (T::default(), true)
    }

    /// Makes a buffer current. The one before joins those that wait for their snapshots to be dropped.
    pub(crate) fn publish(&mut self, buffer: T) -> &Arc<T> {
        self.others.extend(self.current.take());
        let mut spares = 0;
        self.others.retain_mut(|other| {
            let free = Arc::get_mut(other).is_some();
            spares += usize::from(free);
            !free || spares <= SPARES
        });
        self.current.insert(Arc::new(buffer))
    }

    /// Visits the buffers that nobody else holds.
    pub(crate) fn for_each_free(&mut self, visit: impl FnMut(&mut T)) {
        self.others.iter_mut().filter_map(Arc::get_mut).for_each(visit);
    }

    /// All buffers of the ring, the current one too.
    pub(crate) fn buffers(&self) -> impl Iterator<Item = &T> {
        self.others.iter().chain(&self.current).map(|buffer| &**buffer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_somebody_holds_is_never_claimed() {
        let mut ring = Ring::<Vec<u32>>::default();
        let (mut buffer, new) = ring.claim();
        assert!(new);
        buffer.push(1);
        let held = ring.publish(buffer).clone();
        ring.publish(vec![2]);
        let (_, new) = ring.claim();
        assert!(new, "the only other buffer is held");
        drop(held);
        ring.publish(vec![3]);
        let (buffer, new) = ring.claim();
        assert!(!new && buffer != [3]);
    }

    #[test]
    fn a_ring_shrinks_when_snapshots_are_dropped() {
        let mut ring = Ring::<Vec<u32>>::default();
        let held: Vec<_> = (0..20).map(|i| ring.publish(vec![i]).clone()).collect();
        assert_eq!(ring.buffers().count(), 20);
        drop(held);
        ring.publish(vec![99]);
        assert_eq!(ring.buffers().count(), SPARES + 1);
    }
}
