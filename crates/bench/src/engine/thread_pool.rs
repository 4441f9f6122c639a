//! The threads on which engines build.

use crate::failure::Failure;

/// A rayon pool of a fixed number of threads.
pub(crate) struct ThreadPool {
    /// The number of threads.
    pub(crate) threads: usize,
    rayon: rayon::ThreadPool,
}

impl ThreadPool {
    /// Starts this number of threads.
    ///
    /// # Errors
    /// The system refuses to start them.
    pub(crate) fn new(threads: usize) -> Result<Self, Failure> {
        Ok(Self { threads, rayon: rayon::ThreadPoolBuilder::new().num_threads(threads).build()? })
    }

    /// Runs a job in the pool, so that engines that use rayon use these threads.
    pub(crate) fn run<R: Send>(&self, job: impl FnOnce() -> R + Send) -> R {
        self.rayon.install(job)
    }
}
