//! A file in a scene: what was inserted, and how to take it out again.

use std::fmt;
use std::sync::Arc;

use kinetree::{EditError, InstanceId, MeshId, NodeId, Scene};
use kinetree_world::{CameraSource, LightSource, Material, MaterialBindings, MaterialSet, Surface};

use crate::clip::ClipInfo;
use crate::player::Player;

/// One copy of a file in a scene.
///
/// The caller may move, mask and number anything that is listed here, attach things of its own to
/// the nodes, and remove what it does not need.
pub struct Loaded {
    /// Plays the animations of the file.
    pub player: Player,
    pub(crate) inserted: Inserted,
    pub(crate) skins: Vec<LoadedSkin>,
    pub(crate) lights: Vec<LightSource>,
    pub(crate) cameras: Vec<CameraSource>,
    pub(crate) notes: Arc<[String]>,
    pub(crate) material_set: Arc<MaterialSet>,
    pub(crate) material_bindings: MaterialBindings,
}

/// A node of the file in the scene.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct LoadedNode {
    /// In the file.
    pub index: usize,
    /// As written in the file; several nodes may share a name.
    pub name: Option<Arc<str>>,
    /// In the scene.
    pub id: NodeId,
}

/// A mesh of the file in the scene. Nodes that deform a mesh of the file have copies of it.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct LoadedMesh {
    /// In the file.
    pub index: usize,
    /// As written in the file.
    pub name: Option<Arc<str>>,
    /// In the scene.
    pub id: MeshId,
}

/// An instance of a mesh in the scene.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct LoadedInstance {
    /// The node in the file that shows the mesh.
    pub node: usize,
    /// In the scene.
    pub mesh: MeshId,
    /// In the scene.
    pub id: InstanceId,
}

/// A skin of the file that deforms a mesh of the scene.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct LoadedSkin {
    /// In the file.
    pub index: usize,
    /// As written in the file.
    pub name: Option<Arc<str>>,
    /// The joints in the order of the file; `None` for a node of the file that is not in the scene.
    pub joints: Vec<Option<NodeId>>,
}

/// What has been added to a scene, in the order in which it was added.
pub(crate) struct Inserted {
    /// The parent of the root nodes of the file.
    pub(crate) root: NodeId,
    pub(crate) nodes: Vec<LoadedNode>,
    pub(crate) meshes: Vec<LoadedMesh>,
    pub(crate) instances: Vec<LoadedInstance>,
}

impl Inserted {
    /// Takes everything out again, last things first, so that the scene gives out its slots in the
    /// same order as before. What the caller has removed already is passed over, and so are meshes
    /// of which the caller has instances elsewhere.
    pub(crate) fn remove(&self, scene: &mut Scene) {
        for instance in self.instances.iter().rev() {
            let _ = scene.remove_instance(instance.id);
        }
        for node in self.nodes.iter().rev() {
            let _ = scene.remove_node(node.id);
        }
        let _ = scene.remove_node(self.root);
        for mesh in self.meshes.iter().rev() {
            let _ = scene.remove_mesh(mesh.id);
        }
    }
}

impl Loaded {
    /// The node that holds everything else, below the parent that the caller named. To move the
    /// file as a whole, move this node.
    pub fn root(&self) -> NodeId {
        self.inserted.root
    }

    /// The nodes of the file, parents first.
    pub fn nodes(&self) -> &[LoadedNode] {
        &self.inserted.nodes
    }

    /// The first node of a name.
    pub fn node(&self, name: &str) -> Option<NodeId> {
        self.nodes().iter().find(|node| node.name.as_deref() == Some(name)).map(|node| node.id)
    }

    /// The meshes, in the order in which they were added.
    pub fn meshes(&self) -> &[LoadedMesh] {
        &self.inserted.meshes
    }

    /// The instances, in the order in which they were added.
    pub fn instances(&self) -> &[LoadedInstance] {
        &self.inserted.instances
    }

    /// The skins that deform meshes.
    pub fn skins(&self) -> &[LoadedSkin] {
        &self.skins
    }

    /// The lights of the file, which the scene knows nothing of.
    pub fn lights(&self) -> &[LightSource] {
        &self.lights
    }

    /// The cameras of the file, which the scene knows nothing of.
    pub fn cameras(&self) -> &[CameraSource] {
        &self.cameras
    }

    /// All animations of the file, in its order.
    pub fn clips(&self) -> &[ClipInfo] {
        self.player.clips()
    }

    /// What was ignored or repaired while the file was read, one line each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The materials and textures of the file, shared by all its copies.
    pub fn material_set(&self) -> &Arc<MaterialSet> {
        &self.material_set
    }

    /// The surface of each instance, as an index into [`MaterialSet::surfaces`] of
    /// [`Loaded::material_set`].
    pub fn material_bindings(&self) -> &MaterialBindings {
        &self.material_bindings
    }

    /// Which triangles of an instance have which material, with texture coordinates and vertex
    /// colours; `None` for an instance that is not of this file.
    pub fn surface(&self, instance: InstanceId) -> Option<&Surface> {
        let surface = self.material_bindings.surface(instance)?;
        self.material_set.surfaces.get(surface as usize)
    }

    /// The material of a triangle of an instance; `None` for an instance that is not of this file.
    pub fn material(&self, instance: InstanceId, triangle: u32) -> Option<&Material> {
        let material = self.surface(instance)?.material_of(triangle)?;
        self.material_set.materials.get(material as usize)
    }

    /// Takes the file out of the scene, with everything that the caller attached to its nodes. What
    /// the caller has removed already is passed over, so that a second call does nothing. A mesh
    /// of which the caller has instances elsewhere stays, and is the caller's from then on.
    ///
    /// # Errors
    /// Another scene than the one that the file is in, which stays as it is.
    pub fn remove(&self, scene: &mut Scene) -> Result<(), EditError> {
        if scene.world_from_node(self.root()) == Err(EditError::OtherScene) {
            return Err(EditError::OtherScene);
        }
        self.inserted.remove(scene);
        Ok(())
    }
}

/// In short: how much there is of it.
impl fmt::Debug for Loaded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Loaded")
            .field("nodes", &self.nodes().len())
            .field("meshes", &self.meshes().len())
            .field("instances", &self.instances().len())
            .field("skins", &self.skins.len())
            .field("clips", &self.clips().len())
            .finish_non_exhaustive()
    }
}
