//! Errors of edits. After an error, the scene is as it was.

use thiserror::Error;

use crate::wide::TreeFileError;

/// What is wrong with a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} uses vertex {index}, but there are {vertices} vertices")]
    IndexOutOfRange {
        /// The first such triangle.
        triangle: usize,
        /// The vertex it names.
        index: u32,
        /// How many there are.
        vertices: usize,
    },
    /// A list of indices whose length is not a multiple of three.
    #[error("{count} indices do not make whole triangles")]
    NotWholeTriangles {
        /// How many indices.
        count: usize,
    },
    /// A number that is infinite or NaN.
    #[error("vertex {at} has a number that is not finite")]
    NonFinite {
        /// The first such vertex.
        at: usize,
    },
    /// A skin weight below zero.
    #[error("vertex {at} has a negative skin weight")]
    NegativeWeight {
        /// The first such vertex.
        at: usize,
    },
    /// One entry per vertex was expected.
    #[error("there are {expected} vertices, but {found} {what}")]
    CountDiffers {
        /// What was counted.
        what: &'static str,
        /// Vertices.
        expected: usize,
        /// Entries.
        found: usize,
    },
    /// More than 2^27 triangles or 2^32 - 1 vertices.
    #[error("{count} {what} are too many")]
    TooMany {
        /// What was counted.
        what: &'static str,
        /// How many.
        count: usize,
    },
    /// Vertices that lie beyond the end of the buffer.
    #[error("a stride of {stride} bytes from byte {offset} on does not give {count} positions in {bytes} bytes")]
    StrideOutOfRange {
        /// Bytes from one vertex to the next.
        stride: usize,
        /// Byte of the first vertex.
        offset: usize,
        /// How many vertices.
        count: usize,
        /// How many bytes there are.
        bytes: usize,
    },
}

/// A hit was given to a snapshot of another frame, where its numbers mean other things.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the hit is of another frame; only snapshots of the frame that was traced resolve it")]
pub struct ForeignHit;

/// Why a scene refused an edit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum EditError {
    /// Something is wrong with the mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The bytes are not a tree of the mesh.
    #[error(transparent)]
    Tree(#[from] TreeFileError),
    /// A tree was handed over for a mesh that has one already.
    #[error("the mesh has its tree already; trees from files are handed over before the first commit")]
    HasTree,
    /// The mesh, node or instance of the handle has been removed.
    #[error("the handle is stale: what it named has been removed")]
    StaleHandle,
    /// The handle belongs to another scene.
    #[error("the handle belongs to another scene")]
    OtherScene,
    /// Positions can only be replaced by as many.
    #[error("the mesh has {expected} vertices, but {found} were given; other triangles go through set_triangles")]
    PositionCountChanged {
        /// Vertices of the mesh.
        expected: usize,
        /// Positions or normals given.
        found: usize,
    },
    /// A transform or a pose with a number that is infinite or NaN.
    #[error("number {at} of the transform or pose is not finite")]
    NonFinite {
        /// The first such joint, weight, vertex; 0 for a transform.
        at: usize,
    },
    /// The mesh still has instances.
    #[error("the mesh has {instances} instances; remove those first")]
    MeshInUse {
        /// How many.
        instances: usize,
    },
    /// The root cannot be removed or moved.
    #[error("the root stays where it is; place its children")]
    Root,
    /// A pose for other morph targets or joints than the mesh has.
    #[error("the mesh has {expected} {what}, but the pose has {found}")]
    PoseDiffers {
        /// What was counted.
        what: &'static str,
        /// How many the mesh has.
        expected: usize,
        /// How many the pose has.
        found: usize,
    },
    /// More than 2^27 instances or 2^32 - 1 handles.
    #[error("the scene is full")]
    SceneFull,
}
