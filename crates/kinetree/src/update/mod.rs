//! Keeping trees good while their primitives move.

mod action;
mod motion;
mod plan;
mod quality;
mod refit;

pub use action::{Action, Reason};
pub use motion::Motion;
pub use quality::drift;
pub use refit::refit;

pub(crate) use plan::{Doubt, Edit, MeshUpdate, Upkeep, decide};
