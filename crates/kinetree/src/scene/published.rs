//! Published frames: each is held by snapshots, on any thread, and returns to its scene when the
//! last of them is dropped.
//!
//! The scene keeps every frame until a commit has seen it return, so a thread that drops a snapshot
//! frees no memory while the scene lives. Nor does a commit search for returned frames: dropping
//! the last snapshot pushes the frame's number onto a list, which the next commit takes as a whole.
//! The list is linked through the frames themselves, so that dropping a snapshot allocates nothing
//! and never waits (Treiber 1986, "Systems Programming: Coping with Parallelism"). Since the list
//! is only ever taken as a whole, the ABA problem cannot occur.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

/// How many free frames are kept; more are needed only while many snapshots are held.
const SPARES: usize = 2;

/// The end of the list.
const END: u32 = u32::MAX;

/// A published value.
#[derive(Debug)]
struct Slot<T> {
    value: T,
    number: u32,
    /// How many [`Published`] there are.
    holders: AtomicUsize,
    /// The next one in the list of returned values.
    next: AtomicU32,
    /// The head of that list.
    returned: Arc<AtomicU32>,
}

/// A reference to a published value. When the last clone is dropped, the value returns to its
/// publisher.
#[derive(Debug)]
pub(crate) struct Published<T>(Arc<Slot<T>>);

impl<T> Published<T> {
    /// A value without a publisher.
    pub(crate) fn alone(value: T) -> Self {
        Self::numbered(value, 0, Arc::new(AtomicU32::new(END)))
    }

    fn numbered(value: T, number: u32, returned: Arc<AtomicU32>) -> Self {
        let (holders, next) = (AtomicUsize::new(1), AtomicU32::new(END));
        Self(Arc::new(Slot { value, number, holders, next, returned }))
    }
}

impl<T> Deref for Published<T> {
    type Target = T;

    #[inline(always)]
    fn deref(&self) -> &T {
        &self.0.value
    }
}

impl<T> Clone for Published<T> {
    fn clone(&self) -> Self {
        self.0.holders.fetch_add(1, Ordering::Relaxed);
        Self(self.0.clone())
    }
}

impl<T> Drop for Published<T> {
    fn drop(&mut self) {
        let Slot { number, holders, next, returned, .. } = &*self.0;
        if holders.fetch_sub(1, Ordering::AcqRel) > 1 {
            return;
        }
        let mut first = returned.load(Ordering::Relaxed);
        loop {
            next.store(first, Ordering::Relaxed);
            match returned.compare_exchange_weak(first, *number, Ordering::Release, Ordering::Relaxed) {
                Ok(_) => return,
                Err(other) => first = other,
            }
        }
    }
}

/// Publishes values, and takes them back.
#[derive(Debug)]
pub(crate) struct Publisher<T> {
    /// By number: values that are current, held, or returning.
    slots: Vec<Option<Arc<Slot<T>>>>,
    unused_numbers: Vec<u32>,
    current: Option<u32>,
    returned: Arc<AtomicU32>,
    /// Taken from the list, but still current, or dropped so recently that the last holder's
    /// `Arc` is still there.
    returning: Vec<u32>,
    free: Vec<T>,
    /// How many slots were looked at, for tests.
    #[cfg(test)]
    steps: u64,
}

impl<T> Default for Publisher<T> {
    fn default() -> Self {
        Self {
            slots: Vec::new(),
            unused_numbers: Vec::new(),
            current: None,
            returned: Arc::new(AtomicU32::new(END)),
            returning: Vec::new(),
            free: Vec::new(),
            #[cfg(test)]
            steps: 0,
        }
    }
}

impl<T: Default> Publisher<T> {
    /// What was published last.
    pub(crate) fn current(&self) -> Option<&T> {
        let slot = self.slots.get(self.current? as usize)?;
        slot.as_ref().map(|slot| &slot.value)
    }

    /// Takes back the values that have returned, and visits them.
    pub(crate) fn collect(&mut self, mut visit: impl FnMut(&mut T)) {
        let mut number = self.returned.swap(END, Ordering::Acquire);
        while let Some(slot) = self.slots.get(number as usize).and_then(Option::as_ref) {
            self.returning.push(number);
            number = slot.next.load(Ordering::Relaxed);
        }
        for number in std::mem::take(&mut self.returning) {
            self.count_step();
            let place = &mut self.slots[number as usize];
            let slot = if self.current == Some(number) { None } else { place.take() };
            match slot.map(Arc::try_unwrap) {
                Some(Ok(Slot { mut value, .. })) => {
                    self.unused_numbers.push(number);
                    visit(&mut value);
                    if self.free.len() < SPARES {
                        self.free.push(value);
                    }
                }
                held => {
                    if let Some(Err(slot)) = held {
                        *place = Some(slot);
                    }
                    self.returning.push(number);
                }
            }
        }
    }

    /// A value without holders, with its old contents; or a new one if all are held, and `true`.
    pub(crate) fn claim(&mut self) -> (T, bool) {
        self.free.pop().map_or_else(|| (T::default(), true), |value| (value, false))
    }

    /// Makes a value current, and returns the first reference to it.
    pub(crate) fn publish(&mut self, value: T) -> Published<T> {
        self.count_step();
        let number = self.unused_numbers.pop().unwrap_or_else(|| {
            self.slots.push(None);
            u32::try_from(self.slots.len() - 1).expect("four billion snapshots are not held at once")
        });
        let published = Published::numbered(value, number, self.returned.clone());
        self.slots[number as usize] = Some(published.0.clone());
        self.current = Some(number);
        published
    }

    fn count_step(&mut self) {
        #[cfg(test)]
        {
            self.steps += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_use<T>(publisher: &Publisher<T>) -> usize {
        publisher.slots.iter().flatten().count()
    }

    #[test]
    fn what_is_held_is_never_claimed() {
        let mut publisher = Publisher::<Vec<u32>>::default();
        let (mut value, new) = publisher.claim();
        assert!(new);
        value.push(1);
        let held = publisher.publish(value);
        let clone = held.clone();
        drop(publisher.publish(vec![2]));
        drop(held);
        publisher.collect(|_| ());
        assert!(publisher.claim().1, "one is held by a clone, the other is current");
        assert_eq!(publisher.current(), Some(&vec![2]));
        drop(clone);
        let mut visited = 0;
        publisher.collect(|value| {
            assert_eq!(*value, [1]);
            visited += 1;
        });
        assert_eq!((publisher.claim(), visited), ((vec![1], false), 1));
    }

    #[test]
    fn what_was_current_comes_back_once_something_else_is() {
        let mut publisher = Publisher::<Vec<u32>>::default();
        drop(publisher.publish(vec![1]));
        publisher.collect(|_| panic!("it is current"));
        publisher.collect(|_| panic!("it is current"));
        drop(publisher.publish(vec![2]));
        publisher.collect(|_| ());
        assert_eq!(publisher.claim(), (vec![1], false));
        assert_eq!(in_use(&publisher), 1);
    }

    #[test]
    fn a_publisher_shrinks_when_snapshots_are_dropped() {
        let mut publisher = Publisher::<Vec<u32>>::default();
        let held: Vec<_> = (0..20).map(|i| publisher.publish(vec![i])).collect();
        assert_eq!(in_use(&publisher), 20);
        drop(held);
        publisher.collect(|_| ());
        assert_eq!((in_use(&publisher), publisher.free.len()), (1, SPARES));
    }

    #[test]
    fn held_snapshots_are_not_looked_at() {
        let mut publisher = Publisher::<Vec<u32>>::default();
        let held: Vec<_> = (0..3000).map(|i| publisher.publish(vec![i])).collect();
        let before = publisher.steps;
        for i in 0..100 {
            publisher.collect(|_| ());
            drop(publisher.claim());
            drop(publisher.publish(vec![i]));
        }
        assert!(publisher.steps - before <= 400, "{} steps", publisher.steps - before);
        assert!(held.iter().zip(0..).all(|(value, i)| **value == [i]));
    }

    #[test]
    fn every_value_returns_whichever_thread_drops_last() {
        let mut publisher = Publisher::<Vec<u32>>::default();
        let mut came_back = 0;
        for round in 0..200 {
            let held: Vec<_> = (0..8).map(|i| publisher.publish(vec![round * 8 + i])).collect();
            std::thread::scope(|scope| {
                for _ in 0..3 {
                    let clones = held.clone();
                    scope.spawn(move || clones.into_iter().for_each(drop));
                }
                drop(held);
                publisher.collect(|_| came_back += 1);
            });
            publisher.collect(|_| came_back += 1);
        }
        publisher.collect(|_| came_back += 1);
        assert_eq!(came_back, 200 * 8 - 1, "all but the current one");
    }

    /// Panics when it is freed by another thread than the one that made it.
    struct FreedAtHome(std::thread::ThreadId);

    impl Default for FreedAtHome {
        fn default() -> Self {
            Self(std::thread::current().id())
        }
    }

    impl Drop for FreedAtHome {
        fn drop(&mut self) {
            assert_eq!(self.0, std::thread::current().id());
        }
    }

    #[test]
    fn a_thread_that_drops_the_last_hold_frees_nothing() {
        let mut publisher = Publisher::<FreedAtHome>::default();
        for _ in 0..20 {
            let held: Vec<_> = (0..9).map(|_| publisher.publish(FreedAtHome::default())).collect();
            std::thread::spawn(move || drop(held)).join().unwrap();
            publisher.collect(|_| ());
            assert_eq!((in_use(&publisher), publisher.free.len()), (1, SPARES));
        }
    }

    #[test]
    fn a_value_outlives_its_publisher() {
        let mut publisher = Publisher::<Vec<u32>>::default();
        let held = publisher.publish(vec![7]);
        drop(publisher);
        assert_eq!(*held.clone(), [7]);
        drop(held);
        assert_eq!(*Published::alone(5), 5);
    }
}
