//! Edits: checked and recorded at once, carried out by the next commit.

use super::contents::Scene;
use super::error::EditError;
use super::graph::{Instance, Node, Placement};
use super::input::{Indices, Positions, check_finite};
use super::mesh::Mesh;
use super::mesh_state::MeshState;
use super::pose::{OwnedPose, Pose};
use crate::build::Quality;
use crate::geometry::{Affine, Precision};
use crate::handle::{InstanceId, MeshId, NodeId, Placed};
use crate::update::Motion;

impl Scene {
    /// Adds a mesh. It is shown where instances place it.
    ///
    /// # Errors
    /// The scene is full.
    #[doc(alias = "BLAS")]
    pub fn add_mesh(&mut self, mesh: Mesh, motion: Motion) -> Result<MeshId, EditError> {
        Ok(self.meshes.insert(MeshState::new(mesh, motion))?.into())
    }

    /// Hands over a tree that [`Mesh::bake`] built earlier for this mesh. The next commit uses it
    /// instead of building one, as with [`Mesh::with_tree`].
    ///
    /// # Errors
    /// A stale or foreign handle; a mesh that has been committed with these triangles; bytes that
    /// are no tree, damaged, or a tree of another mesh.
    pub fn set_tree(&mut self, mesh: MeshId, tree: &[u8]) -> Result<(), EditError> {
        self.meshes.get_mut(mesh.0)?.set_tree(tree)
    }

    /// Adds a node below another.
    ///
    /// # Errors
    /// A stale or foreign parent; a transform that is not finite.
    pub fn add_node(&mut self, parent: NodeId, parent_from_node: Affine) -> Result<NodeId, EditError> {
        check_transform(&parent_from_node)?;
        self.nodes.get(parent.0)?;
        let placement = Placement::at(parent_from_node);
        let node = Node { placement, parent: Some(parent.0.slot), ..Node::root() };
        let id = self.nodes.insert(node)?;
        let index = self.nodes.get_mut(parent.0)?.children.add(id.slot);
        self.nodes.get_mut(id)?.index = index;
        Ok(id.into())
    }

    /// Shows a mesh at a node.
    ///
    /// # Errors
    /// A stale or foreign handle; a transform that is not finite.
    pub fn add_instance(
        &mut self,
        node: NodeId,
        mesh: MeshId,
        node_from_instance: Affine,
    ) -> Result<InstanceId, EditError> {
        check_transform(&node_from_instance)?;
        self.nodes.get(node.0)?;
        self.meshes.get(mesh.0)?;
        let placement = Placement::at(node_from_instance);
        let instance = Instance { placement, node: node.0.slot, index: 0, mesh: mesh.0, opaque: false, inverted: None };
        let id = self.instances.insert(instance)?;
        let index = self.nodes.get_mut(node.0)?.instances.add(id.slot);
        self.instances.get_mut(id)?.index = index;
        self.meshes.get_mut(mesh.0)?.instances += 1;
        Ok(id.into())
    }

    /// Moves a node in its parent, or an instance in its node.
    ///
    /// # Errors
    /// A stale or foreign handle; a transform that is not finite; the root.
    pub fn place(&mut self, what: impl Into<Placed>, transform: Affine) -> Result<(), EditError> {
        check_transform(&transform)?;
        let what = what.into();
        if let Placed::Node(node) = what
            && self.nodes.get(node.0)?.parent.is_none()
        {
            return Err(EditError::Root);
        }
        self.placement_mut(what)?.transform = transform;
        Ok(())
    }

    /// Queries see an instance when their mask shares a bit with its own and with those of all
    /// nodes above.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn set_mask(&mut self, what: impl Into<Placed>, mask: u32) -> Result<(), EditError> {
        self.placement_mut(what.into())?.mask = mask;
        Ok(())
    }

    /// A number of the caller's own, which the view of a hit returns. An instance without one has
    /// that of the nearest node above; else 0.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn set_user_id(&mut self, what: impl Into<Placed>, user_id: u32) -> Result<(), EditError> {
        self.placement_mut(what.into())?.user_id = Some(user_id);
        Ok(())
    }

    /// Filters are not called for hits on an opaque instance. Instances are not opaque, unless set.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn set_opaque(&mut self, instance: InstanceId, opaque: bool) -> Result<(), EditError> {
        self.instances.get_mut(instance.0)?.opaque = opaque;
        Ok(())
    }

    /// The same triangles with other positions. Normals stay, until [`Scene::set_normals`].
    ///
    /// # Errors
    /// A stale or foreign handle; another number of positions; a position that is not finite.
    pub fn set_positions<'a>(&mut self, mesh: MeshId, positions: impl Into<Positions<'a>>) -> Result<(), EditError> {
        self.meshes.get_mut(mesh.0)?.set_positions(positions.into())
    }

    /// Other normals, one per vertex.
    ///
    /// # Errors
    /// A stale or foreign handle; another number of normals than of vertices; a normal that is not
    /// finite.
    pub fn set_normals(&mut self, mesh: MeshId, normals: &[[f32; 3]]) -> Result<(), EditError> {
        let mesh = self.meshes.get_mut(mesh.0)?;
        check_count(mesh, normals.len())?;
        check_finite(normals)?;
        mesh.set_normals(normals.to_vec());
        Ok(())
    }

    /// Other triangles; there may be none. Normals, skin and morph targets of the old ones go with
    /// them; motion, quality and precision stay.
    ///
    /// # Errors
    /// A stale or foreign handle; what [`Mesh::new`] refuses.
    pub fn set_triangles<'a>(
        &mut self,
        mesh: MeshId,
        positions: impl Into<Positions<'a>>,
        indices: impl Into<Indices<'a>>,
    ) -> Result<(), EditError> {
        let mesh = self.meshes.get_mut(mesh.0)?;
        mesh.replace(Mesh::new(positions, indices)?);
        Ok(())
    }

    /// Deforms a mesh by its morph targets and its skin, from its rest pose. The next commit
    /// computes positions and normals.
    ///
    /// # Errors
    /// A stale or foreign handle; a pose that does not fit the mesh or is not finite.
    pub fn pose(&mut self, mesh: MeshId, pose: &Pose<'_>) -> Result<(), EditError> {
        let mesh = self.meshes.get_mut(mesh.0)?;
        let pose = OwnedPose::new(pose, mesh.data())?;
        mesh.pose(pose);
        Ok(())
    }

    /// Announces another motion. The next commit builds a new tree if the motion suggests a better
    /// [`Quality`] than the tree was built with; from then on, edits are carried out as the motion
    /// says.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn set_motion(&mut self, mesh: MeshId, motion: Motion) -> Result<(), EditError> {
        self.meshes.get_mut(mesh.0)?.set_motion(motion);
        Ok(())
    }

    /// Chooses the quality of a mesh's trees, as [`Mesh::with_quality`] does; with `None`, what its
    /// motion suggests. The next commit builds a new tree if this is better than the tree was built
    /// with. A better tree is kept until it has to be rebuilt for another reason.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn set_quality(&mut self, mesh: MeshId, quality: impl Into<Option<Quality>>) -> Result<(), EditError> {
        self.meshes.get_mut(mesh.0)?.set_quality(quality.into());
        Ok(())
    }

    /// Chooses how exactly rays are tested against the triangles of a mesh, as
    /// [`Mesh::with_precision`] does, from the next commit on. The tree stays; its buffer is
    /// copied.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn set_precision(&mut self, mesh: MeshId, precision: Precision) -> Result<(), EditError> {
        self.meshes.get_mut(mesh.0)?.set_precision(precision);
        Ok(())
    }

    /// Makes the next commit build a new tree for a mesh, whatever its motion and drift. A mesh
    /// without a tree gets its first one as usual.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn rebuild(&mut self, mesh: MeshId) -> Result<(), EditError> {
        self.meshes.get_mut(mesh.0)?.rebuild();
        Ok(())
    }

    /// Removes a mesh without instances.
    ///
    /// # Errors
    /// A stale or foreign handle; the mesh is in use.
    pub fn remove_mesh(&mut self, mesh: MeshId) -> Result<(), EditError> {
        match self.meshes.get(mesh.0)?.instances {
            0 => self.meshes.remove(mesh.0).map(drop),
            instances => Err(EditError::MeshInUse { instances }),
        }
    }

    /// Removes an instance.
    ///
    /// # Errors
    /// A stale or foreign handle.
    pub fn remove_instance(&mut self, instance: InstanceId) -> Result<(), EditError> {
        let removed = self.instances.remove(instance.0)?;
        if let Some(node) = self.nodes.at_mut(removed.node)
            && let Some(moved) = node.instances.remove(removed.index)
            && let Some(moved) = self.instances.at_mut(moved)
        {
            moved.index = removed.index;
        }
        self.meshes.get_mut(removed.mesh)?.instances -= 1;
        Ok(())
    }

    /// Removes a node with all nodes and instances below it. Meshes stay.
    ///
    /// # Errors
    /// A stale or foreign handle; the root.
    pub fn remove_node(&mut self, node: NodeId) -> Result<(), EditError> {
        let Node { parent, index, .. } = *self.nodes.get(node.0)?;
        let parent = parent.ok_or(EditError::Root)?;
        if let Some(parent) = self.nodes.at_mut(parent)
            && let Some(moved) = parent.children.remove(index)
            && let Some(moved) = self.nodes.at_mut(moved)
        {
            moved.index = index;
        }
        let mut open = vec![node.0.slot];
        while let Some(node) = open.pop().and_then(|slot| self.nodes.remove_at(slot)) {
            open.extend(node.children.slots());
            for &slot in node.instances.slots() {
                if let Some(instance) = self.instances.remove_at(slot) {
                    self.meshes.get_mut(instance.mesh)?.instances -= 1;
                }
            }
        }
        Ok(())
    }

    fn placement_mut(&mut self, what: Placed) -> Result<&mut Placement, EditError> {
        match what {
            Placed::Node(node) => Ok(&mut self.nodes.get_mut(node.0)?.placement),
            Placed::Instance(instance) => Ok(&mut self.instances.get_mut(instance.0)?.placement),
        }
    }
}

fn check_transform(transform: &Affine) -> Result<(), EditError> {
    if transform.is_finite() { Ok(()) } else { Err(EditError::NonFinite { at: 0 }) }
}

fn check_count(mesh: &MeshState, found: usize) -> Result<(), EditError> {
    let expected = mesh.data().positions.len();
    if found == expected { Ok(()) } else { Err(EditError::PositionCountChanged { expected, found }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps in the lists of the children and instances of nodes.
    fn steps(scene: &Scene) -> u64 {
        scene.nodes.iter().map(|(_, node)| node.children.steps + node.instances.steps).sum()
    }

    #[test]
    fn removing_takes_one_step_however_many_siblings_there_are() {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh::empty(), Motion::Rigid).unwrap();
        let root = scene.root();
        let mut placed: Vec<Placed> = Vec::new();
        for i in 0..10_000_usize {
            placed.push(if i % 2 == 0 {
                scene.add_node(root, Affine::IDENTITY).unwrap().into()
            } else {
                scene.add_instance(root, mesh, Affine::IDENTITY).unwrap().into()
            });
        }
        let before = steps(&scene);
        // From the front, from the back and from the middle.
        for i in 0..10_000 {
            let at = [0, placed.len() - 1, placed.len() / 2][i % 3];
            match placed.swap_remove(at) {
                Placed::Node(node) => scene.remove_node(node).unwrap(),
                Placed::Instance(instance) => scene.remove_instance(instance).unwrap(),
            }
        }
        assert_eq!(steps(&scene) - before, 10_000);
        let root = scene.nodes.get(root.0).unwrap();
        assert!(root.children.slots().is_empty() && root.instances.slots().is_empty());
        assert_eq!(scene.instances.iter().count(), 0);
        scene.remove_mesh(mesh).unwrap();
    }

    #[test]
    fn children_and_instances_are_right_after_any_removals() {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh::empty(), Motion::Rigid).unwrap();
        let mut nodes = vec![scene.root()];
        let mut seed = 0x5eed_u64;
        let mut random = |below: usize| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as usize % below
        };
        for step in 0..4000 {
            let at = random(nodes.len());
            match random(4) {
                0 | 1 => nodes.push(scene.add_node(nodes[at], Affine::IDENTITY).unwrap()),
                2 => drop(scene.add_instance(nodes[at], mesh, Affine::IDENTITY).unwrap()),
                _ if at > 0 && step % 3 == 0 => scene.remove_node(nodes[at]).unwrap(),
                _ => {
                    let all: Vec<u32> = scene.instances.iter().map(|(slot, _)| slot).collect();
                    if !all.is_empty() {
                        let handle = scene.instances.handle_of(all[random(all.len())]);
                        scene.remove_instance(handle.into()).unwrap();
                    }
                }
            }
            nodes.retain(|node| scene.nodes.get(node.0).is_ok());
            for (slot, node) in scene.nodes.iter() {
                if let Some(parent) = node.parent {
                    let siblings = scene.nodes.at(parent).unwrap().children.slots();
                    assert_eq!(siblings[node.index as usize], slot, "step {step}");
                }
                assert!(node.children.slots().iter().all(|&child| scene.nodes.at(child).is_some()));
            }
            for (slot, instance) in scene.instances.iter() {
                let siblings = scene.nodes.at(instance.node).unwrap().instances.slots();
                assert_eq!(siblings[instance.index as usize], slot, "step {step}");
            }
            let listed: usize = scene.nodes.iter().map(|(_, node)| node.instances.slots().len()).sum();
            assert_eq!(listed, scene.instances.iter().count());
            assert_eq!(scene.meshes.get(mesh.0).unwrap().instances, listed);
        }
    }
}
