//! How carefully the triangles of a mesh are tested.

/// How carefully the triangles of a mesh are tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Precision {
    /// No ray slips between neighbouring triangles, distances are right to a few roundings, and answers do not depend on tree, processor or batch.
    #[default]
    Watertight,
    /// The same test in single precision throughout, and boxes as they are: for rays that need not be right to the last hair. A ray may slip through where it
    /// meets an edge or the face of a box within rounding, and there answers may depend on tree, processor and batch; distances to triangles that
    /// are much longer than wide may be off.
    Fast,
}
