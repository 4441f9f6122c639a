//! From an asset to a scene: all of it, or nothing.

use std::collections::HashMap;
use std::sync::Arc;

use kinetree::{Affine, EditError, InstanceId, NodeId, Scene};
use kinetree_world::{CameraSource, LightSource, MaterialBindings};

use crate::asset::Asset;
use crate::clip::Playing;
use crate::error::{Item, LoadError, Problem};
use crate::loaded::{Inserted, Loaded, LoadedInstance, LoadedMesh, LoadedNode, LoadedSkin};
use crate::player::Player;
use crate::transform::Local;

/// Which nodes of the file become nodes of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NodeSelection {
    /// Every node, so that each can be found, moved, and given children.
    All,
    /// Those without which something would stand in another place.
    Needed,
}

impl Asset {
    /// Inserts the contents of the file below a node of a scene, at rest, with all nodes of the
    /// file. What it adds has no user ids and masks of its own: those of the nodes above hold for
    /// it, which are 0 and all bits unless the caller sets others.
    ///
    /// # Errors
    /// A parent that is stale or of another scene; what the library refuses, such as joints whose
    /// transforms overflow. The scene is as it was before.
    pub fn load_into(&self, scene: &mut Scene, parent: NodeId) -> Result<Loaded, LoadError> {
        let inserted = insert(self, scene, parent, NodeSelection::All, Playing::Nothing);
        inserted.map_err(|problem| self.error(problem))
    }
}

/// Inserts an asset below a node, and brings it to the first moment of what is played. After an
/// error, the scene is as it was.
pub(crate) fn insert(
    asset: &Asset,
    scene: &mut Scene,
    parent: NodeId,
    selection: NodeSelection,
    playing: Playing,
) -> Result<Loaded, Problem> {
    let root = scene.add_node(parent, Affine::IDENTITY).map_err(Problem::Parent)?;
    let contents = &asset.contents;
    let inserted = Inserted {
        root,
        nodes: Vec::new(),
        meshes: Vec::with_capacity(contents.meshes.len()),
        instances: Vec::with_capacity(contents.instances.len()),
    };
    let mut insertion = Insertion { asset, scene, inserted, ids: vec![None; asset.nodes.len()] };
    match insertion.run(selection, playing) {
        Ok(player) => Ok(insertion.finish(player)),
        Err(problem) => {
            insertion.inserted.remove(insertion.scene);
            Err(problem)
        }
    }
}

struct Insertion<'a> {
    asset: &'a Asset,
    scene: &'a mut Scene,
    inserted: Inserted,
    /// From a node of the file to that of the scene.
    ids: Vec<Option<NodeId>>,
}

impl Insertion<'_> {
    fn run(&mut self, selection: NodeSelection, playing: Playing) -> Result<Player, Problem> {
        self.add_nodes(selection)?;
        self.add_meshes()?;
        self.add_instances()?;
        let meshes: Vec<_> = self.inserted.meshes.iter().map(|mesh| mesh.id).collect();
        let mut of_skinned: HashMap<u32, Vec<InstanceId>> = HashMap::new();
        let contents = &self.asset.contents;
        for (source, instance) in contents.instances.iter().zip(&self.inserted.instances) {
            if contents.meshes[source.mesh as usize].is_skinned {
                of_skinned.entry(source.mesh).or_default().push(instance.id);
            }
        }
        let instances_of = |mesh: usize| of_skinned.remove(&(mesh as u32)).unwrap_or_default();
        let rig = &self.asset.contents.rig;
        let mut player = Player::new(rig, |node| self.ids[node], &meshes, instances_of);
        let first = player.play(self.scene, playing, 0.0);
        first.map_err(refused(|| Item::new("the first moment of animation", 0)))?;
        Ok(player)
    }

    fn add_nodes(&mut self, selection: NodeSelection) -> Result<(), Problem> {
        let hierarchy = &self.asset.hierarchy;
        let is_added = |&node: &usize| match selection {
            NodeSelection::All => hierarchy.in_scene[node],
            NodeSelection::Needed => self.asset.contents.is_needed[node],
        };
        for index in hierarchy.parents_first().filter(is_added) {
            let node = &self.asset.nodes[index];
            let parent = self.parent(index);
            let id = self.scene.add_node(parent, Local::of(node).affine());
            let id = id.map_err(refused(|| self.item(index)))?;
            self.ids[index] = Some(id);
            self.inserted.nodes.push(LoadedNode { index, name: node.name.as_deref().map(Arc::from), id });
        }
        Ok(())
    }

    fn add_meshes(&mut self) -> Result<(), Problem> {
        for source in &self.asset.contents.meshes {
            let item = || Item::named("mesh", source.index, source.name.as_deref());
            let id = self.scene.add_mesh(source.mesh.clone(), source.motion).map_err(refused(item))?;
            self.inserted.meshes.push(LoadedMesh { index: source.index, name: source.name.clone(), id });
        }
        Ok(())
    }

    fn add_instances(&mut self) -> Result<(), Problem> {
        for source in &self.asset.contents.instances {
            let (index, mesh_source) = (source.node as usize, &self.asset.contents.meshes[source.mesh as usize]);
            let mesh = self.inserted.meshes[source.mesh as usize].id;
            // The joints say where a skinned mesh is; the transform of its node does not matter.
            let node_from_instance = source.node_from_instance.as_deref().copied().unwrap_or_default();
            let (parent, placement) = match self.ids[index] {
                _ if mesh_source.is_skinned => (self.inserted.root, node_from_instance),
                Some(id) => (id, node_from_instance),
                None => (self.parent(index), Local::of(&self.asset.nodes[index]).affine()),
            };
            let id = self.scene.add_instance(parent, mesh, placement).map_err(refused(|| self.item(index)))?;
            self.inserted.instances.push(LoadedInstance { node: index, mesh, id });
            self.scene.set_opaque(id, mesh_source.is_opaque).map_err(refused(|| self.item(index)))?;
        }
        Ok(())
    }

    /// The parent of a node in the scene.
    fn parent(&self, node: usize) -> NodeId {
        self.asset.hierarchy.parent(node).and_then(|parent| self.ids[parent]).unwrap_or(self.inserted.root)
    }

    fn item(&self, node: usize) -> Item {
        Item::named("node", node, self.asset.nodes[node].name.as_deref())
    }

    fn finish(self, player: Player) -> Loaded {
        let (contents, ids) = (&self.asset.contents, &self.ids);
        let rig = &contents.rig;
        let skins = rig.skins.iter().map(|skin| LoadedSkin {
            index: skin.index,
            name: skin.name.clone(),
            joints: skin.joints.iter().map(|&joint| ids[rig.skeleton.node(joint as usize)]).collect(),
        });
        let lights = contents.lights.iter().map(|&(node, light)| LightSource { node: ids[node], light });
        let cameras = contents.cameras.iter().map(|(node, name, camera)| CameraSource {
            name: name.clone(),
            node: ids[*node],
            camera: *camera,
        });
        let mut material_bindings = MaterialBindings::default();
        for (source, instance) in contents.instances.iter().zip(&self.inserted.instances) {
            material_bindings.bind(instance.id, contents.meshes[source.mesh as usize].surface);
        }
        Loaded {
            skins: skins.collect(),
            lights: lights.collect(),
            cameras: cameras.collect(),
            notes: Arc::clone(self.asset.shared_notes()),
            material_set: Arc::clone(&contents.material_set),
            material_bindings,
            inserted: self.inserted,
            player,
        }
    }
}

fn refused(item: impl FnOnce() -> Item) -> impl FnOnce(EditError) -> Problem {
    |error| Problem::Refused { item: item(), error }
}
