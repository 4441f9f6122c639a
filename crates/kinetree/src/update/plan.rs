//! Keep, refit or rebuild? Decided from counts alone, so that the same edits give the same trees.

use std::fmt;

use super::Motion;

/// A refitted tree whose rays have become dearer than this, as a ratio to the build, is rebuilt.
///
/// A choice, not a measurement: well above what swaying brings and takes away again, so that such meshes are not rebuilt for nothing.
const REBUILD_ABOVE: f32 = 1.5;

/// What happened to a mesh since the last commit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Edit {
    Nothing,
    Positions,
    Triangles,
}

/// All that the decision rests on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) motion: Motion,
    pub(crate) edit: Edit,
    pub(crate) has_tree: bool,
}

/// What a commit did with a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Nothing.
    Kept,
    /// Its first tree was built.
    Built,
    /// A tree that was built before, and handed over with the mesh, was taken instead of building one.
    Loaded,
    /// Boxes were recomputed in the tree that was there.
    Refitted,
    /// A new tree replaced the old one.
    Rebuilt,
}

/// Why it did so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// No edit.
    NothingChanged,
    /// The mesh is new.
    New,
    /// The same triangles moved.
    PositionsMoved,
    /// Other triangles.
    TrianglesChanged,
    /// The triangles moved, and the mesh was announced as one that is rebuilt, or as one whose triangles never move.
    NotMadeForRefit,
    /// After a refit, rays would have become too dear.
    Drifted,
    /// A pose put vertices beyond all numbers; the mesh stays as it was.
    PoseNotFinite,
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Kept => "kept",
            Self::Built => "built",
            Self::Loaded => "loaded",
            Self::Refitted => "refitted",
            Self::Rebuilt => "rebuilt",
        })
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::NothingChanged => "nothing changed",
            Self::New => "new",
            Self::PositionsMoved => "positions moved",
            Self::TrianglesChanged => "triangles changed",
            Self::NotMadeForRefit => "not made for refit",
            Self::Drifted => "drifted",
            Self::PoseNotFinite => "pose not finite",
        })
    }
}

/// What to do, before anything is measured.
pub(crate) fn decide(candidate: &Candidate) -> (Action, Reason) {
    match (candidate.edit, candidate.motion) {
        _ if !candidate.has_tree => (Action::Built, Reason::New),
        (Edit::Nothing, _) => (Action::Kept, Reason::NothingChanged),
        (Edit::Triangles, _) => (Action::Rebuilt, Reason::TrianglesChanged),
        (Edit::Positions, Motion::Deforming) => (Action::Refitted, Reason::PositionsMoved),
        (Edit::Positions, _) => (Action::Rebuilt, Reason::NotMadeForRefit),
    }
}

/// Whether a refitted tree with this drift has to be replaced.
pub(crate) fn has_rotted(drift: f32) -> bool {
    drift > REBUILD_ABOVE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_bends_is_refitted_and_what_changes_is_rebuilt() {
        let decide = |motion, edit, has_tree| decide(&Candidate { motion, edit, has_tree }).0;
        for motion in [Motion::Static, Motion::Rigid, Motion::Deforming, Motion::Rebuilt] {
            assert_eq!(decide(motion, Edit::Nothing, true), Action::Kept);
            assert_eq!(decide(motion, Edit::Nothing, false), Action::Built);
            assert_eq!(decide(motion, Edit::Positions, false), Action::Built);
            assert_eq!(decide(motion, Edit::Triangles, true), Action::Rebuilt);
        }
        assert_eq!(decide(Motion::Deforming, Edit::Positions, true), Action::Refitted);
        assert_eq!(decide(Motion::Rebuilt, Edit::Positions, true), Action::Rebuilt);
        assert_eq!(decide(Motion::Static, Edit::Positions, true), Action::Rebuilt);
    }

    #[test]
    fn only_real_drift_counts_as_rot() {
        assert!(!has_rotted(1.0) && !has_rotted(1.3) && has_rotted(2.0) && !has_rotted(f32::NAN));
    }
}
