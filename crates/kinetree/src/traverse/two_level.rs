//! What a frame's rays are traced against: a tree over instances, each of which leads to the tree of a mesh.

use std::sync::Arc;

use crate::geometry::{Precision, Triangles};
use crate::simd::Level;
use crate::wide::{InstanceRecord, WideMesh, WideTop};

/// A mesh as it is in one frame, with its tree.
#[doc(alias = "BLAS")]
#[derive(Debug, Clone, Default)]
pub struct Posed {
    /// Over the triangles, object space.
    pub bvh: WideMesh,
    /// Object space.
    pub triangles: Triangles,
    /// One per vertex, or none at all.
    pub normals: Vec<[f32; 3]>,
    /// How carefully triangles are tested.
    pub precision: Precision,
}

/// A frame, as walks see it.
#[doc(alias = "TLAS")]
#[derive(Debug, Clone)]
pub struct TwoLevel {
    /// Over the instances, world space.
    pub top: WideTop,
    /// What the top level leads to.
    pub instances: Vec<InstanceRecord>,
    /// What the instances lead to.
    pub meshes: Vec<Arc<Posed>>,
    /// What walks are compiled for.
    pub level: Level,
}

impl Default for TwoLevel {
    fn default() -> Self {
        Self { top: WideTop::default(), instances: Vec::new(), meshes: Vec::new(), level: Level::current() }
    }
}
