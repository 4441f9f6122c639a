//! What one can ask a frame: the closest hit, whether there is any, and all of them.
//!
//! The way through both levels is in `two_level`, once for single rays (`trace_ray`) and packets of
//! them (`trace_packet`). `brute_force` answers the same queries by testing every triangle: the
//! slow twin that everything is compared with.

mod batch;
mod brute_force;
mod candidate;
mod collector;
mod hit;
mod in_double;
mod options;
mod packet_hits;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod sort;
#[cfg(not(feature = "internals"))]
#[expect(unreachable_pub, reason = "public with the feature `internals`")]
mod sort;
mod trace_packet;
mod trace_ray;
mod two_level;
mod without;

pub use candidate::Candidate;
pub use hit::Hit;
pub use options::{BruteForce, Coherence, Cull, Query};
