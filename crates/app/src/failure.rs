//! How a command fails: with one line, and an exit code.

use std::fmt;
use std::process::ExitCode;

/// Why a command failed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The arguments are wrong: exit code 2, as for everything that `clap` refuses.
    Arguments(String),
    /// The work failed: exit code 1. The message names the file.
    Work(String),
}

impl Failure {
    pub(crate) fn arguments(message: impl Into<String>) -> Self {
        Self::Arguments(message.into())
    }

    pub(crate) fn work(message: impl Into<String>) -> Self {
        Self::Work(message.into())
    }

    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Arguments(_) => ExitCode::from(2),
            Self::Work(_) => ExitCode::FAILURE,
        }
    }
}

/// One line, even if a name contains line breaks.
impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Arguments(message) | Self::Work(message)) = self;
        let line: String = message.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        f.write_str(line.trim_end())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_one_line_whatever_it_quotes() {
        assert_eq!(Failure::work("odd\nname.glb: is\tbroken\n").to_string(), "odd name.glb: is broken");
    }
}
