//! The processor level that all engines are forced to, as far as possible.
//!
//! The library reads its level once per process, from `KINETREE_SIMD`, so another level needs
//! another process.

use std::process::{Command, ExitCode};

use kinetree::simd::Level;

use crate::failure::Failure;

/// The environment variable from which the library reads its level.
const VARIABLE: &str = "KINETREE_SIMD";

/// The instructions of an engine whose level cannot be chosen.
pub(crate) const OWN_BUILD: &str = "own build";

/// The level with that name.
///
/// # Errors
/// A sentence that lists the levels of this processor.
pub(crate) fn by_name(name: &str) -> Result<Level, String> {
    let all = Level::available();
    all.iter().find(|level| level.name() == name).copied().ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|level| level.name()).collect();
        format!("this machine has no level {name}; it has {}", names.join(", "))
    })
}

/// Runs this program again with the same arguments at that level, and returns its exit code; `None`
/// if this process is already at that level.
///
/// # Errors
/// The process cannot be started, or the library ignores the variable.
pub(crate) fn rerun_at(level: Option<Level>) -> Result<Option<ExitCode>, Failure> {
    let Some(name) = level.map(Level::name).filter(|name| *name != Level::current().name()) else { return Ok(None) };
    if std::env::var(VARIABLE).is_ok_and(|value| value == name) {
        return Err(format!("the library does not follow {VARIABLE}={name}").into());
    }
    let program = std::env::current_exe()?;
    let status = Command::new(program).args(std::env::args_os().skip(1)).env(VARIABLE, name).status()?;
    // A process that was killed has no exit code.
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(Some(code.map_or(ExitCode::FAILURE, ExitCode::from)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_that_the_machine_lacks_is_an_error_that_lists_those_it_has() {
        for level in Level::available() {
            assert_eq!(by_name(level.name()).unwrap().name(), level.name());
        }
        let lacking = if cfg!(target_arch = "aarch64") { "avx2" } else { "neon" };
        for name in [lacking, "nonsense", "AVX2"] {
            let message = by_name(name).unwrap_err();
            assert!(message.contains(name), "{message}");
            assert!(Level::available().iter().all(|level| message.contains(level.name())), "{message}");
        }
    }

    #[test]
    fn a_process_that_is_at_the_level_already_stays() {
        assert!(rerun_at(None).unwrap().is_none());
        assert!(rerun_at(Some(Level::current())).unwrap().is_none());
    }
}
