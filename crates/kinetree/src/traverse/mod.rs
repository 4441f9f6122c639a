//! Walking trees: one walk, many questions.

mod two_level;
mod walk;
mod work;

pub use two_level::{Posed, TwoLevel};
pub use walk::{Visitor, walk};
pub use work::{Tally, Work};
