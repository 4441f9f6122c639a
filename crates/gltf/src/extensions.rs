//! Extensions: which are supported, which may be ignored though a file requires them, and which are
//! ignored.

use crate::error::{Item, Problem, Quoted};
use crate::json::Root;
use crate::notes::Notes;

const SUPPORTED: [&str; 8] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_volume",
];

/// Extensions that change no more than how a surface reflects: a file that requires one is shown
/// without it.
const OPTIONAL: [&str; 9] = [
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

/// What follows when an extension is ignored.
const CONSEQUENCES: [(&str, &str); 18] = [
    ("KHR_materials_unlit", "unlit materials are lit as all others are"),
    ("KHR_materials_specular", "reflection is diffuse"),
    ("KHR_materials_clearcoat", "nothing has a clear coat"),
    ("KHR_materials_sheen", "nothing has a sheen"),
    ("KHR_materials_iridescence", "nothing is iridescent"),
    ("KHR_materials_anisotropy", "reflection is diffuse"),
    ("KHR_materials_dispersion", "glass refracts all colours alike"),
    ("KHR_materials_diffuse_transmission", "no light passes through diffuse surfaces"),
    ("KHR_materials_pbrSpecularGlossiness", "its colours and textures are not shown"),
    ("KHR_materials_variants", "the default variant is shown"),
    ("KHR_animation_pointer", "what only it animates stands still"),
    ("KHR_node_visibility", "hidden nodes are shown"),
    ("EXT_lights_image_based", "the environment gives no light"),
    ("EXT_lights_ies", "its lights are left out"),
    ("KHR_texture_basisu", "textures show their other image, if they have one"),
    ("EXT_texture_webp", "textures show their other image, if they have one"),
    ("KHR_draco_mesh_compression", "meshes are read from their uncompressed data"),
    ("EXT_meshopt_compression", "meshes are read from their uncompressed data"),
];

/// Notes the extensions of the file that are not supported.
///
/// # Errors
/// A required extension without which the scene cannot be shown.
pub(crate) fn note_ignored(root: &Root, notes: &mut Notes) -> Result<(), Problem> {
    for name in root.extensions_required.iter().filter(|name| !is_supported(name)) {
        if !OPTIONAL.contains(&&**name) {
            return Err(Problem::Extension(Quoted::new(name)));
        }
    }
    for name in root.extensions_used.iter().chain(root.extensions_required.iter()).filter(|name| !is_supported(name)) {
        note_ignored_one(name, None, notes);
    }
    Ok(())
}

/// Notes an extension that is ignored, perhaps in one of the items that have it.
pub(crate) fn note_ignored_one(name: &str, of: Option<&Item>, notes: &mut Notes) {
    let known = CONSEQUENCES.iter().find(|(known, _)| *known == name);
    let consequence = known.map_or("whatever it adds is missing", |(_, consequence)| consequence);
    notes.ignored(&format!("the extension {}", Quoted::bare(name)), consequence, of);
}

fn is_supported(name: &str) -> bool {
    SUPPORTED.contains(&name)
}
