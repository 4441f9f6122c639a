//! The log of a run: printed, and kept for the results.

use std::time::Instant;

/// Prints lines, and keeps them.
pub(crate) struct Log {
    /// All lines so far.
    pub(crate) text: String,
    since: Instant,
}

impl Default for Log {
    fn default() -> Self {
        Self { text: String::new(), since: Instant::now() }
    }
}

impl Log {
    /// Prints a line, and keeps it.
    pub(crate) fn print(&mut self, line: &str) {
        println!("{line}");
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// Logs the time since the previous call, as the duration of this part.
    pub(crate) fn duration_of(&mut self, part: &str) {
        self.print(&format!("  [{part}: {:.1} s]", self.since.elapsed().as_secs_f64()));
        self.since = Instant::now();
    }
}
