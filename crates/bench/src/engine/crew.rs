//! Threads that build a tree.

use crate::Failure;

/// So many threads, and no others, work on what runs within.
pub(crate) struct Crew {
    /// How many.
    pub(crate) threads: usize,
    pool: rayon::ThreadPool,
}

impl Crew {
    /// So many threads.
    ///
    /// # Errors
    /// The system gives no threads.
    pub(crate) fn new(threads: usize) -> Result<Self, Failure> {
        Ok(Self { threads, pool: rayon::ThreadPoolBuilder::new().num_threads(threads).build()? })
    }

    /// Runs a job on these threads: engines that share work through rayon find them there.
    pub(crate) fn run<R: Send>(&self, job: impl FnOnce() -> R + Send) -> R {
        self.pool.install(job)
    }
}
