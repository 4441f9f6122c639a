//! Which surface each instance of a scene has.
//!
//! The table belongs to the world and is keyed by the handles of instances, so that user ids stay
//! the caller's own.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use kinetree::{InstanceId, Snapshot};

/// The surface of each instance, as an index into [`MaterialSet::surfaces`](crate::MaterialSet).
#[derive(Default, Clone)]
pub struct MaterialBindings {
    surfaces: HashMap<InstanceId, u32>,
    /// The last result of [`MaterialBindings::resolve`], until a binding changes.
    resolved: Option<Resolved>,
}

/// The bindings of the instances of a snapshot, by their dense index.
#[derive(Clone)]
struct Resolved {
    instances: Vec<InstanceId>,
    surfaces: Arc<[u32]>,
}

/// Prints the length, not the bindings.
impl fmt::Debug for MaterialBindings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MaterialBindings").field("instances", &self.surfaces.len()).finish_non_exhaustive()
    }
}

/// The surface of instances without a binding, which is no index.
pub(crate) const UNBOUND: u32 = u32::MAX;

impl MaterialBindings {
    /// Gives an instance a surface, in place of the one that it had, if any. An index without a
    /// surface means the default material.
    pub fn bind(&mut self, instance: InstanceId, surface: u32) {
        self.surfaces.insert(instance, surface);
        self.resolved = None;
    }

    /// Removes the binding of an instance, and returns the surface that it had. Call it for
    /// instances that are removed from the scene: their handles are never reused, so a binding that
    /// stays does no harm, but takes memory.
    pub fn unbind(&mut self, instance: InstanceId) -> Option<u32> {
        self.resolved = None;
        self.surfaces.remove(&instance)
    }

    /// The surface of an instance.
    pub fn surface(&self, instance: InstanceId) -> Option<u32> {
        self.surfaces.get(&instance).copied()
    }

    /// The surfaces of the instances of a snapshot, by their dense index. Takes time in proportion
    /// to the instances; while neither these nor the bindings change, the result is shared.
    pub(crate) fn resolve(&mut self, snapshot: &Snapshot) -> Arc<[u32]> {
        let instances = || snapshot.instances().map(|instance| instance.id());
        if let Some(last) = &self.resolved
            && instances().eq(last.instances.iter().copied())
        {
            return last.surfaces.clone();
        }
        let surfaces: Arc<[u32]> = instances().map(|instance| self.surface(instance).unwrap_or(UNBOUND)).collect();
        self.resolved = Some(Resolved { instances: instances().collect(), surfaces: surfaces.clone() });
        surfaces
    }
}

#[cfg(test)]
mod tests {
    use kinetree::{Affine, Mesh, Motion, Scene};

    use super::*;

    #[test]
    fn bindings_follow_their_instances_and_leave_user_ids_alone() {
        let mut scene = Scene::new();
        let triangle = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]).expect("a good mesh");
        let mesh = scene.add_mesh(triangle, Motion::Rigid).expect("a mesh fits");
        let mut bindings = MaterialBindings::default();
        let ids: Vec<InstanceId> = (0..4)
            .map(|number| {
                let id = scene.add_instance(scene.root(), mesh, Affine::IDENTITY).expect("an instance fits");
                scene.set_user_id(id, 70 + number).expect("the instance lives");
                bindings.bind(id, 10 + number);
                id
            })
            .collect();
        let surfaces_by_id = |scene: &mut Scene, bindings: &mut MaterialBindings| -> Vec<(u32, u32)> {
            let snapshot = scene.commit();
            let surfaces = bindings.resolve(&snapshot);
            assert_eq!(surfaces.len(), snapshot.instances().len());
            snapshot.instances().map(|instance| (instance.user_id(), surfaces[instance.index() as usize])).collect()
        };
        assert_eq!(surfaces_by_id(&mut scene, &mut bindings), [(70, 10), (71, 11), (72, 12), (73, 13)]);

        // The same instances share the result; a binding that changes does not.
        let snapshot = scene.commit();
        let (first, second) = (bindings.resolve(&snapshot), bindings.resolve(&snapshot));
        assert!(Arc::ptr_eq(&first, &second));
        bindings.bind(ids[3], 99);
        assert_eq!(surfaces_by_id(&mut scene, &mut bindings)[3], (73, 99));

        // A new instance in the place of a removed one has no binding.
        scene.remove_instance(ids[1]).expect("the instance lives");
        let id = scene.add_instance(scene.root(), mesh, Affine::IDENTITY).expect("an instance fits");
        scene.set_user_id(id, 74).expect("the instance lives");
        let mut found = surfaces_by_id(&mut scene, &mut bindings);
        found.sort_unstable();
        assert_eq!(found, [(70, 10), (72, 12), (73, 99), (74, UNBOUND)]);
        assert_eq!((bindings.unbind(ids[1]), bindings.unbind(ids[1]), bindings.surface(id)), (Some(11), None, None));
    }
}
