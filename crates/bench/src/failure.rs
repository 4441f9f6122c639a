//! What a command reports when it fails.

/// The reason, as a sentence.
pub(crate) type Failure = Box<dyn std::error::Error + Send + Sync>;
