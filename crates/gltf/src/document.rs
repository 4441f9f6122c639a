//! A parsed file, and access to its items by index.

use crate::error::{Item, Problem, Quoted};
use crate::extensions;
use crate::json::{Element, Index, Mesh, Primitive, Root};
use crate::notes::Notes;

/// A parsed file.
pub(crate) struct Document {
    pub(crate) root: Root,
    /// Of each mesh, as [`Document::target_count`] gives it.
    target_counts: Vec<u32>,
}

impl Document {
    pub(crate) fn parse(text: &[u8], notes: &mut Notes) -> Result<Self, Problem> {
        let broken = |error: serde_json::Error| Problem::Json(Quoted::bare(&error.to_string()));
        let root: Root = serde_json::from_slice(text).map_err(broken)?;
        if root.asset.version.split('.').next() != Some("2") {
            return Err(Problem::Json(Quoted::bare(&format!("its version is {:?}", root.asset.version))));
        }
        extensions::note_ignored(&root, notes)?;
        let target_counts = root.meshes.iter().map(target_count).collect();
        Ok(Self { root, target_counts })
    }

    /// The item at an index that `from` has.
    pub(crate) fn get<T: Element>(&self, index: Index<T>, kind: &'static str, from: &Item) -> Result<&T, Problem> {
        let all = T::all(&self.root);
        let missing = || Problem::NoSuch { from: from.clone(), kind, index: index.value(), count: all.len() };
        all.get(index.value()).ok_or_else(missing)
    }

    /// How many morph targets a mesh has: as many as that primitive which has most, whether or not
    /// it can be shown. Targets, weights and key frames all go by this count.
    pub(crate) fn target_count(&self, mesh: usize) -> usize {
        self.target_counts.get(mesh).map_or(0, |&count| count as usize)
    }

    pub(crate) fn node_item(&self, index: usize) -> Item {
        Item::named("node", index, self.root.nodes.get(index).and_then(|node| node.name.as_deref()))
    }

    pub(crate) fn mesh_item(&self, index: usize) -> Item {
        Item::named("mesh", index, self.root.meshes.get(index).and_then(|mesh| mesh.name.as_deref()))
    }

    pub(crate) fn material_item(&self, index: usize) -> Item {
        Item::named("material", index, self.root.materials.get(index).and_then(|material| material.name.as_deref()))
    }

    pub(crate) fn animation_item(&self, index: usize) -> Item {
        Item::named("animation", index, self.root.animations.get(index).and_then(|animation| animation.name.as_deref()))
    }
}

fn target_count(mesh: &Mesh) -> u32 {
    let of_primitive = |primitive: &Primitive| primitive.targets.as_ref().map_or(0, Vec::len);
    mesh.primitives.iter().map(of_primitive).max().unwrap_or(0) as u32
}
