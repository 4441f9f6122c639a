//! Repeats a comparison in several processes, one after another. The layout of memory is the same
//! for all rounds of a process, and shifts all of their times.

use std::path::PathBuf;
use std::process::Command;

use crate::failure::Failure;
use crate::report::Record;

/// Runs this program once per process with the same arguments, and joins their measurements.
///
/// # Errors
/// A process that cannot be started, fails, or leaves no readable results.
pub(crate) fn run(processes: usize) -> Result<Record, Failure> {
    let program = std::env::current_exe()?;
    let mut all = Record::default();
    for process in 0..processes {
        println!("\n#### process {} of {processes}", process + 1);
        let part = Part(std::env::temp_dir().join(format!("kinetree-bench-{}-{process}.json", std::process::id())));
        let mut command = Command::new(&program);
        command.args(std::env::args_os().skip(1)).arg("--part").arg(&part.0).args(["--number", &process.to_string()]);
        let status = command.status()?;
        if !status.success() {
            return Err(format!("process {} failed: {status}", process + 1).into());
        }
        all.join(serde_json::from_str(&std::fs::read_to_string(&part.0)?)?, process);
    }
    Ok(all)
}

/// A temporary file, removed when dropped.
struct Part(PathBuf);

impl Drop for Part {
    fn drop(&mut self) {
        // If it cannot be removed, it stays among other temporary files.
        let _ = std::fs::remove_file(&self.0);
    }
}
