//! Sharing work between threads. No other file names a thread pool.
//!
//! Everything is expressed by joining two jobs, and splits at places that do not depend on the number of threads, so results do not either.

use std::sync::Arc;

use crate::watch::Watch;

/// A pool of threads of the caller's own: a job system of a game engine, for instance.
pub trait Executor: Send + Sync {
    /// Runs both, at once if a thread is free, and returns when both are done. May be called from within a job.
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send));
}

/// Where builds and updates run.
#[derive(Clone, Default)]
pub struct Threads {
    kind: Kind,
    /// Who follows what they do.
    watch: Option<Watch>,
}

#[derive(Clone, Default)]
enum Kind {
    #[cfg_attr(not(feature = "parallel"), default)]
    One,
    #[cfg(feature = "parallel")]
    #[default]
    Shared,
    Own(Arc<dyn Executor>),
}

impl std::fmt::Debug for Threads {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self.kind {
            Kind::One => "Threads::one",
            #[cfg(feature = "parallel")]
            Kind::Shared => "Threads::shared",
            Kind::Own(_) => "Threads::of",
        })
    }
}

impl Threads {
    /// Everything on the calling thread.
    pub fn one() -> Self {
        Self { kind: Kind::One, watch: None }
    }

    /// The pool of the process (rayon's current one), which is also the default.
    #[cfg(feature = "parallel")]
    pub fn shared() -> Self {
        Self { kind: Kind::Shared, watch: None }
    }

    /// The caller's own threads.
    pub fn of(executor: Arc<dyn Executor>) -> Self {
        Self { kind: Kind::Own(executor), watch: None }
    }

    /// The same threads, for a build that is watched.
    pub(crate) fn watched_by(&self, watch: &Watch) -> Self {
        Self { watch: Some(watch.clone()), ..self.clone() }
    }

    /// Whether nothing is ever done at once and nobody looks on, so that cutting work into pieces would only cost time.
    pub(crate) fn is_alone(&self) -> bool {
        self.watch.is_none()
            && match self.kind {
                Kind::One => true,
                #[cfg(feature = "parallel")]
                Kind::Shared => rayon::current_num_threads() == 1,
                Kind::Own(_) => false,
            }
    }

    /// See [`Watch`]. A builder that finds itself cancelled ends as soon as it can, with any tree at all: nobody will see it.
    #[inline]
    pub(crate) fn is_cancelled(&self) -> bool {
        self.watch.as_ref().is_some_and(Watch::is_cancelled)
    }

    /// Another stage of a build begins, of so many units, and is taken to need `share` of what is left.
    pub(crate) fn stage(&self, share: f32, units: usize) {
        if let Some(watch) = &self.watch {
            watch.stage(share, units);
        }
    }

    /// So many more units of the stage are done. Not for every single one: threads wait for each other here.
    #[inline]
    pub(crate) fn tick(&self, units: usize) {
        if let Some(watch) = &self.watch {
            watch.tick(units);
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
            Kind::Shared => rayon::join(one, other),
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
