//! Keeping trees good while their primitives move.

mod motion;
mod plan;
mod quality;
mod refit;

pub use motion::Motion;
pub use plan::{Action, Reason};
pub use quality::drift;
pub use refit::refit;

pub(crate) use plan::{Candidate, Edit, decide, has_rotted};
pub(crate) use quality::BuildCost;
