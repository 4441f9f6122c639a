//! What a frame's rays are traced against: a tree over instances, each of which leads to the tree
//! of a mesh.

use std::fmt;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use super::Hierarchy;
use crate::geometry::inverse::DoubleInverse;
use crate::geometry::{Precision, Triangles};
use crate::simd::Level;
use crate::wide::{InstanceRecord, MeshBvh, TopLevelBvh};

/// A mesh as it is in one frame, with its tree.
#[doc(alias = "BLAS")]
#[derive(Clone, Default)]
pub(crate) struct MeshFrame {
    /// Over the triangles, object space.
    pub(crate) bvh: MeshBvh,
    /// Object space.
    pub(crate) triangles: Triangles,
    /// How carefully triangles are tested.
    pub(crate) precision: Precision,
}

/// Tells the frames of a process apart. Hits carry it, so that a hit is recognised when it is taken
/// to another frame than its own.
///
/// The counter has 32 bits and starts again after 2^32 - 2 frames: 828 days at 60 frames a second.
/// A hit that is kept until exactly its stamp is given out again is not recognised as foreign: it
/// then resolves to whatever has its numbers in the new frame, or panics if nothing has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct FrameStamp(NonZeroU32);

impl FrameStamp {
    /// Of hits whose walk is not over; frames never have it.
    pub(crate) const UNKNOWN: Self = Self(NonZeroU32::MAX);

    /// A stamp that no other frame of the process has had, until the counter starts again.
    pub(crate) fn fresh() -> Self {
        static COUNTER: AtomicU32 = AtomicU32::new(1);
        Self::next_of(&COUNTER)
    }

    fn next_of(counter: &AtomicU32) -> Self {
        loop {
            if let Some(number) = NonZeroU32::new(counter.fetch_add(1, Ordering::Relaxed))
                && Self(number) != Self::UNKNOWN
            {
                return Self(number);
            }
        }
    }
}

/// A frame, as walks see it.
#[doc(alias = "TLAS")]
#[derive(Clone)]
pub(crate) struct FrameBvh {
    /// Over the instances, world space.
    pub(crate) top: TopLevelBvh,
    /// What the top level leads to.
    pub(crate) instances: Vec<InstanceRecord>,
    /// What the instances lead to.
    pub(crate) meshes: Vec<Arc<MeshFrame>>,
    /// How rays enter the instances that are entered in double precision, in the order of their
    /// numbers.
    pub(crate) doubles: Vec<(u32, DoubleInverse)>,
    /// What walks are compiled for.
    pub(crate) level: Level,
    /// What hits of this frame carry.
    pub(crate) stamp: FrameStamp,
    /// Which instances are below which node.
    pub(crate) hierarchy: Arc<Hierarchy>,
    /// The numbers of the instances in the hierarchy, one per instance record.
    pub(crate) numbers: Vec<u32>,
}

impl Default for FrameBvh {
    fn default() -> Self {
        Self {
            top: TopLevelBvh::default(),
            instances: Vec::new(),
            meshes: Vec::new(),
            doubles: Vec::new(),
            level: Level::current(),
            stamp: FrameStamp::UNKNOWN,
            hierarchy: Arc::default(),
            numbers: Vec::new(),
        }
    }
}

impl FrameBvh {
    /// How rays enter an instance whose record says that they do so in double precision.
    pub(crate) fn double(&self, instance: u32) -> Option<&DoubleInverse> {
        let at = self.doubles.binary_search_by_key(&instance, |(number, _)| *number).ok()?;
        Some(&self.doubles[at].1)
    }
}

/// In short: how large it is.
impl fmt::Debug for MeshFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (bvh, triangles) = (&self.bvh, &self.triangles);
        f.debug_struct("MeshFrame").field("bvh", bvh).field("triangles", triangles).finish_non_exhaustive()
    }
}

/// In short: how large it is.
impl fmt::Debug for FrameBvh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (top, meshes) = (&self.top, self.meshes.len());
        f.debug_struct("FrameBvh").field("top", top).field("meshes", &meshes).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_that_starts_again_leaves_out_what_no_frame_may_have() {
        let counter = AtomicU32::new(u32::MAX - 2);
        let numbers = [0; 4].map(|_| FrameStamp::next_of(&counter).0.get());
        assert_eq!(numbers, [u32::MAX - 2, u32::MAX - 1, 1, 2]);
    }

    #[test]
    fn stamps_given_out_on_many_threads_differ() {
        let given = || (0..1000).map(|_| FrameStamp::fresh().0.get()).collect::<Vec<_>>();
        let mut all: Vec<u32> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(given)).collect();
            threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
        });
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 4000);
    }
}
