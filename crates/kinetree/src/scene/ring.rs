//! Buffers of a mesh that take turns: one is current, others belong to frames that are held, a few
//! are free for the next commit.
//!
//! A commit writes only into a buffer without other references. The buffers of a frame return when
//! a commit releases that frame, so no buffer is searched for, and no thread that traces ever frees
//! one while the scene lives.

use std::sync::Arc;

/// How many free buffers are kept; more are needed only while many snapshots are held.
const SPARES: usize = 2;

/// A buffer of a ring.
pub(crate) trait Buffer: Default {
    /// Bytes held. The same while it is published.
    fn heap_bytes(&self) -> usize;
}

/// What was published last.
#[derive(Debug)]
enum Current<T> {
    /// Nothing yet.
    None,
    /// A buffer of this ring.
    Own(Arc<T>),
    /// A buffer that several rings share, and none of them writes.
    Shared(Arc<T>),
}

#[derive(Debug)]
pub(crate) struct Ring<T> {
    current: Current<T>,
    free: Vec<T>,
    memory: usize,
}

impl<T> Default for Ring<T> {
    fn default() -> Self {
        Self { current: Current::None, free: Vec::new(), memory: 0 }
    }
}

impl<T: Buffer> Ring<T> {
    /// What was published last.
    pub(crate) fn current(&self) -> Option<&Arc<T>> {
        match &self.current {
            Current::None => None,
            Current::Own(buffer) | Current::Shared(buffer) => Some(buffer),
        }
    }

    /// What was published last, if it is shared.
    pub(crate) fn shared(&self) -> Option<&Arc<T>> {
        if let Current::Shared(buffer) = &self.current { Some(buffer) } else { None }
    }

    /// A buffer without other references, with its old contents; or a new one if all are held, and
    /// `true`.
    pub(crate) fn claim(&mut self) -> (T, bool) {
        match self.free.pop() {
            Some(buffer) => {
                self.memory -= buffer.heap_bytes();
                (buffer, false)
            }
            None => (T::default(), true),
        }
    }

    /// Takes back a buffer that was claimed and is not needed after all.
    pub(crate) fn give_back(&mut self, buffer: T) {
        self.memory += buffer.heap_bytes();
        self.release(Arc::new(buffer));
    }

    /// Makes a buffer current.
    pub(crate) fn publish(&mut self, buffer: T) {
        self.memory += buffer.heap_bytes();
        self.replace_current(Current::Own(Arc::new(buffer)));
    }

    /// Makes a buffer current that is not of this ring.
    pub(crate) fn share(&mut self, buffer: Arc<T>) {
        self.replace_current(Current::Shared(buffer));
    }

    fn replace_current(&mut self, new: Current<T>) {
        if let Current::Own(last) = std::mem::replace(&mut self.current, new) {
            self.release(last);
        }
    }

    /// Takes back a reference to a buffer of this ring. With the last one, the buffer is free.
    pub(crate) fn release(&mut self, buffer: Arc<T>) {
        let Some(buffer) = Arc::into_inner(buffer) else { return };
        if self.free.len() < SPARES {
            self.free.push(buffer);
        } else {
            self.memory -= buffer.heap_bytes();
        }
    }

    /// Bytes held by all buffers, those that wait for their snapshots included.
    pub(crate) fn heap_bytes(&self) -> usize {
        self.memory
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Buffer for Vec<u32> {
        fn heap_bytes(&self) -> usize {
            self.capacity()
        }
    }

    fn publish(ring: &mut Ring<Vec<u32>>, buffer: Vec<u32>) -> Arc<Vec<u32>> {
        ring.publish(buffer);
        ring.current().unwrap().clone()
    }

    #[test]
    fn what_is_shared_is_never_claimed_or_counted() {
        let mut ring = Ring::<Vec<u32>>::default();
        ring.publish(vec![1; 10]);
        ring.share(Arc::new(vec![2; 10]));
        assert_eq!(ring.shared().map(|buffer| buffer[0]), Some(2));
        assert_eq!((ring.claim().0[0], ring.heap_bytes()), (1, 0));
        ring.publish(vec![3; 10]);
        assert!(ring.shared().is_none() && ring.claim().1);
    }

    #[test]
    fn what_is_held_is_never_claimed() {
        let mut ring = Ring::<Vec<u32>>::default();
        let held = publish(&mut ring, vec![1]);
        let (of_one_frame, of_another) = (held.clone(), held);
        ring.publish(vec![2]);
        assert!(ring.claim().1, "the only other buffer is held");
        ring.release(of_one_frame);
        assert!(ring.claim().1, "another frame holds it still");
        ring.release(of_another);
        assert_eq!(ring.claim(), (vec![1], false));
    }

    #[test]
    fn a_ring_shrinks_when_frames_are_let_go() {
        let mut ring = Ring::<Vec<u32>>::default();
        let held: Vec<_> = (0..20).map(|i| publish(&mut ring, vec![i; 10])).collect();
        assert_eq!(ring.heap_bytes(), 200);
        for buffer in held {
            ring.release(buffer);
        }
        assert_eq!(ring.heap_bytes(), 10 * (SPARES + 1));
        ring.claim();
        assert_eq!(ring.heap_bytes(), 10 * SPARES);
    }
}
