//! The JSON of a file as structures, with the properties that this crate reads.
//!
//! glTF 2.0 specification, section 5 (properties reference). Everything is read straight from the
//! text, without a tree of values in between, and what is not read is skipped, so that no text
//! takes more than about fifty times its size: see `tests/memory.rs`. Nothing here is validated:
//! indices may be out of range, numbers may have any value.

mod animation;
mod geometry;
mod index;
mod list;
mod material;
mod scene;

use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny};

pub(crate) use self::animation::{Animation, Channel, Interpolation, Path};
pub(crate) use self::geometry::{
    Accessor, Buffer, ComponentType, ElementType, Mesh, Mode, Primitive, Semantic, Sparse, View,
};
pub(crate) use self::index::Index;
pub(crate) use self::list::List;
pub(crate) use self::material::{AlphaMode, Image, Material, Sampler, Texture, TextureInfo};
pub(crate) use self::scene::{Camera, Instancing, Light, LightKind, Node, Scene, Skin};

/// A whole file.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Root {
    pub(crate) asset: Asset,
    #[serde(default)]
    pub(crate) accessors: List<Accessor>,
    #[serde(default)]
    pub(crate) animations: List<Animation>,
    #[serde(default)]
    pub(crate) buffers: List<Buffer>,
    #[serde(default)]
    pub(crate) buffer_views: List<View>,
    #[serde(default)]
    pub(crate) cameras: List<Camera>,
    #[serde(default)]
    pub(crate) images: List<Image>,
    #[serde(default)]
    pub(crate) materials: List<Material>,
    #[serde(default)]
    pub(crate) meshes: List<Mesh>,
    #[serde(default)]
    pub(crate) nodes: List<Node>,
    #[serde(default)]
    pub(crate) samplers: List<Sampler>,
    pub(crate) scene: Option<Index<Scene>>,
    #[serde(default)]
    pub(crate) scenes: List<Scene>,
    #[serde(default)]
    pub(crate) skins: List<Skin>,
    #[serde(default)]
    pub(crate) textures: List<Texture>,
    #[serde(default)]
    pub(crate) extensions_used: List<Name>,
    #[serde(default)]
    pub(crate) extensions_required: List<Name>,
    #[serde(default)]
    pub(crate) extensions: RootExtensions,
}

/// A name as written in the file.
pub(crate) type Name = Box<str>;

/// The version of the format.
#[derive(Deserialize)]
pub(crate) struct Asset {
    pub(crate) version: Name,
}

/// Extensions of the file as a whole.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(crate) struct RootExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(crate) lights: Lights,
}

/// KHR_lights_punctual of a file.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(crate) struct Lights {
    pub(crate) lights: List<Light>,
}

/// What a file has an array of.
pub(crate) trait Element: Sized {
    fn all(root: &Root) -> &List<Self>;
}

macro_rules! elements {
    ($($element:ty: $($field:ident).+;)*) => {
        $(impl Element for $element {
            fn all(root: &Root) -> &List<Self> {
                &root.$($field).+
            }
        })*
    };
}

elements! {
    Accessor: accessors;
    Buffer: buffers;
    View: buffer_views;
    Camera: cameras;
    Image: images;
    Light: extensions.lights.lights;
    Material: materials;
    Mesh: meshes;
    Node: nodes;
    Sampler: samplers;
    Scene: scenes;
    Skin: skins;
    Texture: textures;
}

/// Whether something is there, whatever it is.
fn present<'de, D: Deserializer<'de>>(deserializer: D) -> Result<bool, D::Error> {
    Ok(Option::<IgnoredAny>::deserialize(deserializer)?.is_some())
}
