//! From a parsed file to what can be inserted into scenes: which node shows what.

use std::collections::HashMap;
use std::sync::Arc;

use kinetree::{Mesh, Motion};
use kinetree_world::{Camera, Light, MaterialSet};

use crate::channels::PerClip;
use crate::contents::{Contents, InstanceSource, MeshSource};
use crate::deformation::{Deformation, Skins, deformations};
use crate::error::{Item, Problem};
use crate::file_mesh::{FileMesh, read_meshes};
use crate::input::Input;
use crate::json::Index;
use crate::keys::Keys;
use crate::material::Materials;
use crate::mesh::Meshes;
use crate::notes::Notes;
use crate::rig::{AnimatedNode, DeformedMesh, Rig, Skinned};
use crate::skeleton::{Skeleton, SkeletonPose};
use crate::transform::Local;
use crate::{cameras, instancing, lights};

/// A deformation that depends on the animation only through its skin: nodes with the same one share
/// a mesh.
#[derive(PartialEq, Eq, Hash)]
struct SharedDeformation {
    mesh: usize,
    skin: Option<usize>,
    /// The bits of the weights.
    weights: Vec<u32>,
    is_mirrored: bool,
    /// The node, where the animation may decide whether it mirrors.
    scaled: Option<usize>,
}

struct Assembly<'a> {
    input: Input<'a>,
    file_meshes: Vec<Option<FileMesh>>,
    skeleton: Skeleton,
    skeleton_at_rest: SkeletonPose,
    deformed: Vec<DeformedMesh>,
    /// To meshes of the contents.
    shared: HashMap<SharedDeformation, u32>,
    /// For every node whether an animation changes its scale or that of an ancestor.
    scaled: Vec<bool>,
    /// By mesh of the file, the motion of the one that is not deformed.
    motions: Vec<Motion>,
    meshes: Vec<MeshSource>,
    instances: Vec<InstanceSource>,
}

/// Puts together what a file inserts into a scene.
pub(crate) fn assemble(input: Input<'_>, mut materials: Materials<'_>, notes: &mut Notes) -> Result<Contents, Problem> {
    let (document, hierarchy) = (input.document, input.hierarchy);
    let skeleton = Skeleton::new(document, hierarchy)?;
    let (file_meshes, surfaces) = read_meshes(&input, &mut materials, notes)?;
    let skins = Skins::read(&input, &skeleton)?;
    let deformations = deformations(&input, &file_meshes, &skins, notes)?;
    let motions = motions(&input, &deformations);
    let scaled = hierarchy.below(input.animations.scaled());
    let instance_count = input.nodes().filter(|(_, node)| node.mesh.is_some()).count();
    let mut assembly = Assembly {
        skeleton_at_rest: SkeletonPose::at_rest(&skeleton),
        input,
        file_meshes,
        skeleton,
        deformed: Vec::new(),
        shared: HashMap::new(),
        scaled,
        motions,
        meshes: Vec::new(),
        instances: Vec::with_capacity(instance_count),
    };
    let (lights, cameras, is_needed) = assembly.add_nodes(deformations, notes)?;
    let Assembly { input, skeleton, deformed, meshes, instances, .. } = assembly;
    let nodes = input.animations.nodes.into_iter().map(|(node, channels)| AnimatedNode {
        node,
        bone: skeleton.bone(node),
        rest: Local::of(&document.root.nodes[node]),
        channels,
    });
    let nodes = nodes.filter(|animated| hierarchy.in_scene[animated.node] || animated.bone.is_some()).collect();
    let rig = Arc::new(Rig { clips: input.clips, nodes, skeleton, skins: skins.all, deformed });
    let (materials, textures) = materials.into_parts();
    let material_set = Arc::new(MaterialSet { materials, textures, surfaces });
    Ok(Contents { meshes, instances, lights, cameras, is_needed, rig, material_set })
}

/// A mesh that is placed by any animated node is rigid, by mesh of the file.
fn motions(input: &Input<'_>, deformations: &HashMap<usize, Deformation>) -> Vec<Motion> {
    let moves = input.hierarchy.below(input.animations.nodes.keys().copied());
    let mut motions = vec![input.unanimated; input.document.root.meshes.len()];
    for (_, node) in input.nodes().filter(|&(index, _)| moves[index] && !deformations.contains_key(&index)) {
        if let Some(mesh) = node.mesh {
            motions[mesh.value()] = Motion::Rigid;
        }
    }
    motions
}

type LightsAndCameras = (Vec<(usize, Light)>, Vec<(usize, String, Camera)>, Vec<bool>);

impl Assembly<'_> {
    fn add_nodes(
        &mut self,
        mut deformations: HashMap<usize, Deformation>,
        notes: &mut Notes,
    ) -> Result<LightsAndCameras, Problem> {
        let (document, hierarchy) = (self.input.document, self.input.hierarchy);
        let mut has_content = vec![false; hierarchy.len()];
        for (index, node) in self.input.nodes() {
            has_content[index] = node.mesh.is_some() || node.camera.is_some() || node.light().is_some();
        }
        let has_content = hierarchy.above(has_content);
        let mut is_needed = vec![false; hierarchy.len()];
        let (mut lights, mut cameras) = (Vec::new(), Vec::new());
        for (index, node) in self.input.nodes().filter(|&(index, _)| has_content[index]) {
            let item = document.node_item(index);
            let light = lights::light_of(document, node, &item, notes)?;
            let camera = cameras::camera_of(document, node, &item, notes)?;
            is_needed[index] = light.is_some()
                || camera.is_some()
                || node.instancing().is_some()
                || self.input.animations.nodes.contains_key(&index)
                || node.children().any(|child| has_content[child.value()]);
            lights.extend(light.map(|light| (index, light)));
            cameras.extend(camera.map(|(name, camera)| (index, name, camera)));
            if let Some(mesh) = node.mesh.map(Index::value).filter(|&mesh| self.file_meshes[mesh].is_some()) {
                self.add_instances(mesh, index, deformations.remove(&index), notes)?;
            }
        }
        Ok((lights, cameras, is_needed))
    }

    /// Adds the instances of the mesh of a node: one, or as many as the node has.
    fn add_instances(
        &mut self,
        mesh: usize,
        node: usize,
        deformation: Option<Deformation>,
        notes: &mut Notes,
    ) -> Result<(), Problem> {
        let item = self.input.document.node_item(node);
        let is_skinned = deformation.as_ref().is_some_and(|deformation| deformation.skin.is_some());
        let mesh = match deformation {
            None => self.undeformed(mesh)?,
            Some(deformation) => self.deformed(node, mesh, deformation)?,
        };
        let placements = match self.input.document.root.nodes[node].instancing() {
            Some(instancing) if !is_skinned => {
                let Meshes { accessors, budget, .. } = self.input.meshes;
                let placements = instancing::placements(instancing, accessors, budget, &item)?;
                placements.into_iter().map(|placement| Some(Box::new(placement))).collect()
            }
            Some(_) => {
                notes.ignored("instancing of a skinned mesh", "it stands where its joints are", Some(&item));
                vec![None]
            }
            None => vec![None],
        };
        let instance = |node_from_instance| InstanceSource { node: node as u32, mesh, node_from_instance };
        self.instances.extend(placements.into_iter().map(instance));
        Ok(())
    }

    /// The mesh that nodes share which do not deform it.
    fn undeformed(&mut self, index: usize) -> Result<u32, Problem> {
        let item = self.input.document.mesh_item(index);
        let file_mesh = self.file_meshes[index].as_mut().expect("only meshes with triangles are added");
        if let Some(mesh) = file_mesh.undeformed {
            return Ok(mesh);
        }
        let mesh = file_mesh.geometry.mesh(false, false).map_err(|error| refused(&item, error))?;
        file_mesh.undeformed = Some(self.meshes.len() as u32);
        Ok(self.add_mesh(index, mesh, self.motions[index], false))
    }

    /// The mesh of a node that deforms it, which others with the same deformation share.
    fn deformed(&mut self, node: usize, index: usize, deformation: Deformation) -> Result<u32, Problem> {
        let item = self.input.document.mesh_item(index);
        let Deformation { skin, weights } = deformation;
        let animated = self.input.animations.weights.remove(&node).filter(|_| !weights.is_empty());
        let node_bone = self.skeleton.bone(node).filter(|_| skin.is_some());
        let shared = animated.is_none().then(|| SharedDeformation {
            mesh: index,
            skin,
            weights: weights.iter().map(|weight| weight.to_bits()).collect(),
            is_mirrored: node_bone.is_some_and(|bone| self.skeleton_at_rest.is_mirrored(bone)),
            scaled: Some(node).filter(|_| node_bone.is_some() && self.scaled[node]),
        });
        if let Some(&mesh) = shared.as_ref().and_then(|shared| self.shared.get(shared)) {
            return Ok(mesh);
        }
        let file_mesh = self.file_meshes[index].as_mut().expect("only meshes with triangles are added");
        self.input.meshes.budget.spend_numbers(file_mesh.geometry.numbers(), &item)?;
        let kind = (skin.is_some(), !weights.is_empty());
        let model = match file_mesh.models.get(&kind) {
            Some(model) => model.clone(),
            None => {
                let model = file_mesh.geometry.mesh(kind.0, kind.1).map_err(|error| refused(&item, error))?;
                file_mesh.models.insert(kind, model.clone());
                model
            }
        };
        let mesh = self.add_mesh(index, model, Motion::Deforming, skin.is_some());
        if let Some(shared) = shared {
            self.shared.insert(shared, mesh);
        }
        let skinned = skin.zip(node_bone).map(|(skin, node_bone)| Skinned { skin, node_bone });
        let weights_of_clips: PerClip<Keys> = animated.unwrap_or_default();
        self.deformed.push(DeformedMesh {
            mesh: mesh as usize,
            skinned,
            rest_weights: weights,
            weights: weights_of_clips,
        });
        Ok(mesh)
    }

    fn add_mesh(&mut self, index: usize, mesh: Mesh, motion: Motion, is_skinned: bool) -> u32 {
        let file_mesh = self.file_meshes[index].as_ref().expect("only meshes with triangles are added");
        let FileMesh { surface, is_opaque, .. } = *file_mesh;
        let name = file_mesh.name.clone();
        self.meshes.push(MeshSource { mesh, motion, index, name, surface, is_opaque, is_skinned });
        self.meshes.len() as u32 - 1
    }
}

fn refused(item: &Item, error: kinetree::MeshError) -> Problem {
    Problem::Refused { item: item.clone(), error: error.into() }
}
