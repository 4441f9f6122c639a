//! Nodes, and what is attached to them.

use serde::Deserialize;

use super::geometry::{Accessor, Mesh};
use super::{Index, List, Name};

/// The root nodes of what is shown.
#[derive(Deserialize)]
pub(crate) struct Scene {
    pub(crate) name: Option<Name>,
    /// The specification lets a scene be without nodes.
    #[serde(default)]
    pub(crate) nodes: List<Index<Node>>,
}

/// A node of the hierarchy. Properties that most nodes lack are boxed.
#[derive(Deserialize)]
pub(crate) struct Node {
    pub(crate) name: Option<Name>,
    pub(crate) camera: Option<Index<Camera>>,
    pub(crate) mesh: Option<Index<Mesh>>,
    pub(crate) skin: Option<Index<Skin>>,
    pub(crate) children: Option<Box<[Index<Node>]>>,
    pub(crate) weights: Option<Box<[f32]>>,
    /// Column by column.
    pub(crate) matrix: Option<Box<[f32; 16]>>,
    pub(crate) translation: Option<Box<[f32; 3]>>,
    /// x y z w.
    pub(crate) rotation: Option<Box<[f32; 4]>>,
    pub(crate) scale: Option<Box<[f32; 3]>>,
    pub(crate) extensions: Option<Box<NodeExtensions>>,
}

const _: () = assert!(size_of::<Node>() <= 104, "a node takes more memory than its text can justify");

impl Node {
    pub(crate) fn children(&self) -> impl Iterator<Item = Index<Node>> {
        self.children.iter().flatten().copied()
    }

    pub(crate) fn light(&self) -> Option<Index<Light>> {
        Some(self.extensions.as_ref()?.light.as_ref()?.light)
    }

    pub(crate) fn instancing(&self) -> Option<&Instancing> {
        self.extensions.as_ref()?.instancing.as_ref()
    }

    /// Whether KHR_node_visibility hides it and its descendants.
    pub(crate) fn is_hidden(&self) -> bool {
        let visibility = self.extensions.as_ref().and_then(|extensions| extensions.visibility.as_ref());
        visibility.is_some_and(|visibility| !visibility.visible)
    }
}

/// Extensions of nodes.
#[derive(Deserialize)]
pub(crate) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    light: Option<LightOfNode>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    visibility: Option<Visibility>,
}

/// KHR_lights_punctual of a node.
#[derive(Deserialize)]
struct LightOfNode {
    light: Index<Light>,
}

/// KHR_node_visibility.
#[derive(Deserialize)]
struct Visibility {
    #[serde(default = "yes")]
    visible: bool,
}

fn yes() -> bool {
    true
}

/// EXT_mesh_gpu_instancing.
#[derive(Deserialize)]
pub(crate) struct Instancing {
    pub(crate) attributes: InstanceAttributes,
}

/// One element per instance.
#[derive(Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) struct InstanceAttributes {
    pub(crate) translation: Option<Index<Accessor>>,
    pub(crate) rotation: Option<Index<Accessor>>,
    pub(crate) scale: Option<Index<Accessor>>,
}

/// Joints, and the matrices from the mesh to each of them.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Skin {
    pub(crate) name: Option<Name>,
    pub(crate) joints: Box<[Index<Node>]>,
    pub(crate) inverse_bind_matrices: Option<Index<Accessor>>,
}

/// A camera, in the space of its node.
#[derive(Deserialize)]
pub(crate) struct Camera {
    pub(crate) name: Option<Name>,
    pub(crate) perspective: Option<Perspective>,
}

/// A pinhole.
#[derive(Deserialize)]
pub(crate) struct Perspective {
    /// Radians.
    pub(crate) yfov: f32,
}

/// KHR_lights_punctual.
#[derive(Deserialize)]
pub(crate) struct Light {
    pub(crate) name: Option<Name>,
    #[serde(rename = "type")]
    pub(crate) kind: LightKind,
    #[serde(default = "white")]
    pub(crate) color: [f32; 3],
    #[serde(default = "one")]
    pub(crate) intensity: f32,
    pub(crate) range: Option<f32>,
    pub(crate) spot: Option<Spot>,
}

/// What kind of light it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum LightKind {
    Directional,
    Point,
    Spot,
    #[serde(other)]
    Unknown,
}

/// The cone of a spot light, radians.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Spot {
    pub(crate) inner_cone_angle: f32,
    pub(crate) outer_cone_angle: f32,
}

impl Default for Spot {
    fn default() -> Self {
        Self { inner_cone_angle: 0.0, outer_cone_angle: std::f32::consts::FRAC_PI_4 }
    }
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

fn one() -> f32 {
    1.0
}
