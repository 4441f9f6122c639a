//! What was edited of a mesh since the last commit.

use super::mesh::VertexNormals;
use super::pose::OwnedPose;

/// Edits that wait for the next commit.
#[derive(Debug)]
pub(super) struct MeshEdits {
    pub(super) geometry: GeometryEdit,
    /// Normals that were set.
    pub(super) normals: Option<VertexNormals>,
    /// Whether the caller asked for a new tree.
    pub(super) rebuild: bool,
    /// Whether the motion was set.
    pub(super) motion: bool,
}

/// What happened to vertices and triangles.
#[derive(Debug)]
pub(super) enum GeometryEdit {
    /// Nothing.
    None,
    /// The same triangles, with other vertices.
    Moved(Vertices),
    /// Other triangles: with their vertices as they were handed over, or with other ones.
    Replaced(Option<Vertices>),
}

/// Other vertices than those that a mesh has.
#[derive(Debug)]
pub(super) enum Vertices {
    /// Object space, one per vertex.
    Positions(Vec<[f32; 3]>),
    /// To be computed from the rest pose.
    Pose(OwnedPose),
}

impl MeshEdits {
    pub(super) const NONE: Self = Self { geometry: GeometryEdit::None, normals: None, rebuild: false, motion: false };

    /// Of a mesh that was just added.
    pub(super) const ADDED: Self = Self { geometry: GeometryEdit::Replaced(None), ..Self::NONE };
}

impl GeometryEdit {
    /// Sets other vertices. Gives those that were set before, which no commit will see.
    pub(super) fn set(&mut self, vertices: Vertices) -> Option<Vertices> {
        match self {
            Self::None => {
                *self = Self::Moved(vertices);
                None
            }
            Self::Moved(last) => Some(std::mem::replace(last, vertices)),
            Self::Replaced(last) => last.replace(vertices),
        }
    }

    pub(super) fn vertices(&self) -> Option<&Vertices> {
        match self {
            Self::None => None,
            Self::Moved(vertices) => Some(vertices),
            Self::Replaced(vertices) => vertices.as_ref(),
        }
    }

    /// Whether the triangles are other ones.
    pub(super) fn is_replaced(&self) -> bool {
        matches!(self, Self::Replaced(_))
    }

    pub(super) fn into_vertices(self) -> Option<Vertices> {
        match self {
            Self::None => None,
            Self::Moved(vertices) => Some(vertices),
            Self::Replaced(vertices) => vertices,
        }
    }
}
