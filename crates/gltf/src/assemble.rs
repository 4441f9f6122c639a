//! From a parsed file to a world: which node becomes what.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use kinetree::{Affine, EditError, Mesh, MeshId, Motion, NodeId, Scene};
use kinetree_world::{Animation, CameraSource, LightSource, MaterialSet, NoAnimation, Surface, World};

use crate::budget::Budget;
use crate::clip::Clip;
use crate::document::Document;
use crate::error::{Item, Problem};
use crate::json::Node;
use crate::material::Materials;
use crate::mesh::{Geometry, Meshes};
use crate::nodes::Hierarchy;
use crate::notes::Notes;
use crate::player::{AnimatedNode, DeformedMesh, Player, Skinned};
use crate::skeleton::{Bones, Skin};
use crate::{cameras, instancing, lights};

/// Everything that has been read but the meshes.
pub(crate) struct Parts<'a> {
    pub(crate) document: &'a Document,
    pub(crate) hierarchy: &'a Hierarchy<'a>,
    pub(crate) clip: Clip,
    pub(crate) meshes: Meshes<'a>,
    pub(crate) budget: &'a Budget,
}

/// A mesh of the file in the scene.
struct LoadedMesh {
    geometry: Geometry,
    /// Index into [`MaterialSet::surfaces`].
    surface: u32,
    opaque: bool,
    /// Without skin and morph targets; shared by all nodes that do not deform it.
    rigid: Option<MeshId>,
    /// By whether it can be skinned and morphed: what clones are taken of.
    models: HashMap<(bool, bool), Mesh>,
}

/// How a node deforms its mesh.
struct Deformation {
    /// Among the player's skins.
    skin: Option<usize>,
    weights: Vec<f32>,
}

/// A deformation that does not depend on the animation but through its skin: nodes with the same
/// one share a mesh.
#[derive(PartialEq, Eq, Hash)]
struct SharedDeformation {
    mesh: usize,
    skin: Option<usize>,
    /// The bits of the weights.
    weights: Vec<u32>,
    is_mirrored: bool,
    /// The node, where the animation may decide whether it mirrors.
    resized: Option<usize>,
}

struct Assembly<'a> {
    parts: Parts<'a>,
    materials: Materials<'a>,
    scene: Scene,
    material_set: MaterialSet,
    lights: Vec<LightSource>,
    cameras: Vec<CameraSource>,
    player: Player,
    loaded: Vec<Option<LoadedMesh>>,
    /// From a skin of the file to the player's.
    skins: HashMap<usize, usize>,
    /// To the deformed meshes of the player.
    shared: HashMap<SharedDeformation, usize>,
    /// For every node whether the animation may change the size of it or of a node above it.
    resized: Vec<bool>,
}

/// Puts a world together.
pub(crate) fn assemble(parts: Parts<'_>, materials: Materials<'_>, notes: &mut Notes) -> Result<World, Problem> {
    let (document, hierarchy) = (parts.document, parts.hierarchy);
    let moves = hierarchy.below(parts.clip.nodes.keys().copied());
    let bones = Bones::new(hierarchy, bones_in_use(document, hierarchy)?);
    let resized = hierarchy.below(parts.clip.resized());
    let player = Player { duration: parts.clip.duration, nodes: vec![], bones, skins: vec![], deformed: vec![] };
    let mut assembly = Assembly {
        parts,
        materials,
        scene: Scene::new(),
        material_set: MaterialSet::default(),
        lights: Vec::new(),
        cameras: Vec::new(),
        player,
        loaded: Vec::new(),
        skins: HashMap::new(),
        shared: HashMap::new(),
        resized,
    };
    assembly.read_meshes(notes)?;
    assembly.read_skins()?;
    let deformations = assembly.deformations(notes)?;
    let motions = assembly.motions_of_rigid(&deformations, &moves);
    assembly.add_nodes(deformations, &motions, notes)?;
    assembly.finish()
}

/// For every node whether it is a joint of any skin of the scene, or has a skin.
fn bones_in_use(document: &Document, hierarchy: &Hierarchy<'_>) -> Result<Vec<bool>, Problem> {
    let mut seen = HashSet::new();
    let mut in_use = vec![false; hierarchy.len()];
    for (index, node) in document.root.nodes.iter().enumerate().filter(|&(index, _)| hierarchy.in_scene[index]) {
        let Some(skin) = node.skin else { continue };
        in_use[index] = true;
        if !seen.insert(skin.value()) {
            continue;
        }
        let item = document.node_item(index);
        for &joint in &document.get(skin, "skin", &item)?.joints {
            document.get(joint, "node", &Item::new("skin", skin.value()))?;
            in_use[joint.value()] = true;
        }
    }
    Ok(in_use)
}

impl<'a> Assembly<'a> {
    /// The nodes of the scene, parents first.
    fn nodes(&self) -> impl Iterator<Item = (usize, &'a Node)> + use<'a> {
        let (document, hierarchy) = (self.parts.document, self.parts.hierarchy);
        let shown = hierarchy.parents_first().filter(|&index| hierarchy.in_scene[index]);
        shown.map(|index| (index, &document.root.nodes[index]))
    }

    /// Reads every mesh that is shown, in the order of the file.
    fn read_meshes(&mut self, notes: &mut Notes) -> Result<(), Problem> {
        let document = self.parts.document;
        let mut shown = vec![false; document.root.meshes.len()];
        for (index, node) in self.nodes() {
            if let Some(mesh) = node.mesh {
                document.get(mesh, "mesh", &document.node_item(index))?;
                shown[mesh.value()] = true;
            }
        }
        for (index, shown) in shown.into_iter().enumerate() {
            let geometry = if shown { self.parts.meshes.read(index, &mut self.materials, notes)? } else { None };
            let loaded = geometry.map(|mut geometry| {
                let surface = std::mem::take(&mut geometry.surface);
                let opaque = !has_holes(&surface, &self.materials);
                self.material_set.surfaces.push(surface);
                let surface = self.material_set.surfaces.len() as u32 - 1;
                LoadedMesh { geometry, surface, opaque, rigid: None, models: HashMap::new() }
            });
            self.loaded.push(loaded);
        }
        Ok(())
    }

    /// Reads every skin that deforms a mesh that is shown.
    fn read_skins(&mut self) -> Result<(), Problem> {
        for (index, node) in self.nodes() {
            let Some(skin) = node.skin.filter(|_| node.mesh.is_some()) else { continue };
            if !self.skins.contains_key(&skin.value()) {
                let item = self.parts.document.node_item(index);
                let read =
                    Skin::read(self.parts.document, skin, &self.player.bones, self.parts.meshes.accessors, &item)?;
                self.skins.insert(skin.value(), self.player.skins.len());
                self.player.skins.push(read);
            }
        }
        Ok(())
    }

    /// The nodes that deform their mesh, and how.
    fn deformations(&self, notes: &mut Notes) -> Result<HashMap<usize, Deformation>, Problem> {
        let document = self.parts.document;
        let mut deformations = HashMap::new();
        for (index, node) in self.nodes() {
            let Some((mesh, loaded)) = node.mesh.and_then(|m| Some((m.value(), self.loaded[m.value()].as_ref()?)))
            else {
                continue;
            };
            let item = document.node_item(index);
            let mut skin = node.skin.map(|skin| self.skins[&skin.value()]);
            match loaded.geometry.highest_joint() {
                None if skin.take().is_some() => notes.add(|| format!("{item} has a skin, but its mesh has no joints")),
                Some(highest) => {
                    let count = skin.map_or(usize::MAX, |skin| self.player.skins[skin].joint_count());
                    if usize::from(highest) >= count {
                        let reason = format!("follows joint {highest} of a skin with {count} joints at {item}");
                        return Err(document.mesh_item(mesh).invalid(reason));
                    }
                }
                None => {}
            }
            let weights = self.rest_weights(node, mesh, loaded.geometry.targets.len(), &item, notes)?;
            let morphs = self.parts.clip.weights.contains_key(&index) || weights.iter().any(|&weight| weight != 0.0);
            if skin.is_some() || (morphs && !weights.is_empty()) {
                deformations.insert(index, Deformation { skin, weights: if morphs { weights } else { Vec::new() } });
            }
        }
        Ok(deformations)
    }

    /// One weight per target: those of the node, or those of its mesh.
    fn rest_weights(
        &self,
        node: &Node,
        mesh: usize,
        targets: usize,
        item: &Item,
        notes: &mut Notes,
    ) -> Result<Vec<f32>, Problem> {
        self.parts.budget.spend_numbers(targets as u64, item)?;
        let given = node.weights.as_ref().or(self.parts.document.root.meshes[mesh].weights.as_ref());
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

    /// A mesh that is placed by any moving node is rigid, the others are static.
    fn motions_of_rigid(&self, deformations: &HashMap<usize, Deformation>, moves: &[bool]) -> Vec<Motion> {
        let mut motions = vec![Motion::Static; self.loaded.len()];
        for (_, node) in self.nodes().filter(|&(index, _)| moves[index] && !deformations.contains_key(&index)) {
            if let Some(mesh) = node.mesh {
                motions[mesh.value()] = Motion::Rigid;
            }
        }
        motions
    }

    fn add_nodes(
        &mut self,
        mut deformations: HashMap<usize, Deformation>,
        motions: &[Motion],
        notes: &mut Notes,
    ) -> Result<(), Problem> {
        let (document, hierarchy) = (self.parts.document, self.parts.hierarchy);
        let mut bears = vec![false; hierarchy.len()];
        for (index, node) in self.nodes() {
            bears[index] = node.mesh.is_some() || node.camera.is_some() || node.light().is_some();
        }
        let bears = hierarchy.above(bears);
        let mut ids: Vec<Option<NodeId>> = vec![None; hierarchy.len()];
        for (index, node) in self.nodes().filter(|&(index, _)| bears[index]) {
            let item = document.node_item(index);
            let parent = hierarchy.parent(index).and_then(|parent| ids[parent]).unwrap_or(self.scene.root());
            let (local, deformation) = (hierarchy.local(index).affine(), deformations.remove(&index));
            let light = lights::light_of(document, node, &item, notes)?;
            let camera = cameras::camera_of(document, node, &item, notes)?;
            // A mesh on which nothing hangs, and which does not move, needs no node to stand where
            // it does.
            let is_needed = light.is_some()
                || camera.is_some()
                || node.instancing().is_some()
                || self.parts.clip.nodes.contains_key(&index)
                || node.children().any(|child| bears[child.value()]);
            let (place, from_instance) = if is_needed {
                let id = self.scene.add_node(parent, local).map_err(refused(&item))?;
                ids[index] = Some(id);
                self.lights.extend(light.map(|light| LightSource { node: Some(id), light }));
                self.cameras.extend(camera.map(|(name, camera)| CameraSource { name, node: Some(id), camera }));
                (id, Affine::IDENTITY)
            } else {
                (parent, local)
            };
            if let Some(mesh) = node.mesh {
                self.add_instances(mesh.value(), index, deformation, (place, from_instance), motions, notes)?;
            }
        }
        for (node, channels) in std::mem::take(&mut self.parts.clip.nodes) {
            let (bone, rest) = (self.player.bones.of_node(node), hierarchy.local(node).trs());
            if ids[node].is_some() || bone.is_some() {
                self.player.nodes.push(AnimatedNode { id: ids[node], bone, rest, channels, placed: None });
            }
        }
        Ok(())
    }

    /// Adds the instances of the mesh of a node: one that stands so and so relative to a node of
    /// the scene, or as many as the node has.
    fn add_instances(
        &mut self,
        mesh: usize,
        node: usize,
        deformation: Option<Deformation>,
        (place, from_instance): (NodeId, Affine),
        motions: &[Motion],
        notes: &mut Notes,
    ) -> Result<(), Problem> {
        let item = self.parts.document.node_item(node);
        let instancing = self.parts.document.root.nodes[node].instancing();
        let Some((surface, opaque)) = self.loaded[mesh].as_ref().map(|loaded| (loaded.surface, loaded.opaque)) else {
            return Ok(());
        };
        // The joints say where a skinned mesh is; the place of its node counts for nothing.
        let skinned = deformation.as_ref().is_some_and(|deformation| deformation.skin.is_some());
        let (place, from_instance) =
            if skinned { (self.scene.root(), Affine::IDENTITY) } else { (place, from_instance) };
        let (mesh, index) = match deformation {
            None => (self.rigid(mesh, motions[mesh])?, None),
            Some(deformation) => {
                let index = self.deformed_mesh(node, mesh, deformation)?;
                (self.player.deformed[index].mesh, Some(index))
            }
        };
        let placements = match instancing {
            Some(instancing) if !skinned => {
                instancing::placements(instancing, self.parts.meshes.accessors, self.parts.budget, &item)?
            }
            Some(_) => {
                notes.ignored("instancing of a skinned mesh", "it stands where its joints are", Some(&item));
                vec![from_instance]
            }
            None => vec![from_instance],
        };
        for placement in placements {
            let instance = self.scene.add_instance(place, mesh, placement).map_err(refused(&item))?;
            self.scene.set_user_id(instance, surface).map_err(refused(&item))?;
            self.scene.set_opaque(instance, opaque).map_err(refused(&item))?;
            if let Some(skinned) = index.and_then(|index| self.player.deformed[index].skinned.as_mut()) {
                skinned.instances.push(instance);
            }
        }
        Ok(())
    }

    fn rigid(&mut self, mesh: usize, motion: Motion) -> Result<MeshId, Problem> {
        let item = self.parts.document.mesh_item(mesh);
        let loaded = self.loaded[mesh].as_mut().expect("only meshes with triangles are added");
        match loaded.rigid {
            Some(id) => Ok(id),
            None => {
                let model = loaded.geometry.mesh(false, false).map_err(|error| refused(&item)(error.into()))?;
                let id = self.scene.add_mesh(model, motion).map_err(refused(&item))?;
                loaded.rigid = Some(id);
                Ok(id)
            }
        }
    }

    /// The index of a deformed mesh among those of the player.
    fn deformed_mesh(&mut self, node: usize, mesh: usize, deformation: Deformation) -> Result<usize, Problem> {
        let item = self.parts.document.mesh_item(mesh);
        let Deformation { skin, weights } = deformation;
        let keys = self.parts.clip.weights.remove(&node).filter(|_| !weights.is_empty());
        let node_bone = self.player.bones.of_node(node).filter(|_| skin.is_some());
        let shared = keys.is_none().then(|| SharedDeformation {
            mesh,
            skin,
            weights: weights.iter().map(|weight| weight.to_bits()).collect(),
            is_mirrored: node_bone.is_some_and(|bone| self.player.bones.is_mirrored(bone)),
            resized: Some(node).filter(|_| node_bone.is_some() && self.resized[node]),
        });
        if let Some(&index) = shared.as_ref().and_then(|shared| self.shared.get(shared)) {
            return Ok(index);
        }
        let loaded = self.loaded[mesh].as_mut().expect("only meshes with triangles are added");
        self.parts.budget.spend_numbers(loaded.geometry.numbers(), &item)?;
        let kind = (skin.is_some(), !weights.is_empty());
        let model = match loaded.models.get(&kind) {
            Some(model) => model.clone(),
            None => {
                let model = loaded.geometry.mesh(kind.0, kind.1).map_err(|error| refused(&item)(error.into()))?;
                loaded.models.insert(kind, model.clone());
                model
            }
        };
        let id = self.scene.add_mesh(model, Motion::Deforming).map_err(refused(&item))?;
        let index = self.player.deformed.len();
        if let Some(shared) = shared {
            self.shared.insert(shared, index);
        }
        let skinned = skin.zip(node_bone).map(|(skin, node_bone)| Skinned {
            skin,
            node_bone,
            instances: Vec::new(),
            is_mirrored: false,
        });
        self.player.deformed.push(DeformedMesh { mesh: id, skinned, weights, keys, posed_with: None });
        Ok(index)
    }

    /// The world, at its first moment.
    fn finish(mut self) -> Result<World, Problem> {
        let still = self.player.nodes.is_empty() && self.player.deformed.is_empty();
        let animation: Box<dyn Animation> = if still {
            Box::new(NoAnimation)
        } else {
            let first = self.player.go_to(&mut self.scene, 0.0);
            first.map_err(refused(&Item::new("the first moment of animation", 0)))?;
            Box::new(self.player)
        };
        (self.material_set.materials, self.material_set.textures) = self.materials.into_parts();
        let Self { scene, material_set, lights, cameras, .. } = self;
        Ok(World { scene, material_set: Arc::new(material_set), lights, cameras, animation })
    }
}

/// Whether a ray can pass through a triangle because of its alpha: only then do filters have to be
/// asked.
fn has_holes(surface: &Surface, materials: &Materials<'_>) -> bool {
    let vertex_alpha = surface.colors.iter().fold(1.0_f32, |least, color| least.min(color[3]));
    surface.parts.iter().any(|part| materials.has_holes(part.material, vertex_alpha))
}

fn refused(item: &Item) -> impl Fn(EditError) -> Problem + '_ {
    |error| Problem::Refused { item: item.clone(), error }
}
