//! Materials, converted when a mesh that is shown uses them.
//!
//! Reflection is diffuse for now, whatever the metalness and the roughness; the notes list the
//! properties of the file that are ignored. Transmission makes a smooth dielectric: a sheet without
//! thickness, unless KHR_materials_volume says that there is something inside.

use kinetree_world::{Alpha, Material, Scatter, Texture, TextureRef};

use crate::document::Document;
use crate::error::{Item, Problem};
use crate::extensions;
use crate::image::Textures;
use crate::json::{self, AlphaMode, Index, TextureInfo};
use crate::notes::Notes;

/// The materials that meshes have used so far.
pub(crate) struct Materials<'a> {
    document: &'a Document,
    textures: Textures<'a>,
    converted: Vec<Material>,
    /// From a material of the file to its index in `converted`; the last is the default material.
    indices: Vec<Option<u32>>,
}

impl<'a> Materials<'a> {
    pub(crate) fn new(document: &'a Document, textures: Textures<'a>) -> Self {
        Self { document, textures, converted: Vec::new(), indices: vec![None; document.root.materials.len() + 1] }
    }

    /// Whether a ray can pass through a triangle of a material because of its alpha, where vertex
    /// colours have an alpha of at least `vertex_alpha`.
    pub(crate) fn has_holes(&self, index: u32, vertex_alpha: f32) -> bool {
        let material = &self.converted[index as usize];
        let texture = material.base_color_texture.map_or(1.0, |texture| self.textures.least_alpha(texture.texture));
        let alpha = material.base_color[3] * texture * vertex_alpha;
        match material.alpha {
            Alpha::Opaque => false,
            Alpha::Mask { cutoff } => alpha < cutoff,
            Alpha::Blend => alpha < 1.0,
        }
    }

    pub(crate) fn into_parts(self) -> (Vec<Material>, Vec<Texture>) {
        (self.converted, self.textures.into_textures())
    }

    /// The index in `converted` of a material of the file, or of the default material.
    pub(crate) fn index_of(
        &mut self,
        index: Option<Index<json::Material>>,
        from: &Item,
        notes: &mut Notes,
    ) -> Result<u32, Problem> {
        let default = self.indices.len() - 1;
        let slot = index.map_or(default, Index::value);
        let material = match index {
            Some(index) => self.document.get(index, "material", from)?,
            None => &json::Material::default(),
        };
        if let Some(converted_index) = self.indices[slot] {
            return Ok(converted_index);
        }
        let converted = self.convert(material, slot, notes)?;
        let converted_index = self.converted.len() as u32;
        self.converted.push(converted);
        self.indices[slot] = Some(converted_index);
        Ok(converted_index)
    }

    fn convert(&mut self, json: &json::Material, index: usize, notes: &mut Notes) -> Result<Material, Problem> {
        let item = self.document.material_item(index);
        let strength = json.extensions.as_ref().and_then(|extensions| extensions.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| strength.emissive_strength);
        let emission = json.emissive_factor.map(|channel| channel * strength);
        if !emission.iter().all(|&channel| channel.is_finite() && channel >= 0.0) {
            return Err(item.invalid("emits light that is negative or has no bound"));
        }
        let base_color = json.base_color();
        if !base_color.iter().all(|channel| channel.is_finite()) {
            return Err(item.invalid("has a base colour without bounds"));
        }
        note_ignored_properties(json, &item, notes);
        Ok(Material {
            base_color: base_color.map(|channel| channel.clamp(0.0, 1.0)),
            base_color_texture: self.texture(json.base_color_texture(), &item, notes)?,
            emission,
            emission_texture: self.texture(json.emissive_texture.as_deref(), &item, notes)?,
            alpha: alpha(json, &item)?,
            scatter: scatter(json, &item, notes),
            two_sided: json.double_sided,
        })
    }

    fn texture(
        &mut self,
        info: Option<&TextureInfo>,
        item: &Item,
        notes: &mut Notes,
    ) -> Result<Option<TextureRef>, Problem> {
        let Some(info) = info else { return Ok(None) };
        let Some(texture) = self.textures.color(info.index, item, notes) else { return Ok(None) };
        let mut texture = TextureRef::from(texture);
        if let Some(transform) = info.transform() {
            texture.scale = transform.scale;
            texture.rotation = transform.rotation;
            texture.offset = transform.offset;
            let [a, b] = texture.scale;
            let [c, d] = texture.offset;
            if ![a, b, c, d, texture.rotation].iter().all(|number| number.is_finite()) {
                return Err(item.invalid("has a texture transform without bounds"));
            }
        }
        Ok(Some(texture))
    }
}

/// Whether light passes through: all of it, or none.
fn is_transmissive(json: &json::Material) -> bool {
    let transmission = json.extensions.as_ref().and_then(|extensions| extensions.transmission.as_ref());
    // A factor that is NaN counts as zero.
    transmission.is_some_and(|transmission| transmission.transmission_factor >= 0.5)
}

fn scatter(json: &json::Material, item: &Item, notes: &mut Notes) -> Scatter {
    const DEFAULT_IOR: f32 = 1.5;
    let Some(extensions) = json.extensions.as_ref().filter(|_| is_transmissive(json)) else { return Scatter::Diffuse };
    let ior = extensions.ior.as_ref().map_or(DEFAULT_IOR, |ior| ior.ior);
    let ior = if ior.is_finite() && ior >= 1.0 {
        ior
    } else {
        notes.add(|| format!("{item}: an index of refraction of {ior} is replaced by {DEFAULT_IOR}"));
        DEFAULT_IOR
    };
    match &extensions.volume {
        Some(volume) if volume.thickness_factor > 0.0 => Scatter::Dielectric { ior },
        _ => Scatter::ThinDielectric { ior },
    }
}

/// Notes the properties of a material that are ignored.
fn note_ignored_properties(json: &json::Material, item: &Item, notes: &mut Notes) {
    let mut ignored = |has_it: bool, what: &str, consequence| {
        if has_it {
            notes.ignored(what, consequence, Some(item));
        }
    };
    let glass = is_transmissive(json);
    if let Some(pbr) = &json.pbr {
        // A material without a metallic factor is a metal, as the specification has it; glass never
        // is.
        let metallic = pbr.metallic_factor.unwrap_or(1.0) > 0.0;
        ignored(metallic && !glass, "metalness", "metals reflect diffusely");
        let glossy = pbr.roughness_factor.is_some_and(|roughness| roughness < 1.0);
        ignored((glossy || pbr.metallic_roughness_texture) && !glass, "roughness", "smooth surfaces reflect diffusely");
        let rough = pbr.roughness_factor.unwrap_or(1.0) > 0.0;
        ignored(rough && glass, "the roughness of glass", "rough glass is clear");
    }
    ignored(json.normal_texture, "a normal texture", "surfaces are as smooth as their geometry");
    let sets =
        [json.base_color_texture(), json.emissive_texture.as_deref()].map(|info| info.map(TextureInfo::coordinate_set));
    let differ = matches!(sets, [Some(base), Some(emissive)] if base != emissive);
    ignored(
        differ,
        "a second set of texture coordinates",
        "emissive textures are looked up with the coordinates of the base colour",
    );
    let Some(extensions) = &json.extensions else { return };
    if let Some(transmission) = &extensions.transmission {
        let factor = transmission.transmission_factor;
        ignored(factor > 0.0 && factor < 1.0, "transmission in part", "all light passes, or none");
        ignored(transmission.transmission_texture, "a texture of transmission", "all light passes, or none");
    }
    if let Some(volume) = &extensions.volume {
        let absorbs = volume.attenuation_distance.is_some_and(f32::is_finite);
        ignored(absorbs, "absorption in a volume", "thick glass is as clear as thin glass");
    }
    for (has_it, name) in [
        (extensions.unlit, "KHR_materials_unlit"),
        (extensions.specular, "KHR_materials_specular"),
        (extensions.clearcoat, "KHR_materials_clearcoat"),
        (extensions.sheen, "KHR_materials_sheen"),
        (extensions.iridescence, "KHR_materials_iridescence"),
        (extensions.anisotropy, "KHR_materials_anisotropy"),
        (extensions.dispersion, "KHR_materials_dispersion"),
        (extensions.diffuse_transmission, "KHR_materials_diffuse_transmission"),
        (extensions.specular_glossiness, "KHR_materials_pbrSpecularGlossiness"),
    ] {
        if has_it {
            extensions::note_ignored_one(name, Some(item), notes);
        }
    }
}

/// The set of texture coordinates that a material looks up with: that of its base colour, if it has
/// one.
pub(crate) fn coordinate_set_of(material: &json::Material) -> u32 {
    let base = material.base_color_texture();
    base.or(material.emissive_texture.as_deref()).map_or(0, TextureInfo::coordinate_set)
}

fn alpha(json: &json::Material, item: &Item) -> Result<Alpha, Problem> {
    match json.alpha_mode {
        AlphaMode::Opaque => Ok(Alpha::Opaque),
        AlphaMode::Mask => {
            let cutoff = json.alpha_cutoff.unwrap_or(0.5);
            if !cutoff.is_finite() {
                return Err(item.invalid("has an alpha cutoff without bounds"));
            }
            // A cutoff above one hides everything, since alpha is at most one.
            Ok(Alpha::Mask { cutoff: cutoff.max(0.0) })
        }
        AlphaMode::Blend => Ok(Alpha::Blend),
        AlphaMode::Unknown => Err(item.invalid("has an unknown alpha mode")),
    }
}
