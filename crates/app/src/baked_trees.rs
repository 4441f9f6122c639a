//! Reads files of baked trees, and hands the trees to the meshes of a scene.

use std::fs;
use std::path::{Path, PathBuf};

use kinetree::{Motion, Scene, TreeFile};

use crate::failure::Failure;
use crate::figures;
use crate::trees::name_of;

/// Whether `kinetree bake` builds trees for meshes that move in this way: those whose triangles
/// keep their positions in object space.
pub(crate) fn is_baked(motion: Motion) -> bool {
    matches!(motion, Motion::Static | Motion::Rigid)
}

/// A file of trees that has been read, and its path for messages.
#[derive(Debug)]
pub(crate) struct BakedTrees {
    path: PathBuf,
    trees: TreeFile<'static>,
}

impl BakedTrees {
    /// Reads a file. Every tree in it must be undamaged, also those that no mesh of the scene
    /// needs.
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        let failure = |problem: String| Failure::work(format!("{}: {problem}", path.display()));
        let bytes = fs::read(path).map_err(|error| failure(format!("cannot be read: {error}")))?;
        let trees = TreeFile::read(bytes).map_err(|error| failure(error.to_string()))?;
        Ok(Self { path: path.to_owned(), trees })
    }

    /// Hands its tree to each static or rigid mesh of a scene. A mesh without a tree is an error.
    pub(crate) fn hand_to(&self, scene: &mut Scene, name: &str, scene_path: Option<&Path>) -> Result<(), Failure> {
        let meshes: Vec<_> = scene.meshes().collect();
        for (number, id) in meshes.into_iter().enumerate() {
            let (Ok(mesh), Ok(motion)) = (scene.mesh(id), scene.motion(id)) else { continue };
            if !is_baked(motion) {
                continue;
            }
            let triangles = figures::of(mesh.triangles().len() as u64, "triangle", "triangles");
            let described = format!("mesh {number} of {name} ({}, {triangles})", name_of(motion));
            let problem = match self.trees.tree_of(mesh) {
                Some(tree) => match scene.set_tree(id, tree) {
                    Ok(()) => continue,
                    Err(error) => format!("the tree for {described} cannot be used: {error}"),
                },
                None => format!("there is no tree for {described}, as it is now"),
            };
            let scene = scene_path.map_or_else(String::new, |path| format!(" {}", path.display()));
            let file = self.path.display();
            return Err(Failure::work(format!(
                "{file}: {problem}: make the file again with `kinetree bake{scene} --out {file}`"
            )));
        }
        Ok(())
    }
}
