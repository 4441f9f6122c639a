//! What a commit does with a mesh, and why, as reports say it.

use std::fmt;

/// What a commit did with a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Nothing.
    Kept,
    /// Its first tree was built.
    Built,
    /// A tree that was built before, and handed over with the mesh, was taken instead of building
    /// one.
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
    /// Only normals changed, which leaves positions and tree as they are.
    NormalsChanged,
    /// The mesh is new.
    New,
    /// The same triangles moved.
    PositionsMoved,
    /// Other triangles.
    TrianglesChanged,
    /// The triangles moved, and the mesh was announced as one that is rebuilt, or as one whose
    /// triangles never move.
    NotMadeForRefit,
    /// After a refit, rays would have been too much more work than when the tree was good.
    Drifted,
    /// A tree that was built to compare with the refitted one was better, though the refitted one
    /// was not known to have drifted: it had been built over a pose that hides all drift.
    BetterTreeFound,
    /// The caller asked for it: [`Scene::rebuild`](crate::Scene::rebuild).
    Requested,
    /// A pose put vertices beyond all numbers; they stay where they were.
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
            Self::NormalsChanged => "normals changed",
            Self::New => "new",
            Self::PositionsMoved => "positions moved",
            Self::TrianglesChanged => "triangles changed",
            Self::NotMadeForRefit => "not made for refit",
            Self::Drifted => "drifted",
            Self::BetterTreeFound => "better tree found",
            Self::Requested => "requested",
            Self::PoseNotFinite => "pose not finite",
        })
    }
}
