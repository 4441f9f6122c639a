//! Joints and skins: where the joints are, and what that does to the meshes that hang on them.

use std::collections::HashMap;

use kinetree::Affine;

use crate::accessor::Accessors;
use crate::document::Document;
use crate::error::{Item, Problem};
use crate::json::{self, ElementType, Index};
use crate::nodes::Hierarchy;

/// The joints of all skins, and the nodes above them. Always: a bone stands after its parent.
#[derive(Default)]
pub(crate) struct Bones {
    parent: Vec<Option<usize>>,
    parent_from_bone: Vec<Affine>,
    world_from_bone: Vec<Affine>,
    /// From a node of the file to its bone.
    of_node: HashMap<usize, usize>,
    moved: bool,
}

/// What moves the vertices of the meshes that it is given to.
pub(crate) struct Skin {
    /// Bones.
    joints: Vec<u32>,
    joint_from_mesh: Vec<Affine>,
    /// From the mesh at rest to the world, by joint.
    matrices: Vec<Affine>,
    version: u64,
}

impl Bones {
    /// The bones for some nodes, in their rest state.
    pub(crate) fn new(hierarchy: &Hierarchy<'_>, in_use: Vec<bool>) -> Self {
        let needed = hierarchy.above(in_use);
        let mut bones = Self { moved: true, ..Self::default() };
        for node in hierarchy.parents_first().filter(|&node| needed[node]) {
            bones.of_node.insert(node, bones.parent.len());
            bones.parent.push(hierarchy.parent(node).map(|parent| bones.of_node[&parent]));
            bones.parent_from_bone.push(hierarchy.local(node).affine());
        }
        bones.world_from_bone = bones.parent_from_bone.clone();
        bones.resolve();
        bones
    }

    pub(crate) fn of_node(&self, node: usize) -> Option<usize> {
        self.of_node.get(&node).copied()
    }

    pub(crate) fn set_local(&mut self, bone: usize, parent_from_bone: Affine) {
        self.parent_from_bone[bone] = parent_from_bone;
        self.moved = true;
    }

    /// Computes the placement of all bones in the world, if any was set; returns whether it was.
    pub(crate) fn update(&mut self) -> bool {
        if !std::mem::take(&mut self.moved) {
            return false;
        }
        self.resolve();
        true
    }

    /// Whether what hangs on a bone is seen as in a mirror: the determinant of its placement in the
    /// world is negative.
    pub(crate) fn is_mirrored(&self, bone: usize) -> bool {
        // In double precision, the product of three small or large numbers keeps its sign.
        let world = &self.world_from_bone[bone];
        let [x, y, z] = [world.x_axis, world.y_axis, world.z_axis].map(|axis| glam::Vec3::from(axis).as_dvec3());
        x.cross(y).dot(z) < 0.0
    }

    fn resolve(&mut self) {
        for bone in 0..self.parent.len() {
            let local = self.parent_from_bone[bone];
            self.world_from_bone[bone] = self.parent[bone].map_or(local, |parent| self.world_from_bone[parent] * local);
        }
    }
}

impl Skin {
    /// Reads a skin whose joints are among `bones`.
    pub(crate) fn read(
        document: &Document,
        index: Index<json::Skin>,
        bones: &Bones,
        accessors: &Accessors<'_>,
        from: &Item,
    ) -> Result<Self, Problem> {
        let skin = document.get(index, "skin", from)?;
        let item = Item::named("skin", index.value(), skin.name.as_deref());
        let mut joints = Vec::with_capacity(skin.joints.len());
        for &joint in &skin.joints {
            document.get(joint, "node", &item)?;
            let bone = bones.of_node(joint.value()).ok_or_else(|| item.invalid("has a joint that is no bone"))?;
            joints.push(bone as u32);
        }
        let joint_from_mesh = match skin.inverse_bind_matrices {
            None => vec![Affine::IDENTITY; joints.len()],
            Some(accessor) => {
                let matrices = accessors.floats::<16>(accessor, ElementType::Mat4, &item)?;
                if matrices.len() < joints.len() || !matrices.as_flattened().iter().all(|number| number.is_finite()) {
                    return Err(
                        item.invalid("has fewer inverse bind matrices than joints, or some that are not finite")
                    );
                }
                matrices.iter().take(joints.len()).map(affine).collect()
            }
        };
        let matrices = joint_from_mesh.clone();
        Ok(Self { joints, joint_from_mesh, matrices, version: 0 })
    }

    pub(crate) fn joint_count(&self) -> usize {
        self.joints.len()
    }

    pub(crate) fn matrices(&self) -> &[Affine] {
        &self.matrices
    }

    /// Changes with the matrices.
    pub(crate) fn version(&self) -> u64 {
        self.version
    }

    pub(crate) fn update(&mut self, bones: &Bones) {
        let mut changed = false;
        for ((matrix, &bone), &joint_from_mesh) in self.matrices.iter_mut().zip(&self.joints).zip(&self.joint_from_mesh)
        {
            let world_from_mesh = bones.world_from_bone[bone as usize] * joint_from_mesh;
            changed |= *matrix != world_from_mesh;
            *matrix = world_from_mesh;
        }
        self.version += u64::from(changed);
    }
}

/// Four columns of four, of which the last row is 0 0 0 1.
fn affine(m: &[f32; 16]) -> Affine {
    let column = |i: usize| [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
    Affine::from_columns(column(0), column(1), column(2), column(3))
}
