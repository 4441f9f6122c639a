//! The scene that is built and traced: one mesh with one instance.

use kinetree::{Affine, Mesh, MeshId, Motion, Scene};

use crate::failure::Failure;

/// A scene with this mesh and one instance of it.
pub(super) fn scene_of(mesh: Mesh, motion: Motion) -> Result<(Scene, MeshId), Failure> {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh, motion)?;
    let root = scene.root();
    scene.add_instance(root, mesh, Affine::IDENTITY)?;
    Ok((scene, mesh))
}
