//! Names for things in a scene that notice when the thing is gone.

/// Which thing, of which scene, and which of those that stood in its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Handle {
    pub(crate) slot: u32,
    pub(crate) generation: u32,
    pub(crate) scene: u32,
}

macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub(crate) Handle);

        impl From<Handle> for $name {
            fn from(handle: Handle) -> Self {
                Self(handle)
            }
        }
    )*};
}

handles! {
    /// A mesh of a scene.
    MeshId
    /// A node of a scene.
    NodeId
    /// An instance of a mesh in a scene.
    InstanceId
}

/// What can be placed, masked, numbered and excluded: a node (in its parent) or an instance (in its
/// node).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Placed {
    /// A node.
    Node(NodeId),
    /// An instance.
    Instance(InstanceId),
}

impl From<NodeId> for Placed {
    fn from(id: NodeId) -> Self {
        Self::Node(id)
    }
}

impl From<InstanceId> for Placed {
    fn from(id: InstanceId) -> Self {
        Self::Instance(id)
    }
}
