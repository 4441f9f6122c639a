//! Exact answers, with which disputes between engines are decided.
//!
//! `crossing` decides exactly whether a ray meets a triangle, with the numbers of `expansion`;
//! `search` tests every triangle; `rounded` gives weights and angles in double precision, where
//! that suffices.

mod crossing;
mod expansion;
mod rounded;
mod search;

pub(crate) use crossing::crossing;
pub(crate) use rounded::Rounded;
pub(crate) use search::closest_by_brute_force;
