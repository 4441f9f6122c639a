//! Looking up what a scene holds, edits since the last commit included.

use super::contents::Scene;
use super::error::EditError;
use super::graph::Placement;
use super::mesh::Mesh;
use crate::build::Quality;
use crate::geometry::{Affine, Precision};
use crate::handle::{InstanceId, MeshId, NodeId, Placed};
use crate::update::Motion;

/// # Looking up
///
/// Each of these gives what the edits have made of the scene, whether or not it has been committed.
impl Scene {
    /// All nodes, the root included, by the numbers of their slots: an order that does not depend
    /// on the hierarchy.
    pub fn nodes(&self) -> impl Iterator<Item = NodeId> {
        self.nodes.handles().map(NodeId)
    }

    /// All instances, in the order of [`Snapshot::instances`](crate::Snapshot::instances).
    pub fn instances(&self) -> impl Iterator<Item = InstanceId> {
        self.instances.handles().map(InstanceId)
    }

    /// All meshes, in the order of [`FrameReport::meshes`](crate::FrameReport::meshes).
    pub fn meshes(&self) -> impl Iterator<Item = MeshId> {
        self.meshes.handles().map(MeshId)
    }

    /// A mesh as it was handed over: at rest, and with the normals it came with.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn mesh(&self, mesh: MeshId) -> Result<&Mesh, EditError> {
        Ok(self.meshes.get(mesh.0)?.mesh())
    }

    /// How a mesh was announced to move.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn motion(&self, mesh: MeshId) -> Result<Motion, EditError> {
        Ok(self.meshes.get(mesh.0)?.motion())
    }

    /// The quality of the next build of a mesh: the one that was chosen, or that its motion
    /// suggests.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn quality(&self, mesh: MeshId) -> Result<Quality, EditError> {
        Ok(self.meshes.get(mesh.0)?.quality())
    }

    /// How exactly rays are tested against the triangles of a mesh.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn precision(&self, mesh: MeshId) -> Result<Precision, EditError> {
        Ok(self.meshes.get(mesh.0)?.precision())
    }

    /// The mesh that an instance shows.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn mesh_of(&self, instance: InstanceId) -> Result<MeshId, EditError> {
        Ok(self.instances.get(instance.0)?.mesh.into())
    }

    /// The transform that [`Scene::place`] sets: `parent_from_node` or `node_from_instance`.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn transform(&self, what: impl Into<Placed>) -> Result<Affine, EditError> {
        Ok(self.placement(what.into())?.transform)
    }

    /// The mask that [`Scene::set_mask`] sets; all bits, unless set.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn mask(&self, what: impl Into<Placed>) -> Result<u32, EditError> {
        Ok(self.placement(what.into())?.mask)
    }

    /// The number that [`Scene::set_user_id`] sets; `None`, unless set.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn user_id(&self, what: impl Into<Placed>) -> Result<Option<u32>, EditError> {
        Ok(self.placement(what.into())?.user_id)
    }

    /// Whether filters are not asked about an instance.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn is_opaque(&self, instance: InstanceId) -> Result<bool, EditError> {
        Ok(self.instances.get(instance.0)?.opaque)
    }

    /// The node that a node or an instance is placed in; `None` for the root.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn parent(&self, what: impl Into<Placed>) -> Result<Option<NodeId>, EditError> {
        let slot = match what.into() {
            Placed::Node(node) => self.nodes.get(node.0)?.parent,
            Placed::Instance(instance) => Some(self.instances.get(instance.0)?.node),
        };
        Ok(slot.map(|slot| self.nodes.handle_of(slot).into()))
    }

    /// The nodes placed in a node, in no particular order.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn children(&self, node: NodeId) -> Result<impl ExactSizeIterator<Item = NodeId>, EditError> {
        let slots = self.nodes.get(node.0)?.children.slots();
        Ok(slots.iter().map(|&slot| self.nodes.handle_of(slot).into()))
    }

    /// The instances placed in a node, in no particular order. Those of its children do not count.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn instances_of(&self, node: NodeId) -> Result<impl ExactSizeIterator<Item = InstanceId>, EditError> {
        let slots = self.nodes.get(node.0)?.instances.slots();
        Ok(slots.iter().map(|&slot| self.instances.handle_of(slot).into()))
    }

    /// Takes points from the space of a node to the world: the transforms from the root down to it.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn world_from_node(&self, node: NodeId) -> Result<Affine, EditError> {
        let mut at = self.nodes.get(node.0)?;
        let mut path = vec![at.placement.transform];
        while let Some(parent) = at.parent.and_then(|slot| self.nodes.at(slot)) {
            at = parent;
            path.push(at.placement.transform);
        }
        // From the root down, in the order of a commit, so that both round alike.
        Ok(path.into_iter().rev().reduce(|outer, inner| outer * inner).unwrap_or_default())
    }

    /// Takes points from the space of an instance to the world.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn world_from_instance(&self, instance: InstanceId) -> Result<Affine, EditError> {
        let Placement { transform, .. } = self.instances.get(instance.0)?.placement;
        let node = self.nodes.handle_of(self.instances.get(instance.0)?.node);
        Ok(self.world_from_node(node.into())? * transform)
    }

    fn placement(&self, what: Placed) -> Result<&Placement, EditError> {
        match what {
            Placed::Node(node) => Ok(&self.nodes.get(node.0)?.placement),
            Placed::Instance(instance) => Ok(&self.instances.get(instance.0)?.placement),
        }
    }
}
