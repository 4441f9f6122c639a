//! Sharing the work of a thread with helpers that may come or not.
//!
//! A thread that forks offers one half and does the other itself. Then it takes the first half
//! back, unless a helper has begun it: so it never waits for a helper to come, only for one that is
//! at work. While it waits, it does other parts of the same work, and none of anybody else's.
//!
//! Helpers are invited from a pool of threads when something is offered. A helper that finds
//! nothing to do leaves soon, since its thread may have other duties; one that comes too late finds
//! an empty list. Blumofe and Leiserson 1999, "Scheduling Multithreaded Computations by Work
//! Stealing", with one list under a lock instead of one for each thread: parts are so coarse that
//! nobody waits at it.

use std::any::Any;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// How often a helper without work looks for some before it leaves: about 20 microseconds, a few
/// times what it takes to invite one.
const LOOKS: u32 = 2000;

/// A pool of threads that helpers come from.
pub(crate) trait Pool {
    /// How many helpers may be there at once.
    fn helpers(&self) -> usize;

    /// Runs this some time, or never.
    fn spawn(&self, help: impl FnOnce() + Send + 'static);
}

/// Those who share the work of one owner, a scene for instance.
#[derive(Default)]
pub(crate) struct Crew {
    state: Mutex<State>,
    /// How many offers there are, to be read without the lock.
    offered: AtomicUsize,
    /// Something was offered or is done.
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// The oldest first: those are the largest.
    offers: VecDeque<Offer>,
    /// Invited, or there.
    helpers: usize,
    /// Threads that wait for a helper.
    waiting: usize,
}

/// Work that nobody has begun.
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
        if let Some(work) = open(&self.work).take() {
            let result = catch_unwind(AssertUnwindSafe(work));
            *open(&self.result) = Some(result);
        }
    }
}

/// A lock that nobody can have poisoned, since nothing panics while it is held.
fn open<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Crew {
    /// Both results. The second job is done by a helper if one comes in time. A panic in either
    /// goes on here, when both have ended.
    pub(crate) fn join<A: Send, B: Send>(
        self: &Arc<Self>,
        pool: &impl Pool,
        one: impl FnOnce() -> A + Send,
        other: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        let job = Job { work: Mutex::new(Some(other)), result: Mutex::new(None) };
        let done = Arc::new(AtomicBool::new(false));
        let work: &dyn Work = &job;
        // SAFETY: this stretches the lifetime of a borrow of `job`. It ends in time: from here on
        // nothing unwinds until the offer has been taken back, and then only the copy in this frame
        // is left, or until `done` is set, which whoever took the offer does after the last use of
        // the borrow. `job` lives until this function returns.
        let work = unsafe { std::mem::transmute::<&dyn Work, &'static dyn Work>(work) };
        let invites = self.offer(pool.helpers(), Offer { work, done: done.clone() });
        let a = catch_unwind(AssertUnwindSafe(|| {
            if invites {
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
        let b = open(&job.result).take();
        match (a, b) {
            (Ok(a), Some(Ok(b))) => (a, b),
            (Err(panic), _) | (_, Some(Err(panic))) => resume_unwind(panic),
            (Ok(_), None) => unreachable!("the job has run"),
        }
    }

    /// Whether one more helper is to be invited.
    fn offer(&self, helpers: usize, offer: Offer) -> bool {
        let mut state = open(&self.state);
        state.offers.push_back(offer);
        self.offered.store(state.offers.len(), Ordering::Relaxed);
        let invites = state.helpers < helpers;
        state.helpers += usize::from(invites);
        if state.waiting > 0 {
            self.changed.notify_one();
        }
        invites
    }

    /// Whether nobody has begun the offer; then nobody will.
    fn take_back(&self, done: &Arc<AtomicBool>) -> bool {
        let mut state = open(&self.state);
        // Offers of this thread that are left are the last ones, nearly always.
        let found = state.offers.iter().rposition(|offer| Arc::ptr_eq(&offer.done, done));
        if let Some(at) = found {
            state.offers.remove(at);
            self.offered.store(state.offers.len(), Ordering::Relaxed);
        }
        found.is_some()
    }

    /// Does other parts of the work, until a helper has done its part.
    fn help_until(&self, done: &AtomicBool) {
        let mut state = open(&self.state);
        while !done.load(Ordering::Acquire) {
            if let Some(offer) = self.pop(&mut state) {
                drop(state);
                self.accept(offer);
                state = open(&self.state);
            } else {
                state.waiting += 1;
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                state.waiting -= 1;
            }
        }
    }

    /// What a helper does.
    fn help(&self) {
        loop {
            let mut state = open(&self.state);
            match self.pop(&mut state) {
                Some(offer) => {
                    drop(state);
                    self.accept(offer);
                }
                None => {
                    drop(state);
                    if !self.look_around() {
                        let mut state = open(&self.state);
                        if state.offers.is_empty() {
                            state.helpers -= 1;
                            return;
                        }
                    }
                }
            }
        }
    }

    /// Whether something is offered soon.
    fn look_around(&self) -> bool {
        (0..LOOKS).any(|_| {
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
        // From here on the work may be gone.
        done.store(true, Ordering::Release);
        if open(&self.state).waiting > 0 {
            self.changed.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Helpers on threads of their own, as many as allowed.
    struct Free(usize);

    impl Pool for Free {
        fn helpers(&self) -> usize {
            self.0
        }

        fn spawn(&self, help: impl FnOnce() + Send + 'static) {
            std::thread::spawn(help);
        }
    }

    /// Helpers that never come.
    struct Busy;

    impl Pool for Busy {
        fn helpers(&self) -> usize {
            3
        }

        fn spawn(&self, _: impl FnOnce() + Send + 'static) {}
    }

    /// Helpers that come when all is over.
    #[derive(Default)]
    struct Late(Mutex<Vec<Box<dyn FnOnce() + Send>>>);

    impl Pool for Late {
        fn helpers(&self) -> usize {
            3
        }

        fn spawn(&self, help: impl FnOnce() + Send + 'static) {
            open(&self.0).push(Box::new(help));
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
        let helpers = std::mem::take(&mut *open(&late.0));
        assert_eq!(helpers.len(), 3);
        helpers.into_iter().for_each(|help| help());
        assert_eq!(open(&crew.state).helpers, 0);
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
            assert!(open(&crew.state).offers.is_empty());
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
