//! Joints and their ancestors, and where a pose puts them.

use std::collections::{HashMap, HashSet};

use kinetree::Affine;

use crate::document::Document;
use crate::error::{Item, Problem};
use crate::nodes::Hierarchy;
use crate::transform::Local;

/// The bones of a file: the joints of its skins, the nodes of skinned meshes, and the ancestors of
/// both. Always: a bone stands after its parent.
pub(crate) struct Skeleton {
    parents: Vec<Option<usize>>,
    /// At rest.
    parent_from_bone: Vec<Affine>,
    /// From a bone to its node in the file.
    nodes: Vec<usize>,
    /// From a node of the file to its bone.
    bones: HashMap<usize, usize>,
}

impl Skeleton {
    /// The bones that the skins of the scene need.
    ///
    /// # Errors
    /// A reference to a skin or a joint that is not there.
    pub(crate) fn new(document: &Document, hierarchy: &Hierarchy) -> Result<Self, Problem> {
        let needed = hierarchy.above(joints_and_skinned(document, hierarchy)?);
        let mut skeleton =
            Self { parents: Vec::new(), parent_from_bone: Vec::new(), nodes: Vec::new(), bones: HashMap::new() };
        for node in hierarchy.parents_first().filter(|&node| needed[node]) {
            skeleton.bones.insert(node, skeleton.nodes.len());
            skeleton.nodes.push(node);
            skeleton.parents.push(hierarchy.parent(node).map(|parent| skeleton.bones[&parent]));
            skeleton.parent_from_bone.push(Local::of(&document.root.nodes[node]).affine());
        }
        Ok(skeleton)
    }

    /// The bone of a node of the file.
    pub(crate) fn bone(&self, node: usize) -> Option<usize> {
        self.bones.get(&node).copied()
    }

    /// The node of a bone in the file.
    pub(crate) fn node(&self, bone: usize) -> usize {
        self.nodes[bone]
    }
}

/// For every node whether it is a joint of any skin of the scene, or has a skin.
fn joints_and_skinned(document: &Document, hierarchy: &Hierarchy) -> Result<Vec<bool>, Problem> {
    let mut seen = HashSet::new();
    let mut found = vec![false; hierarchy.len()];
    for (index, node) in document.root.nodes.iter().enumerate().filter(|&(index, _)| hierarchy.in_scene[index]) {
        let Some(skin) = node.skin else { continue };
        found[index] = true;
        if !seen.insert(skin.value()) {
            continue;
        }
        for &joint in &document.get(skin, "skin", &document.node_item(index))?.joints {
            document.get(joint, "node", &Item::new("skin", skin.value()))?;
            found[joint.value()] = true;
        }
    }
    Ok(found)
}

/// The transforms of all bones of a skeleton at one moment. "Root" is the space of the root nodes
/// of the file.
pub(crate) struct SkeletonPose {
    parent_from_bone: Vec<Affine>,
    root_from_bone: Vec<Affine>,
    /// Whether a bone was set since the last update.
    is_stale: bool,
}

impl SkeletonPose {
    pub(crate) fn at_rest(skeleton: &Skeleton) -> Self {
        let parent_from_bone = skeleton.parent_from_bone.clone();
        let mut pose = Self { root_from_bone: parent_from_bone.clone(), parent_from_bone, is_stale: true };
        pose.resolve(skeleton);
        pose
    }

    pub(crate) fn set_local(&mut self, bone: usize, parent_from_bone: Affine) {
        self.parent_from_bone[bone] = parent_from_bone;
        self.is_stale = true;
    }

    /// Computes where all bones are, if any was set since the last update, or if this is the first
    /// one; returns whether it did.
    pub(crate) fn update(&mut self, skeleton: &Skeleton) -> bool {
        if !std::mem::take(&mut self.is_stale) {
            return false;
        }
        self.resolve(skeleton);
        true
    }

    pub(crate) fn root_from_bone(&self, bone: usize) -> Affine {
        self.root_from_bone[bone]
    }

    /// Whether the transform of a bone mirrors: its determinant is negative.
    pub(crate) fn is_mirrored(&self, bone: usize) -> bool {
        // In double precision, the product of three small or large numbers keeps its sign.
        let root = &self.root_from_bone[bone];
        let [x, y, z] = [root.x_axis, root.y_axis, root.z_axis].map(|axis| glam::Vec3::from(axis).as_dvec3());
        x.cross(y).dot(z) < 0.0
    }

    fn resolve(&mut self, skeleton: &Skeleton) {
        for (bone, parent) in skeleton.parents.iter().enumerate() {
            let local = self.parent_from_bone[bone];
            self.root_from_bone[bone] = parent.map_or(local, |parent| self.root_from_bone[parent] * local);
        }
    }
}
