//! What a frame's rays are traced against: a tree over instances, each of which leads to the tree of a mesh.

use std::sync::Arc;

use crate::geometry::inverse::DoubleInverse;
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
    /// How rays enter the instances that are entered in double precision, in the order of their numbers.
    pub(crate) doubles: Vec<(u32, DoubleInverse)>,
    /// What walks are compiled for.
    pub level: Level,
}

impl Default for TwoLevel {
    fn default() -> Self {
        Self {
            top: WideTop::default(),
            instances: Vec::new(),
            meshes: Vec::new(),
            doubles: Vec::new(),
            level: Level::current(),
        }
    }
}

impl TwoLevel {
    /// How rays enter an instance whose record says that they do so in double precision.
    pub(crate) fn double(&self, instance: u32) -> Option<&DoubleInverse> {
        let at = self.doubles.binary_search_by_key(&instance, |(number, _)| *number).ok()?;
        Some(&self.doubles[at].1)
    }
}
