//! What one can ask a frame: the closest hit, whether there is any, and all of them.
//!
//! `brute_force` answers the same questions by looking at every triangle: the slow twin that everything is compared with.

mod all_hits;
mod trace_ray;
mod batch;
mod brute_force;
mod candidate;
mod closest;
mod packet_collector;
mod hit;
mod in_double;
mod occluded;
mod options;
#[doc(hidden)]
pub mod sort;
mod trace_packet;
mod without;

pub use candidate::Candidate;
pub use hit::Hit;
pub use options::{BruteForce, Coherence, Cull, Query};

use all_hits::AllHits;
use candidate::{AskFilter, Filter, NoFilter};
use closest::Closest;
use occluded::Occluded;
