//! The JSON of a file, and looking things up in it.
//!
//! The structure comes from the `gltf` crate. Its own validation trusts some of the indices that it checks, so every
//! reference is followed through [`Document::get`] instead.

use gltf::json::root::Get;
use gltf::json::{self, Index, Root, Value};

use crate::error::{Item, Problem, Quoted};
use crate::notes::Notes;

/// A parsed file.
pub(crate) struct Document {
    pub(crate) root: Root,
    /// Of each material, metres; 0 for a surface that is infinitely thin (KHR_materials_volume).
    pub(crate) thickness: Vec<f32>,
    /// Of each mesh, as [`Document::target_count`] gives it.
    target_counts: Vec<usize>,
}

const FOLLOWED_EXTENSIONS: [&str; 7] = [
    "KHR_lights_punctual",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_volume",
];

/// Extensions that change no more than how a surface reflects.
const HARMLESS_EXTENSIONS: [&str; 9] = [
    "KHR_materials_unlit",
    "KHR_materials_specular",
    "KHR_materials_clearcoat",
    "KHR_materials_sheen",
    "KHR_materials_iridescence",
    "KHR_materials_anisotropy",
    "KHR_materials_dispersion",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_variants",
];

impl Document {
    pub(crate) fn parse(text: &[u8], notes: &mut Notes) -> Result<Self, Problem> {
        let broken = |error: serde_json::Error| Problem::Json(Quoted::bare(&error.to_string()));
        let mut value: Value = serde_json::from_slice(text).map_err(broken)?;
        let thickness = thickness(&value);
        complete_scenes(&mut value);
        drop_channels_without_node(&mut value, notes);
        let root: Root = serde_json::from_value(value).map_err(broken)?;
        if root.asset.version.split('.').next() != Some("2") {
            return Err(Problem::Json(Quoted::bare(&format!("its version is {:?}", root.asset.version))));
        }
        for name in root.extensions_required.iter().filter(|name| !FOLLOWED_EXTENSIONS.contains(&name.as_str())) {
            if !HARMLESS_EXTENSIONS.contains(&name.as_str()) {
                return Err(Problem::Extension(Quoted::new(name)));
            }
            notes.add(|| format!("the required extension {name} is ignored: it only changes how surfaces reflect"));
        }
        let target_counts = root.meshes.iter().map(target_count).collect();
        Ok(Self { root, thickness, target_counts })
    }

    /// What `from` refers to.
    pub(crate) fn get<T>(&self, index: Index<T>, kind: &'static str, from: &Item) -> Result<&T, Problem>
    where
        Root: Get<T> + AsRef<[T]>,
    {
        let all: &[T] = self.root.as_ref();
        let missing = || Problem::NoSuch { from: from.clone(), kind, index: index.value(), count: all.len() };
        all.get(index.value()).ok_or_else(missing)
    }

    /// How many morph targets a mesh has: as many as that primitive which has most, whether or not it can be shown.
    /// Targets, weights and key frames all go by this count.
    pub(crate) fn target_count(&self, mesh: usize) -> usize {
        self.target_counts.get(mesh).copied().unwrap_or(0)
    }

    pub(crate) fn node_item(&self, index: usize) -> Item {
        Item::named("node", index, self.root.nodes.get(index).and_then(|node: &json::Node| node.name.as_ref()))
    }

    pub(crate) fn mesh_item(&self, index: usize) -> Item {
        Item::named("mesh", index, self.root.meshes.get(index).and_then(|mesh| mesh.name.as_ref()))
    }

    pub(crate) fn material_item(&self, index: usize) -> Item {
        Item::named("material", index, self.root.materials.get(index).and_then(|material| material.name.as_ref()))
    }
}

fn target_count(mesh: &json::Mesh) -> usize {
    let of_primitive = |primitive: &json::mesh::Primitive| primitive.targets.as_ref().map_or(0, Vec::len);
    mesh.primitives.iter().map(of_primitive).max().unwrap_or(0)
}

fn thickness(value: &Value) -> Vec<f32> {
    let materials = value.get("materials").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let of = |material: &Value| {
        let volume = material.get("extensions")?.get("KHR_materials_volume")?;
        volume.get("thicknessFactor")?.as_f64()
    };
    materials.iter().map(|material| of(material).unwrap_or(0.0) as f32).collect()
}

/// The specification lets a scene be without nodes; the `gltf` crate does not.
fn complete_scenes(value: &mut Value) {
    for scene in array_mut(value, "scenes").into_iter().flatten().filter_map(Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
    }
}

/// A channel without a node is meant for an extension, and is to be ignored; the `gltf` crate does not know it.
fn drop_channels_without_node(value: &mut Value, notes: &mut Notes) {
    for (index, animation) in array_mut(value, "animations").into_iter().flatten().enumerate() {
        let Some(channels) = array_mut(animation, "channels") else { continue };
        channels.retain(|channel| {
            let kept = channel.get("target").is_none_or(|target| target.get("node").is_some());
            if !kept {
                notes.add(|| format!("animation {index}: a channel without a node is ignored"));
            }
            kept
        });
    }
}

fn array_mut<'a>(value: &'a mut Value, key: &str) -> Option<&'a mut Vec<Value>> {
    value.get_mut(key)?.as_array_mut()
}
