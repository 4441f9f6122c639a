//! What a file inserts into a scene.

use std::sync::Arc;

use kinetree::{Affine, Mesh, Motion};
use kinetree_world::{Camera, Light, MaterialSet};

use crate::rig::Rig;

/// What a file inserts into a scene, in the order in which it is inserted. Nodes are those of the
/// file, by index.
pub(crate) struct Contents {
    pub(crate) meshes: Vec<MeshSource>,
    pub(crate) instances: Vec<InstanceSource>,
    /// By node, in the space of the node.
    pub(crate) lights: Vec<(usize, Light)>,
    /// By node: the name, and the camera in the space of the node.
    pub(crate) cameras: Vec<(usize, String, Camera)>,
    /// For every node whether it has more than a mesh that stands still: the transform of any other
    /// node can be that of its instance.
    pub(crate) is_needed: Vec<bool>,
    pub(crate) rig: Arc<Rig>,
    pub(crate) material_set: Arc<MaterialSet>,
}

/// A mesh to be inserted.
pub(crate) struct MeshSource {
    pub(crate) mesh: Mesh,
    pub(crate) motion: Motion,
    /// In the file. Several may be made of one mesh of the file.
    pub(crate) index: usize,
    pub(crate) name: Option<Arc<str>>,
    /// Index into [`MaterialSet::surfaces`].
    pub(crate) surface: u32,
    pub(crate) is_opaque: bool,
    /// Whether it stands where its joints are, and not at its node.
    pub(crate) is_skinned: bool,
}

/// An instance to be inserted.
pub(crate) struct InstanceSource {
    pub(crate) node: u32,
    /// Among the meshes of the contents.
    pub(crate) mesh: u32,
    /// `None` for the identity, as in nearly all files.
    pub(crate) node_from_instance: Option<Box<Affine>>,
}

const _: () = assert!(size_of::<InstanceSource>() <= 16, "an instance takes more memory than its text can justify");
