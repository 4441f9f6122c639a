//! How a mesh is going to move, as far as its owner knows.

/// A promise about use, which picks how a mesh is built and kept. What really happens in a frame is
/// decided by the plan.
///
/// | motion | its trees are built with | a frame in which it moves costs |
/// |---|---|---|
/// | `Static` | [`Balanced`], once, by the first commit | a rebuild: it is not meant to move |
/// | `Rigid` | [`Fast`], once, by the first commit | the placement of its instances |
/// | `Deforming` | [`Fast`] | a refit; a rebuild when it has drifted too far |
/// | `Dynamic` | [`Fastest`] | a rebuild |
///
/// [`Mesh::with_quality`] overrides the quality of a mesh. No motion builds with [`Best`], which takes
/// several times as long as [`Balanced`]: such trees are baked, once, before the game runs
/// ([`Mesh::bake`], `kinetree bake`), and handed over with meshes that are `Static` or `Rigid`
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
pub enum Motion {
    /// Scenery that stays where it is: built once, as well as a level's loading time allows
    /// (`Balanced`). What shall be better still is baked beforehand.
    Static,
    /// Moves as a whole: a car's body, a wheel. Its tree is built once and stays; rays are
    /// transformed instead.
    Rigid,
    /// The same triangles in other places: trees in the wind, cloth, skinned characters. Refitted,
    /// and rebuilt when it has drifted too far.
    Deforming,
    /// Triangles come and go: smoke, shards. Rebuilt whenever it changes, by the fastest builder.
    Dynamic,
}
