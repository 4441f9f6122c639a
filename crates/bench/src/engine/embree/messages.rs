//! Statistics that Embree prints about its trees. The cost by its own formula is available in no
//! other way, so standard output is captured.

use std::io::{Read, Seek, Write};
use std::os::fd::AsRawFd;

/// Runs a job, and returns its result with what the process wrote to standard output meanwhile.
/// `None` if the system does not allow the redirection.
pub(super) fn capture_output<R>(job: impl FnOnce() -> R) -> Option<(R, String)> {
    let path = std::env::temp_dir().join(format!("kinetree-bench-{}", std::process::id()));
    let mut file = std::fs::File::options().read(true).write(true).create(true).truncate(true).open(&path).ok()?;
    std::fs::remove_file(&path).ok()?;
    std::io::stdout().flush().ok()?;
    let redirected = Redirected::begin(file.as_raw_fd())?;
    let result = job();
    drop(redirected);
    let mut text = String::new();
    file.rewind().ok()?;
    file.read_to_string(&mut text).ok()?;
    Some((result, text))
}

/// Redirects standard output while it lives.
struct Redirected(i32);

impl Redirected {
    fn begin(to: i32) -> Option<Self> {
        flush();
        // SAFETY: both calls take file descriptors and touch no memory.
        let before = unsafe { libc::dup(libc::STDOUT_FILENO) };
        if before < 0 {
            return None;
        }
        let this = Self(before);
        // SAFETY: as above.
        (unsafe { libc::dup2(to, libc::STDOUT_FILENO) } >= 0).then_some(this)
    }
}

impl Drop for Redirected {
    fn drop(&mut self) {
        flush();
        // SAFETY: the descriptor was opened by `begin`, and no other owner exists.
        unsafe {
            libc::dup2(self.0, libc::STDOUT_FILENO);
            libc::close(self.0);
        }
    }
}

/// Flushes the output buffers of the C library.
fn flush() {
    // SAFETY: null means all streams of the C library, which locks them itself.
    unsafe { libc::fflush(std::ptr::null_mut()) };
}

/// The expected cost of a ray, from the message about a finished tree: `total : sah = 24.954
/// (100.00%), ...`.
pub(super) fn cost(text: &str) -> Option<f32> {
    let line = text.lines().find(|line| line.trim_start().starts_with("total") && line.contains("sah ="))?;
    line.split("sah =").nth(1)?.split_whitespace().next()?.parse().ok().filter(|cost: &f32| cost.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cost_is_found_in_the_message() {
        let text =
            "finished BVH8<triangle4>\n  total            : sah =  24.954 (100.00%), #bytes = 1\n  leaves : sah = 6.7";
        assert_eq!(cost(text), Some(24.954));
        assert_eq!(cost("  total : used = 1.5 MB"), None);
        assert_eq!(cost("  total : sah = nan (1%)"), None);
    }
}
