//! Which nodes deform their mesh, and how: by a skin, by morph targets, or by both.

use std::collections::HashMap;

use crate::error::Problem;
use crate::file_mesh::FileMesh;
use crate::input::Input;
use crate::json::{Index, Node};
use crate::notes::Notes;
use crate::skeleton::Skeleton;
use crate::skin::Skin;

/// How a node deforms its mesh.
pub(crate) struct Deformation {
    /// Among the skins that were read.
    pub(crate) skin: Option<usize>,
    /// At rest: one per morph target, or none if the mesh does not morph.
    pub(crate) weights: Vec<f32>,
}

/// The skins that deform meshes of the scene.
#[derive(Default)]
pub(crate) struct Skins {
    pub(crate) all: Vec<Skin>,
    /// From a skin of the file to its index in `all`.
    indices: HashMap<usize, usize>,
}

impl Skins {
    /// # Errors
    /// As [`Skin::read`].
    pub(crate) fn read(input: &Input<'_>, skeleton: &Skeleton) -> Result<Self, Problem> {
        let mut skins = Self::default();
        for (index, node) in input.nodes() {
            let Some(skin) = node.skin.filter(|_| node.mesh.is_some()) else { continue };
            if !skins.indices.contains_key(&skin.value()) {
                let item = input.document.node_item(index);
                let read = Skin::read(input.document, skin, skeleton, input.meshes.accessors, &item)?;
                skins.indices.insert(skin.value(), skins.all.len());
                skins.all.push(read);
            }
        }
        Ok(skins)
    }
}

/// The nodes that deform their mesh, and how.
///
/// # Errors
/// A mesh that follows joints that its skin does not have; weights that are not finite.
pub(crate) fn deformations(
    input: &Input<'_>,
    meshes: &[Option<FileMesh>],
    skins: &Skins,
    notes: &mut Notes,
) -> Result<HashMap<usize, Deformation>, Problem> {
    let mut deformations = HashMap::new();
    for (index, node) in input.nodes() {
        let Some(mesh) = node.mesh.map(Index::value) else { continue };
        let Some(FileMesh { geometry, .. }) = &meshes[mesh] else { continue };
        let item = input.document.node_item(index);
        let mut skin = node.skin.map(|skin| skins.indices[&skin.value()]);
        match geometry.highest_joint() {
            None if skin.take().is_some() => notes.add(|| format!("{item} has a skin, but its mesh has no joints")),
            Some(highest) => {
                let count = skin.map_or(usize::MAX, |skin| skins.all[skin].joints.len());
                if usize::from(highest) >= count {
                    let reason = format!("follows joint {highest} of a skin with {count} joints at {item}");
                    return Err(input.document.mesh_item(mesh).invalid(reason));
                }
            }
            None => {}
        }
        let weights = rest_weights(input, index, node, geometry.targets.len(), notes)?;
        let morphs = input.animations.weights.contains_key(&index) || weights.iter().any(|&weight| weight != 0.0);
        if skin.is_some() || (morphs && !weights.is_empty()) {
            deformations.insert(index, Deformation { skin, weights: if morphs { weights } else { Vec::new() } });
        }
    }
    Ok(deformations)
}

/// One weight per target: those of the node, or those of its mesh.
fn rest_weights(
    input: &Input<'_>,
    index: usize,
    node: &Node,
    targets: usize,
    notes: &mut Notes,
) -> Result<Vec<f32>, Problem> {
    let item = input.document.node_item(index);
    input.meshes.budget.spend_numbers(targets as u64, &item)?;
    let of_mesh = node.mesh.and_then(|mesh| input.document.root.meshes[mesh.value()].weights.as_ref());
    let given = node.weights.as_ref().or(of_mesh);
    let mut weights = given.map_or_else(|| vec![0.0; targets], |weights| weights.to_vec());
    if weights.len() != targets {
        notes.add(|| format!("{item} has {} weights for {targets} morph targets", weights.len()));
        weights.resize(targets, 0.0);
    }
    if !weights.iter().all(|weight| weight.is_finite()) {
        return Err(item.invalid("has morph weights that are not finite"));
    }
    Ok(weights)
}
