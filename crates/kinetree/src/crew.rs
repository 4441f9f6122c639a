//! Fork-join that never waits for a helper thread to become free.
//!
//! A thread that forks offers one job and runs the other itself. Then it takes the offered job
//! back, unless a helper has begun it: so it never waits for a helper to arrive, only for one that
//! is running a job. While it waits, it runs other jobs of the same crew, and none of other users
//! of the pool.
//!
//! Offering a job spawns a helper task in a thread pool. A helper that finds no job soon returns
//! its thread to the pool; one that arrives too late finds an empty queue. Blumofe and Leiserson
//! 1999, "Scheduling Multithreaded Computations by Work Stealing", with one locked queue instead of
//! one per thread: the jobs are so coarse that the lock is not contended.

use std::any::Any;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// How often a helper without a job polls for one before it leaves: about 20 microseconds, a few
/// times the cost of spawning a helper.
const MAX_POLLS: u32 = 2000;

/// A thread pool that runs helpers.
pub(crate) trait Pool {
    /// The largest number of concurrent helpers.
    fn helpers(&self) -> usize;

    /// Runs the closure at some time, or never.
    fn spawn(&self, help: impl FnOnce() + Send + 'static);
}

/// The threads that share the work of one owner, for instance a scene.
#[derive(Default)]
pub(crate) struct Crew {
    state: Mutex<State>,
    /// The number of offers, readable without the lock.
    offered: AtomicUsize,
    /// Signals that a job was offered or is done.
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// The oldest first, because they are the largest.
    offers: VecDeque<Offer>,
    /// Helpers that were spawned and have not left.
    helpers: usize,
    /// Threads that wait for a helper.
    waiting: usize,
}

/// A job that no thread has begun.
struct Offer {
    work: &'static dyn Work,
    done: Arc<AtomicBool>,
}

trait Work: Sync {
    /// Does not unwind.
    fn run(&self);
}

struct Job<F, R> {
    work: Mutex<Option<F>>,
    result: Mutex<Option<Result<R, Box<dyn Any + Send>>>>,
}

impl<F: FnOnce() -> R + Send, R: Send> Work for Job<F, R> {
    fn run(&self) {
        if let Some(work) = lock(&self.work).take() {
            let result = catch_unwind(AssertUnwindSafe(work));
            *lock(&self.result) = Some(result);
        }
    }
}

/// Locks a mutex. It is never poisoned, because nothing panics while a lock is held.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Crew {
    /// Runs both jobs and returns their results. A helper runs the second one if it arrives in
    /// time. A panic in either is resumed here after both have ended.
    pub(crate) fn join<A: Send, B: Send>(
        self: &Arc<Self>,
        pool: &impl Pool,
        one: impl FnOnce() -> A + Send,
        other: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        let job = Job { work: Mutex::new(Some(other)), result: Mutex::new(None) };
        let done = Arc::new(AtomicBool::new(false));
        let work: &dyn Work = &job;
        // SAFETY: this extends the lifetime of a borrow of `job`, which lives until this function
        // returns. The borrow is not used after that: from here on nothing unwinds until either the
        // offer has been taken back, so that the only copy is the one in this frame, or `done` is
        // set, which the thread that took the offer does after its last use of the borrow.
        let work = unsafe { std::mem::transmute::<&dyn Work, &'static dyn Work>(work) };
        let spawns = self.offer(pool.helpers(), Offer { work, done: done.clone() });
        let a = catch_unwind(AssertUnwindSafe(|| {
            if spawns {
                let crew = self.clone();
                pool.spawn(move || crew.help());
            }
            one()
        }));
        if !self.take_back(&done) {
            self.help_until(&done);
        } else if a.is_ok() {
            job.run();
        }
        let b = lock(&job.result).take();
        match (a, b) {
            (Ok(a), Some(Ok(b))) => (a, b),
            (Err(panic), _) | (_, Some(Err(panic))) => resume_unwind(panic),
            (Ok(_), None) => unreachable!("the job has run"),
        }
    }

    /// Adds an offer to the queue. Returns whether the caller must spawn another helper.
    fn offer(&self, helpers: usize, offer: Offer) -> bool {
        let mut state = lock(&self.state);
        state.offers.push_back(offer);
        self.offered.store(state.offers.len(), Ordering::Relaxed);
        let spawns = state.helpers < helpers;
        state.helpers += usize::from(spawns);
        if state.waiting > 0 {
            self.changed.notify_one();
        }
        spawns
    }

    /// Removes an offer from the queue. Returns false if a thread has begun it.
    fn take_back(&self, done: &Arc<AtomicBool>) -> bool {
        let mut state = lock(&self.state);
        // The remaining offers of this thread are nearly always the last ones.
        let found = state.offers.iter().rposition(|offer| Arc::ptr_eq(&offer.done, done));
        if let Some(at) = found {
            state.offers.remove(at);
            self.offered.store(state.offers.len(), Ordering::Relaxed);
        }
        found.is_some()
    }

    /// Runs other jobs of the queue until a helper has finished the one given.
    fn help_until(&self, done: &AtomicBool) {
        let mut state = lock(&self.state);
        while !done.load(Ordering::Acquire) {
            if let Some(offer) = self.pop(&mut state) {
                drop(state);
                self.accept(offer);
                state = lock(&self.state);
            } else {
                state.waiting += 1;
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                state.waiting -= 1;
            }
        }
    }

    /// The main loop of a helper.
    fn help(&self) {
        loop {
            let mut state = lock(&self.state);
            match self.pop(&mut state) {
                Some(offer) => {
                    drop(state);
                    self.accept(offer);
                }
                None => {
                    drop(state);
                    if !self.poll() {
                        let mut state = lock(&self.state);
                        if state.offers.is_empty() {
                            state.helpers -= 1;
                            return;
                        }
                    }
                }
            }
        }
    }

    /// Polls for offers. Returns false if none arrives in time.
    fn poll(&self) -> bool {
        (0..MAX_POLLS).any(|_| {
            std::hint::spin_loop();
            self.offered.load(Ordering::Relaxed) > 0
        })
    }

    fn pop(&self, state: &mut State) -> Option<Offer> {
        let offer = state.offers.pop_front();
        self.offered.store(state.offers.len(), Ordering::Relaxed);
        offer
    }

    fn accept(&self, Offer { work, done }: Offer) {
        work.run();
        // After this store, the borrow of the job may have ended.
        done.store(true, Ordering::Release);
        if lock(&self.state).waiting > 0 {
            self.changed.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Helpers on their own threads, as many as allowed.
    struct Free(usize);

    impl Pool for Free {
        fn helpers(&self) -> usize {
            self.0
        }

        fn spawn(&self, help: impl FnOnce() + Send + 'static) {
            std::thread::spawn(help);
        }
    }

    /// Helpers that never run.
    struct Busy;

    impl Pool for Busy {
        fn helpers(&self) -> usize {
            3
        }

        fn spawn(&self, _: impl FnOnce() + Send + 'static) {}
    }

    /// Helpers that run after all work is done.
    #[derive(Default)]
    struct Late(Mutex<Vec<Box<dyn FnOnce() + Send>>>);

    impl Pool for Late {
        fn helpers(&self) -> usize {
            3
        }

        fn spawn(&self, help: impl FnOnce() + Send + 'static) {
            lock(&self.0).push(Box::new(help));
        }
    }

    fn sum(crew: &Arc<Crew>, pool: &(impl Pool + Sync), numbers: &[u64]) -> u64 {
        if numbers.len() <= 3 {
            return numbers.iter().sum();
        }
        let (one, other) = numbers.split_at(numbers.len() / 2);
        let (a, b) = crew.join(pool, || sum(crew, pool, one), || sum(crew, pool, other));
        a + b
    }

    #[test]
    fn work_is_done_whether_helpers_come_or_not() {
        let numbers: Vec<u64> = (0..20_000).collect();
        let right = 19_999 * 10_000;
        for round in 0..20 {
            let crew = Arc::new(Crew::default());
            assert_eq!(sum(&crew, &Free(round % 5), &numbers), right);
            assert_eq!(sum(&crew, &Free(4), &numbers), right);
        }
        assert_eq!(sum(&Arc::default(), &Busy, &numbers), right);
        let (crew, late) = (Arc::default(), Late::default());
        assert_eq!(sum(&crew, &late, &numbers), right);
        let helpers = std::mem::take(&mut *lock(&late.0));
        assert_eq!(helpers.len(), 3);
        helpers.into_iter().for_each(|help| help());
        assert_eq!(lock(&crew.state).helpers, 0);
    }

    #[test]
    fn a_panic_goes_on_where_the_work_was_forked() {
        for pool in [0, 4] {
            let crew = Arc::new(Crew::default());
            for round in 0..50 {
                let fails = |which: usize| assert!(round % 3 != which, "on purpose");
                let caught = catch_unwind(AssertUnwindSafe(|| crew.join(&Free(pool), || fails(0), || fails(1))));
                assert_eq!(caught.is_err(), round % 3 < 2);
            }
            assert!(lock(&crew.state).offers.is_empty());
        }
    }

    #[test]
    fn several_threads_share_a_crew() {
        let crew = Arc::new(Crew::default());
        let numbers: Vec<u64> = (0..5000).collect();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..20).for_each(|_| assert_eq!(sum(&crew, &Free(2), &numbers), 4999 * 2500)));
            }
        });
    }
}
