//! The actions of a commit on a mesh, with reasons, as reports list them.

use std::fmt;

/// What a commit did to a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Action {
    /// Nothing: the tree is the one of the previous frame.
    Kept,
    /// Its first tree was built.
    Built,
    /// The tree that came with the mesh, built earlier
    /// ([`Mesh::with_tree`](crate::Mesh::with_tree)), was used instead of a build.
    Loaded,
    /// The boxes of the existing tree were recomputed.
    Refitted,
    /// A new tree replaced the old one.
    Rebuilt,
}

/// The reason for an [`Action`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Reason {
    /// No edit.
    NothingChanged,
    /// Only normals changed, which leaves positions and tree as they are.
    NormalsChanged,
    /// The mesh is new.
    New,
    /// The same triangles moved.
    PositionsMoved,
    /// The triangles were replaced.
    TrianglesChanged,
    /// The triangles moved, but the mesh's [`Motion`](super::Motion) is not `Deforming`, so it is
    /// not refitted.
    NotMadeForRefit,
    /// The expected cost of rays through the refitted tree had risen too far above its baseline.
    Drifted,
    /// A new tree, built for comparison, was better than the refitted one although the estimate
    /// showed no drift: the refitted tree had been built over a pose that hides drift.
    BetterTreeFound,
    /// The caller asked for it: [`Scene::rebuild`](crate::Scene::rebuild).
    Requested,
    /// The mesh is to have a better tree than it was built with:
    /// [`Scene::set_quality`](crate::Scene::set_quality), or a motion that suggests it.
    QualityRaised,
    /// Only the precision changed, which leaves the tree as it is.
    PrecisionChanged,
    /// A pose made vertices infinite or NaN; the mesh keeps its previous positions.
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
            Self::QualityRaised => "quality raised",
            Self::PrecisionChanged => "precision changed",
            Self::PoseNotFinite => "pose not finite",
        })
    }
}
