//! Parallel execution. No other file names a thread pool.
//!
//! All parallelism is a join of two jobs, and where work is split does not depend on the number of
//! threads, so results do not either. The calling thread does the work and offers parts of it: it
//! does not wait for threads that are busy with something else (`crew`).

use std::sync::Arc;

use crate::build_progress::BuildProgress;
#[cfg(feature = "parallel")]
use crate::crew::{Crew, Pool};

/// The caller's own thread pool, for instance the job system of a game engine.
///
/// A commit finishes even while all other threads are busy, and is not delayed by long jobs of
/// other systems, if the executor
///
/// * runs `one` on the calling thread, and offers `other` to the other threads meanwhile;
/// * takes `other` back if no thread has begun it when `one` is done, and runs it on the calling
///   thread;
/// * waits only for a thread that has begun `other`, and runs nothing long in the meantime, such as
///   jobs of other systems.
///
/// Running one after the other is correct, too. Results do not depend on which thread runs which
/// job.
pub trait Executor: Send + Sync {
    /// Runs each job exactly once, in any order or concurrently, and returns when both have
    /// returned. It is called from any thread, also from within a job, many levels deep. A panic in
    /// a job must be resumed in the caller after the other job has ended.
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send));
}

/// Where builds and updates run.
#[derive(Clone, Default)]
pub struct Threads {
    kind: Kind,
    /// Observes and cancels a build.
    progress: Option<BuildProgress>,
}

#[derive(Clone)]
enum Kind {
    One,
    #[cfg(feature = "parallel")]
    Shared(Arc<Crew>),
    Own(Arc<dyn Executor>),
}

impl Default for Kind {
    fn default() -> Self {
        #[cfg(feature = "parallel")]
        let kind = Self::Shared(Arc::default());
        #[cfg(not(feature = "parallel"))]
        let kind = Self::One;
        kind
    }
}

/// The rayon pool of the calling thread, or the global one.
#[cfg(feature = "parallel")]
struct Current;

#[cfg(feature = "parallel")]
impl Pool for Current {
    fn helpers(&self) -> usize {
        rayon::current_num_threads() - 1
    }

    fn spawn(&self, help: impl FnOnce() + Send + 'static) {
        rayon::spawn(help);
    }
}

impl std::fmt::Debug for Threads {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self.kind {
            Kind::One => "Threads::one",
            #[cfg(feature = "parallel")]
            Kind::Shared(_) => "Threads::shared",
            Kind::Own(_) => "Threads::of",
        })
    }
}

impl Threads {
    /// Everything on the calling thread.
    pub fn one() -> Self {
        Self { kind: Kind::One, progress: None }
    }

    /// The calling thread, with help from rayon's current thread pool; the default. The calling
    /// thread runs the jobs that no thread of the pool has begun in time, so it never waits for
    /// other work in the pool. No more threads are used than the pool has.
    #[cfg(feature = "parallel")]
    pub fn shared() -> Self {
        Self { kind: Kind::Shared(Arc::default()), progress: None }
    }

    /// The caller's own threads: see [`Executor`].
    pub fn of(executor: Arc<dyn Executor>) -> Self {
        Self { kind: Kind::Own(executor), progress: None }
    }

    /// The same threads, for a build that reports its progress.
    pub(crate) fn with_progress(&self, progress: &BuildProgress) -> Self {
        Self { progress: Some(progress.clone()), ..self.clone() }
    }

    /// Whether all work runs on one thread and no progress is reported, so that splitting work into
    /// tasks is pure overhead.
    pub(crate) fn is_single_and_unobserved(&self) -> bool {
        self.progress.is_none()
            && match self.kind {
                Kind::One => true,
                #[cfg(feature = "parallel")]
                Kind::Shared(_) => rayon::current_num_threads() == 1,
                Kind::Own(_) => false,
            }
    }

    /// Whether the build was cancelled: see [`BuildProgress`]. A cancelled builder returns soon,
    /// with an unspecified tree, which the caller drops.
    #[inline]
    pub(crate) fn is_cancelled(&self) -> bool {
        self.progress.as_ref().is_some_and(BuildProgress::is_cancelled)
    }

    /// Begins the next stage of a build, of `steps` steps, which is expected to take `fraction` of
    /// the time that is left.
    pub(crate) fn begin_stage(&self, fraction: f32, steps: usize) {
        if let Some(progress) = &self.progress {
            progress.begin_stage(fraction, steps);
        }
    }

    /// Records that `steps` more steps of the stage are done. Call it for many steps at a time: the
    /// counter is shared by all threads.
    #[inline]
    pub(crate) fn advance(&self, steps: usize) {
        if let Some(progress) = &self.progress {
            progress.advance(steps);
        }
    }

    /// Runs both jobs, in parallel if a thread is free, and returns their results.
    pub(crate) fn join<A: Send, B: Send>(
        &self,
        one: impl FnOnce() -> A + Send,
        other: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        match &self.kind {
            Kind::One => (one(), other()),
            #[cfg(feature = "parallel")]
            Kind::Shared(_) if rayon::current_num_threads() == 1 => (one(), other()),
            #[cfg(feature = "parallel")]
            Kind::Shared(crew) => crew.join(&Current, one, other),
            Kind::Own(executor) => {
                let (mut one, mut other) = (Some(one), Some(other));
                let (mut a, mut b) = (None, None);
                executor.join(&mut || a = one.take().map(|job| job()), &mut || b = other.take().map(|job| job()));
                (a.expect("the executor ran the first job"), b.expect("the executor ran the second job"))
            }
        }
    }

    /// Maps slices of at most `grain` items and merges the results pairwise. Neither the slices nor
    /// the order of merging depends on the number of threads.
    pub(crate) fn reduce<T: Sync, R: Send>(
        &self,
        items: &[T],
        grain: usize,
        map: &(impl Fn(&[T]) -> R + Sync),
        merge: &(impl Fn(R, R) -> R + Sync),
    ) -> R {
        if items.len() <= grain {
            return map(items);
        }
        let (one, other) = items.split_at(items.len() / 2);
        let (a, b) = self.join(|| self.reduce(one, grain, map, merge), || self.reduce(other, grain, map, merge));
        merge(a, b)
    }

    /// Calls `visit` with the index of each item and the item, at most `grain` items per task.
    pub(crate) fn for_each<T: Send>(&self, items: &mut [T], grain: usize, visit: &(impl Fn(usize, &mut T) + Sync)) {
        self.for_each_from(0, items, grain, visit);
    }

    fn for_each_from<T: Send>(
        &self,
        first: usize,
        items: &mut [T],
        grain: usize,
        visit: &(impl Fn(usize, &mut T) + Sync),
    ) {
        if items.len() <= grain {
            items.iter_mut().enumerate().for_each(|(i, item)| visit(first + i, item));
            return;
        }
        let half = items.len() / 2;
        let (one, other) = items.split_at_mut(half);
        self.join(
            || self.for_each_from(first, one, grain, visit),
            || self.for_each_from(first + half, other, grain, visit),
        );
    }
}

/// Runs the jobs one after the other, the second one first, for tests.
#[cfg(test)]
pub(crate) struct Backwards;

#[cfg(test)]
impl Executor for Backwards {
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
        other();
        one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_pool_gives_the_same_results() {
        let items: Vec<u64> = (0..1000).collect();
        for threads in [Threads::one(), Threads::default(), Threads::of(Arc::new(Backwards))] {
            let text = threads.reduce(&items, 10, &|slice| format!("{slice:?}"), &|a, b| a + &b);
            assert_eq!(text.matches("[").count(), 128, "{threads:?}");
            let mut squares = items.clone();
            threads.for_each(&mut squares, 7, &|i, item| *item *= i as u64);
            assert!(squares.iter().zip(&items).all(|(square, item)| *square == item * item));
        }
    }
}
