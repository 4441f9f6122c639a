//! Keeps a panic of one engine from ending the run.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::failure::Failure;

/// Runs a job; a panic becomes an error.
pub(super) fn guarded<R>(job: impl FnOnce() -> Result<R, Failure>) -> Result<R, Failure> {
    catch_unwind(AssertUnwindSafe(job)).unwrap_or_else(|_| Err("it panicked".into()))
}
