//! Handles: names of the meshes, nodes and instances of a scene, which stay recognisable as stale
//! once the thing is removed.

use std::fmt;

/// A slot, the generation of its value, and the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Handle {
    pub(crate) slot: u32,
    pub(crate) generation: u32,
    pub(crate) scene: u32,
}

impl Handle {
    /// No scene has the number 0, so this one is of another scene everywhere.
    const NOWHERE: Self = Self { slot: 0, generation: 0, scene: 0 };

    /// From the low end: slot, generation, scene and kind, 32 bits each.
    fn to_bits(self, kind: u32) -> u128 {
        let words = [self.slot, self.generation, self.scene, kind];
        words.into_iter().rev().fold(0, |bits, word| bits << 32 | u128::from(word))
    }

    fn from_bits(bits: u128, expected_kind: u32) -> Self {
        let [slot, generation, scene, kind] = [0, 32, 64, 96].map(|shift| (bits >> shift) as u32);
        if kind == expected_kind { Self { slot, generation, scene } } else { Self::NOWHERE }
    }
}

macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident = $kind:expr;)*) => {$(
        $(#[$doc])*
        ///
        /// A handle is valid in its own scene, as long as what it names is there. Otherwise scenes
        /// answer with [`StaleHandle`](crate::EditError::StaleHandle) or
        /// [`OtherScene`](crate::EditError::OtherScene).
        #[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub(crate) Handle);

        impl $name {
            const KIND: u32 = $kind;

            /// The handle as a number, to be stored where a `u128` fits: in another library's user
            /// data, in a script, across a foreign-function interface. It has no meaning in another
            /// process.
            pub fn to_bits(self) -> u128 {
                self.0.to_bits(Self::KIND)
            }

            /// The handle that [`to_bits`](Self::to_bits) gave these bits for. Any other bits are
            /// safe: what they name is stale or of another scene, unless they happen to be those of
            /// a handle in use.
            pub fn from_bits(bits: u128) -> Self {
                Self(Handle::from_bits(bits, Self::KIND))
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let Handle { slot, generation, scene } = self.0;
                write!(f, "{}({slot}, generation {generation}, scene {scene})", stringify!($name))
            }
        }

        /// As the four 32-bit words of [`to_bits`]($name::to_bits), the lowest first: numbers that
        /// every format keeps.
        #[cfg(feature = "serde")]
        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let bits = self.to_bits();
                [0, 32, 64, 96].map(|shift| (bits >> shift) as u32).serialize(serializer)
            }
        }

        #[cfg(feature = "serde")]
        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let words = <[u32; 4]>::deserialize(deserializer)?;
                let bits = words.into_iter().rev().fold(0, |bits, word| bits << 32 | u128::from(word));
                Ok(Self::from_bits(bits))
            }
        }

        impl From<Handle> for $name {
            fn from(handle: Handle) -> Self {
                Self(handle)
            }
        }
    )*};
}

handles! {
    /// A mesh of a scene.
    MeshId = 1;
    /// A node of a scene.
    NodeId = 2;
    /// An instance of a mesh in a scene.
    InstanceId = 3;
}

/// What has a placement: a node (in its parent) or an instance (in its node). It can be moved,
/// masked, numbered by the caller, and left out of queries.
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
