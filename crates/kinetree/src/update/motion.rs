//! How a mesh is going to move, as far as its owner knows.

/// A promise about use, which picks how a mesh is built and kept. What really happens in a frame is decided by the plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Motion {
    /// Scenery: built once, as well as can be.
    Static,
    /// Moves as a whole: a car's body, a wheel. Its tree is never touched; rays are transformed instead.
    Rigid,
    /// The same triangles in other places: trees in the wind, cloth, skinned characters. Refitted, and rebuilt when it has drifted too far.
    Deforming,
    /// Triangles come and go: smoke, shards. Rebuilt, as fast as can be.
    Rebuilt,
}
