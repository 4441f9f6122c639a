//! What a scene holds. `edit` changes it, `lookup` reads it, `commit` carries the edits out.

use std::fmt;

use super::graph::{Instance, Node};
use super::history::History;
use super::mesh_state::MeshState;
use super::slots::{Slots, fresh_scene_number};
use crate::handle::NodeId;
use crate::threads::Threads;

/// Meshes, and a hierarchy of nodes with instances of the meshes.
///
/// Every edit either succeeds or leaves the scene as it was. A snapshot never sees an edit that was
/// made after its commit.
pub struct Scene {
    pub(crate) meshes: Slots<MeshState>,
    pub(crate) nodes: Slots<Node>,
    pub(crate) instances: Slots<Instance>,
    pub(super) root: NodeId,
    pub(crate) threads: Threads,
    pub(crate) history: History,
}

/// In short: how much there is in it.
impl fmt::Debug for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Scene")
            .field("meshes", &self.meshes.iter().count())
            .field("nodes", &self.nodes.iter().count())
            .field("instances", &self.instances.iter().count())
            .finish_non_exhaustive()
    }
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}

impl Scene {
    /// An empty scene, which shares its work between all threads.
    pub fn new() -> Self {
        Self::with_threads(Threads::default())
    }

    /// An empty scene whose commits run on these threads.
    pub fn with_threads(threads: Threads) -> Self {
        let number = fresh_scene_number();
        let mut nodes = Slots::new(number);
        let root = nodes.insert(Node::root()).expect("an empty scene has room for its root");
        Self {
            meshes: Slots::new(number),
            nodes,
            instances: Slots::new(number),
            root: root.into(),
            threads,
            history: History::default(),
        }
    }

    /// The node that all other nodes descend from. It cannot be moved.
    pub fn root(&self) -> NodeId {
        self.root
    }

    /// Where commits run, from the next one on. The trees do not depend on it.
    pub fn set_threads(&mut self, threads: Threads) {
        self.threads = threads;
    }
}
