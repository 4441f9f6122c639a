//! Threads that build a tree.

use crate::failure::Failure;

/// So many threads, and no others, work on what runs within.
pub(crate) struct ThreadPool {
    /// How many.
    pub(crate) threads: usize,
    rayon: rayon::ThreadPool,
}

impl ThreadPool {
    /// So many threads.
    ///
    /// # Errors
    /// The system gives no threads.
    pub(crate) fn new(threads: usize) -> Result<Self, Failure> {
        Ok(Self { threads, rayon: rayon::ThreadPoolBuilder::new().num_threads(threads).build()? })
    }

    /// Runs a job on these threads: engines that share work through rayon find them there.
    pub(crate) fn run<R: Send>(&self, job: impl FnOnce() -> R + Send) -> R {
        self.rayon.install(job)
    }
}
