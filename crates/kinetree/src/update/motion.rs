//! How the caller expects a mesh to move.

/// How a mesh is expected to move, which selects how its tree is built and updated. What each
/// commit does depends on the edits.
///
/// | motion | trees are built with | a frame in which it moves costs |
/// |---|---|---|
/// | `Static` | [`Balanced`], once, by the first commit | a rebuild: it is not meant to move |
/// | `Rigid` | [`Fast`], once, by the first commit | the placement of its instances |
/// | `Deforming` | [`Fast`] | a refit; a rebuild when it has drifted too far |
/// | `Dynamic` | [`Fastest`] | a rebuild |
///
/// [`Mesh::with_quality`] overrides the quality of a mesh. No motion builds with [`Best`], which
/// takes several times as long as [`Balanced`]: bake such trees once, before the game runs
/// ([`Mesh::bake`], `kinetree bake`), and pass them with meshes that are `Static` or `Rigid`
/// ([`Mesh::with_tree`]).
///
/// [`Fastest`]: crate::build::Quality::Fastest
/// [`Fast`]: crate::build::Quality::Fast
/// [`Balanced`]: crate::build::Quality::Balanced
/// [`Best`]: crate::build::Quality::Best
/// [`Mesh::with_quality`]: crate::Mesh::with_quality
/// [`Mesh::bake`]: crate::Mesh::bake
/// [`Mesh::with_tree`]: crate::Mesh::with_tree
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Motion {
    /// Scenery that does not move. Built once, at the quality for a level's loading time
    /// (`Balanced`). For a better tree, bake it.
    Static,
    /// Moves as a whole: a car's body, a wheel. Its tree is built once and kept; rays are
    /// transformed into its space.
    Rigid,
    /// The same triangles with new vertex positions: trees in the wind, cloth, skinned characters.
    /// Refitted, and rebuilt when the tree has drifted too far.
    Deforming,
    /// Triangles appear and disappear: smoke, shards. Rebuilt at every change, by the fastest
    /// builder.
    Dynamic,
}
