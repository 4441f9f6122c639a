//! Keeping trees good while their primitives move.

mod action;
mod motion;
mod plan;
mod quality;
#[cfg(any(test, feature = "twins"))]
mod refit;

pub use action::{Action, Reason};
pub use motion::Motion;
#[cfg(any(test, feature = "twins"))]
#[doc(hidden)]
pub use refit::refit;

pub(crate) use plan::{Doubt, Edit, MeshUpdate, Upkeep, decide};
