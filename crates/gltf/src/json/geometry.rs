//! Buffers, what lies in them, and meshes made of it.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};

use super::material::Material;
use super::{Index, Name};

/// Bytes.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Buffer {
    pub(crate) name: Option<Name>,
    pub(crate) uri: Option<Box<str>>,
    pub(crate) byte_length: u64,
}

/// A part of a buffer.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct View {
    pub(crate) name: Option<Name>,
    pub(crate) buffer: Index<Buffer>,
    #[serde(default)]
    pub(crate) byte_offset: u64,
    pub(crate) byte_length: u64,
    pub(crate) byte_stride: Option<u64>,
}

/// Numbers within a part of a buffer.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Accessor {
    pub(crate) name: Option<Name>,
    pub(crate) buffer_view: Option<Index<View>>,
    #[serde(default)]
    pub(crate) byte_offset: u64,
    /// See [`ComponentType`].
    pub(crate) component_type: u32,
    #[serde(default)]
    pub(crate) normalized: bool,
    pub(crate) count: u64,
    #[serde(rename = "type")]
    pub(crate) element_type: ElementType,
    pub(crate) sparse: Option<Box<Sparse>>,
}

/// Elements that replace those of an accessor.
#[derive(Deserialize)]
pub(crate) struct Sparse {
    pub(crate) count: u64,
    pub(crate) indices: SparseIndices,
    pub(crate) values: SparseValues,
}

/// Which elements are replaced.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SparseIndices {
    pub(crate) buffer_view: Index<View>,
    #[serde(default)]
    pub(crate) byte_offset: u64,
    /// See [`ComponentType`].
    pub(crate) component_type: u32,
}

/// By what they are replaced.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SparseValues {
    pub(crate) buffer_view: Index<View>,
    #[serde(default)]
    pub(crate) byte_offset: u64,
}

/// How many numbers an element has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) enum ElementType {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat2,
    Mat3,
    Mat4,
    #[serde(other)]
    Unknown,
}

/// How a number is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ComponentType {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl ComponentType {
    /// From OpenGL's number for it.
    pub(crate) fn of(number: u32) -> Option<Self> {
        Some(match number {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }
}

/// Primitives that belong together.
#[derive(Deserialize)]
pub(crate) struct Mesh {
    pub(crate) name: Option<Name>,
    pub(crate) primitives: Vec<Primitive>,
    pub(crate) weights: Option<Box<[f32]>>,
}

/// Triangles, lines or points of one material.
#[derive(Deserialize)]
pub(crate) struct Primitive {
    pub(crate) attributes: Attributes,
    pub(crate) indices: Option<Index<Accessor>>,
    pub(crate) material: Option<Index<Material>>,
    /// See [`Mode`].
    #[serde(default = "triangles")]
    pub(crate) mode: u32,
    pub(crate) targets: Option<Vec<Target>>,
}

/// A morph target.
#[derive(Deserialize)]
pub(crate) struct Target {
    #[serde(rename = "POSITION")]
    pub(crate) positions: Option<Index<Accessor>>,
    #[serde(rename = "NORMAL")]
    pub(crate) normals: Option<Index<Accessor>>,
}

/// What a primitive consists of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    Points,
    Lines,
    LineLoop,
    LineStrip,
    Triangles,
    TriangleStrip,
    TriangleFan,
}

fn triangles() -> u32 {
    4
}

impl Mode {
    /// From OpenGL's number for it.
    pub(crate) fn of(number: u32) -> Option<Self> {
        const ALL: [Mode; 7] = [
            Mode::Points,
            Mode::Lines,
            Mode::LineLoop,
            Mode::LineStrip,
            Mode::Triangles,
            Mode::TriangleStrip,
            Mode::TriangleFan,
        ];
        ALL.get(number as usize).copied()
    }
}

/// What an attribute is for. The number is that of its set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Semantic {
    Positions,
    Normals,
    TexCoords(u32),
    Colors(u32),
    Joints(u32),
    Weights(u32),
}

impl Semantic {
    fn of(name: &str) -> Option<Self> {
        match name {
            "POSITION" => return Some(Self::Positions),
            "NORMAL" => return Some(Self::Normals),
            _ => {}
        }
        let (kind, set) = name.rsplit_once('_')?;
        let set = set.parse().ok()?;
        Some(match kind {
            "TEXCOORD" => Self::TexCoords(set),
            "COLOR" => Self::Colors(set),
            "JOINTS" => Self::Joints(set),
            "WEIGHTS" => Self::Weights(set),
            _ => return None,
        })
    }
}

/// The attributes of a primitive whose meaning is known.
pub(crate) struct Attributes(BTreeMap<Semantic, Index<Accessor>>);

impl Attributes {
    pub(crate) fn get(&self, semantic: Semantic) -> Option<Index<Accessor>> {
        self.0.get(&semantic).copied()
    }
}

impl<'de> Deserialize<'de> for Attributes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Pairs;

        impl<'de> Visitor<'de> for Pairs {
            type Value = Attributes;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("attributes")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut pairs: A) -> Result<Attributes, A::Error> {
                let mut known = BTreeMap::new();
                while let Some((name, accessor)) = pairs.next_entry::<String, Index<Accessor>>()? {
                    if let Some(semantic) = Semantic::of(&name) {
                        known.insert(semantic, accessor);
                    }
                }
                Ok(Attributes(known))
            }
        }

        deserializer.deserialize_map(Pairs)
    }
}
