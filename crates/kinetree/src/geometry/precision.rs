//! How exactly rays are tested against triangles.

/// A proved bound on the relative error of the distance of a watertight hit.
///
/// Nearly all distances are within a few roundings (2^-22). The bound is reached only at triangles
/// that the ray grazes, or that are very much larger than the distance to the hit.
pub(crate) const DISTANCE_ERROR: f32 = 1.0 / (1 << 14) as f32;

/// A hit whose distance is reported as `t` lies between `t * AT_LEAST` and `t * AT_MOST`: boxes
/// that a ray leaves before the one of its `t_min`, or enters after the other of its `t_max`, do
/// not matter.
pub(crate) const AT_LEAST: f32 = 1.0 - 2.0 * DISTANCE_ERROR;
pub(crate) const AT_MOST: f32 = 1.0 + 2.0 * DISTANCE_ERROR;

/// How exactly rays are tested against the triangles of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Precision {
    /// Whether a ray meets a triangle is decided as exact arithmetic decides it, so that no ray
    /// slips between neighbouring triangles or meets what it passes by. `t` is within 2^-14 of
    /// itself of the exact distance, mostly within 2^-22, and never on the other side of the ray's
    /// origin. Answers do not depend on tree, processor or batch.
    ///
    /// Exact arithmetic is that of the ray in the space of the mesh: taking it there from the world
    /// rounds. Beyond coordinates of 1e18 numbers may overflow, and hits get lost.
    #[default]
    Watertight,
    /// The same test in single precision throughout, for rays whose hits need not be exact. A ray
    /// may slip through where it meets an edge or the face of a box within rounding, and there
    /// answers may depend on tree, processor and batch; distances to triangles that are much longer
    /// than wide may be off.
    Fast,
}
