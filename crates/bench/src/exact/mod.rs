//! What is right, whatever the engines say.
//!
//! `crossing` decides exactly whether a ray meets a triangle, with the numbers of `expansion`;
//! `search` looks at every triangle; `rounded` has weights and angles in double precision, for what
//! needs no more.

mod crossing;
mod expansion;
mod rounded;
mod search;

pub(crate) use crossing::crossing;
pub(crate) use rounded::Rounded;
pub(crate) use search::closest_by_brute_force;
