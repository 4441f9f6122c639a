//! A scene and its materials, built together.

use glam::Affine3A;
use kinetree::{Affine, EditError, InstanceId, Mesh, MeshId, Motion, NodeId, Scene};
use kinetree_world::{Alpha, MaterialBindings, MaterialSet, Surface};

use crate::meshing::Sketch;

/// A scene and its materials, under construction.
pub(crate) struct SceneBuilder {
    pub(crate) scene: Scene,
    pub(crate) material_set: MaterialSet,
    pub(crate) material_bindings: MaterialBindings,
}

/// A mesh of the scene with its surface, ready to be instanced any number of times.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prop {
    pub(crate) mesh: MeshId,
    /// Index into [`MaterialSet::surfaces`].
    surface: u32,
    /// Whether no part of it is masked or translucent.
    opaque: bool,
}

impl SceneBuilder {
    /// Adds a sketch as a mesh.
    pub(crate) fn prop(&mut self, sketch: Sketch, motion: Motion) -> Result<Prop, EditError> {
        let (mesh, surface) = sketch.finish()?;
        self.with_surface(mesh, surface, motion)
    }

    /// Adds a mesh with its surface.
    pub(crate) fn with_surface(&mut self, mesh: Mesh, surface: Surface, motion: Motion) -> Result<Prop, EditError> {
        let mesh = self.scene.add_mesh(mesh, motion)?;
        Ok(self.with_other_surface(mesh, surface))
    }

    /// A mesh of the scene with another surface.
    pub(crate) fn with_other_surface(&mut self, mesh: MeshId, surface: Surface) -> Prop {
        let materials = &self.material_set.materials;
        let opaque = surface.parts.iter().all(|part| materials[part.material as usize].alpha == Alpha::Opaque);
        self.material_set.surfaces.push(surface);
        Prop { mesh, surface: self.material_set.surfaces.len() as u32 - 1, opaque }
    }

    /// Adds an instance in the space of a node.
    pub(crate) fn put(&mut self, node: NodeId, prop: Prop, placement: &Affine3A) -> Result<InstanceId, EditError> {
        let instance = self.scene.add_instance(node, prop.mesh, affine(placement))?;
        self.material_bindings.bind(instance, prop.surface);
        self.scene.set_opaque(instance, prop.opaque)?;
        Ok(instance)
    }

    /// Adds an instance in world space.
    pub(crate) fn put_in_world(&mut self, prop: Prop, placement: &Affine3A) -> Result<InstanceId, EditError> {
        let root = self.scene.root();
        self.put(root, prop, placement)
    }
}

/// Converts a placement to the scene's type.
pub(crate) fn affine(placement: &Affine3A) -> Affine {
    let [x, y, z] = [placement.x_axis, placement.y_axis, placement.z_axis].map(|axis| axis.to_array());
    Affine::from_columns(x, y, z, placement.translation.to_array())
}
