//! Sharing work between threads. No other file names a thread pool.
//!
//! Everything is expressed by joining two jobs, and splits at places that do not depend on the
//! number of threads, so results do not either. The calling thread does the work and offers parts
//! of it: it does not wait for threads that are busy with something else (`crew`).

use std::sync::Arc;

use crate::build_progress::BuildProgress;
#[cfg(feature = "parallel")]
use crate::crew::{Crew, Pool};

/// A pool of threads of the caller's own: a job system of a game engine, for instance.
///
/// A commit takes as long as its executor lets it. For one that finishes even while all other
/// threads are busy, and that a long job of somebody else does not hold up, an executor
///
/// * runs `one` on the calling thread, and offers `other` to the others meanwhile;
/// * takes `other` back when `one` is done and nobody has begun it, and runs it on the calling
///   thread;
/// * waits only for a thread that has begun `other`, and does nothing in the meantime that could
///   take long, such as jobs of somebody else.
///
/// Running one after the other is right, too. Results do not depend on which thread does what.
pub trait Executor: Send + Sync {
    /// Runs each of both exactly once, in any order or at once, and returns when both have
    /// returned. It is called from any thread, also from within a job, many levels deep. A panic in
    /// a job has to go on in the caller, after the other job has ended.
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send));
}

/// Where builds and updates run.
#[derive(Clone, Default)]
pub struct Threads {
    kind: Kind,
    /// Who follows what they do.
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

/// The pool of the process, or the one that the calling thread belongs to.
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

    /// The calling thread, with help from the pool of the process (rayon's current one), which is
    /// also the default. What no thread of the pool has begun in time the calling thread does
    /// itself, so it never waits for what else runs in the pool. No more threads are at work than
    /// the pool has.
    #[cfg(feature = "parallel")]
    pub fn shared() -> Self {
        Self { kind: Kind::Shared(Arc::default()), progress: None }
    }

    /// The caller's own threads. See [`Executor`] for what they have to do.
    pub fn of(executor: Arc<dyn Executor>) -> Self {
        Self { kind: Kind::Own(executor), progress: None }
    }

    /// The same threads, for a build that is watched.
    pub(crate) fn with_progress(&self, progress: &BuildProgress) -> Self {
        Self { progress: Some(progress.clone()), ..self.clone() }
    }

    /// Whether nothing is ever done at once and nobody looks on, so that cutting work into pieces
    /// would only cost time.
    pub(crate) fn is_single_and_unobserved(&self) -> bool {
        self.progress.is_none()
            && match self.kind {
                Kind::One => true,
                #[cfg(feature = "parallel")]
                Kind::Shared(_) => rayon::current_num_threads() == 1,
                Kind::Own(_) => false,
            }
    }

    /// See [`BuildProgress`]. A builder that finds itself cancelled ends as soon as it can, with any tree
    /// at all: nobody will see it.
    #[inline]
    pub(crate) fn is_cancelled(&self) -> bool {
        self.progress.as_ref().is_some_and(BuildProgress::is_cancelled)
    }

    /// Another stage of a build begins, of so many units, and is taken to need `share` of what is
    /// left.
    pub(crate) fn begin_stage(&self, share: f32, units: usize) {
        if let Some(progress) = &self.progress {
            progress.begin_stage(share, units);
        }
    }

    /// So many more units of the stage are done. Not for every single one: threads wait for each
    /// other here.
    #[inline]
    pub(crate) fn advance(&self, units: usize) {
        if let Some(progress) = &self.progress {
            progress.advance(units);
        }
    }

    /// Both results, computed at once if a thread is free.
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

    /// Maps pieces of about `grain` items and merges the results, always in the same way.
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

    /// Visits each item, and its number, in pieces of about `grain` items.
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

/// Runs the jobs one after the other, the second one first. For tests.
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
            let text = threads.reduce(&items, 10, &|piece| format!("{piece:?}"), &|a, b| a + &b);
            assert_eq!(text.matches("[").count(), 128, "{threads:?}");
            let mut squares = items.clone();
            threads.for_each(&mut squares, 7, &|i, item| *item *= i as u64);
            assert!(squares.iter().zip(&items).all(|(square, item)| *square == item * item));
        }
    }
}
