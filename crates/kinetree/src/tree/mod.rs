//! The binary tree and its promises.

mod bvh;
mod cost;
mod link;
mod node;
mod validate;
mod violation;

pub use bvh::{Bvh, MAX_DEPTH};
pub use link::{Link, Target};
pub use node::Node;
pub use violation::{Location, Violation};
