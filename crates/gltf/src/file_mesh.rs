//! The meshes of a file that are shown.

use std::collections::HashMap;
use std::sync::Arc;

use kinetree::Mesh;
use kinetree_world::Surface;

use crate::error::Problem;
use crate::geometry::Geometry;
use crate::input::Input;
use crate::material::Materials;
use crate::notes::Notes;

/// A mesh of the file that is shown.
pub(crate) struct FileMesh {
    pub(crate) geometry: Geometry,
    pub(crate) name: Option<Arc<str>>,
    /// Index into [`MaterialSet::surfaces`].
    pub(crate) surface: u32,
    pub(crate) is_opaque: bool,
    /// The one without skin and morph targets, which all nodes that do not deform it share.
    pub(crate) undeformed: Option<u32>,
    /// By whether it can be skinned and morphed: what clones are taken of.
    pub(crate) models: HashMap<(bool, bool), Mesh>,
}

/// Reads every mesh that is shown, in the order of the file, and its surface.
pub(crate) fn read_meshes(
    input: &Input<'_>,
    materials: &mut Materials<'_>,
    notes: &mut Notes,
) -> Result<(Vec<Option<FileMesh>>, Vec<Surface>), Problem> {
    let document = input.document;
    let mut is_shown = vec![false; document.root.meshes.len()];
    for (index, node) in input.nodes() {
        if let Some(mesh) = node.mesh {
            document.get(mesh, "mesh", &document.node_item(index))?;
            is_shown[mesh.value()] = true;
        }
    }
    let (mut meshes, mut surfaces) = (Vec::new(), Vec::new());
    for (index, is_shown) in is_shown.into_iter().enumerate() {
        let geometry = if is_shown { input.meshes.read(index, materials, notes)? } else { None };
        meshes.push(geometry.map(|mut geometry| {
            let surface = std::mem::take(&mut geometry.surface);
            let is_opaque = !has_holes(&surface, materials);
            surfaces.push(surface);
            let surface = surfaces.len() as u32 - 1;
            let name = document.root.meshes[index].name.as_deref().map(Arc::from);
            FileMesh { geometry, name, surface, is_opaque, undeformed: None, models: HashMap::new() }
        }));
    }
    Ok((meshes, surfaces))
}

/// Whether a ray can pass through a triangle because of its alpha: only then are filters needed.
fn has_holes(surface: &Surface, materials: &Materials<'_>) -> bool {
    let vertex_alpha = surface.colors.iter().fold(1.0_f32, |least, color| least.min(color[3]));
    surface.parts.iter().any(|part| materials.has_holes(part.material, vertex_alpha))
}
