//! Materials, converted when a mesh that is shown asks for them.
//!
//! Reflection is diffuse for now, whatever the metalness and the roughness. Transmission makes a smooth dielectric: a
//! sheet without thickness, unless KHR_materials_volume says that there is something inside.

use gltf::json::Index;
use gltf::json::material::{AlphaMode, Material as MaterialJson};
use gltf::json::texture::Info;
use gltf::json::validation::Checked;
use kinetree_render::{Alpha, Material, Scatter, Texture, TextureRef};

use crate::document::Document;
use crate::error::{Item, Problem};
use crate::image::Textures;
use crate::notes::Notes;

/// The materials that meshes have asked for so far.
pub(crate) struct Materials<'a> {
    document: &'a Document,
    textures: Textures<'a>,
    converted: Vec<Material>,
    /// From a material of the file to its place in `converted`; the last is the default material.
    places: Vec<Option<u32>>,
}

impl<'a> Materials<'a> {
    pub(crate) fn new(document: &'a Document, textures: Textures<'a>) -> Self {
        Self { document, textures, converted: Vec::new(), places: vec![None; document.root.materials.len() + 1] }
    }

    pub(crate) fn get(&self, place: u32) -> &Material {
        &self.converted[place as usize]
    }

    pub(crate) fn into_look(self) -> (Vec<Material>, Vec<Texture>) {
        (self.converted, self.textures.into_textures())
    }

    /// The place of a material of the file, or of the default material.
    pub(crate) fn place(
        &mut self,
        index: Option<Index<MaterialJson>>,
        from: &Item,
        notes: &mut Notes,
    ) -> Result<u32, Problem> {
        let default = self.places.len() - 1;
        let slot = index.map_or(default, |index| index.value());
        let material = match index {
            Some(index) => self.document.get(index, "material", from)?,
            None => &MaterialJson::default(),
        };
        if let Some(place) = self.places[slot] {
            return Ok(place);
        }
        let converted = self.convert(material, slot, notes)?;
        let place = self.converted.len() as u32;
        self.converted.push(converted);
        self.places[slot] = Some(place);
        Ok(place)
    }

    fn convert(&mut self, json: &MaterialJson, index: usize, notes: &mut Notes) -> Result<Material, Problem> {
        let item = self.document.material_item(index);
        let pbr = &json.pbr_metallic_roughness;
        let strength = json.extensions.as_ref().and_then(|extensions| extensions.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
        let emission = json.emissive_factor.0.map(|channel| channel * strength);
        if !emission.iter().all(|&channel| channel.is_finite() && channel >= 0.0) {
            return Err(item.invalid("emits light that is negative or has no bound"));
        }
        if !pbr.base_color_factor.0.iter().all(|channel| channel.is_finite()) {
            return Err(item.invalid("has a base colour without bounds"));
        }
        let base_set = pbr.base_color_texture.as_ref().map(coordinate_set);
        let emissive_set = json.emissive_texture.as_ref().map(coordinate_set);
        if base_set.zip(emissive_set).is_some_and(|(base, emissive)| base != emissive) {
            notes.add(|| format!("{item}: its emissive texture uses the texture coordinates of the base colour"));
        }
        Ok(Material {
            base_color: pbr.base_color_factor.0.map(|channel| channel.clamp(0.0, 1.0)),
            base_color_texture: self.texture(pbr.base_color_texture.as_ref(), &item, notes)?,
            emission,
            emission_texture: self.texture(json.emissive_texture.as_ref(), &item, notes)?,
            alpha: alpha(json, &item)?,
            scatter: self.scatter(json, index, &item, notes),
            two_sided: json.double_sided,
        })
    }

    fn texture(&mut self, info: Option<&Info>, item: &Item, notes: &mut Notes) -> Result<Option<TextureRef>, Problem> {
        let Some(info) = info else { return Ok(None) };
        let Some(place) = self.textures.color(info.index, item, notes)? else { return Ok(None) };
        let mut texture = TextureRef::from(place);
        if let Some(transform) = info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref()) {
            texture.scale = transform.scale.0;
            texture.rotation = transform.rotation.0;
            texture.offset = transform.offset.0;
            let [a, b] = texture.scale;
            let [c, d] = texture.offset;
            if ![a, b, c, d, texture.rotation].iter().all(|number| number.is_finite()) {
                return Err(item.invalid("has a texture transform without bounds"));
            }
        }
        Ok(Some(texture))
    }

    fn scatter(&self, json: &MaterialJson, index: usize, item: &Item, notes: &mut Notes) -> Scatter {
        const ORDINARY_GLASS: f32 = 1.5;
        let Some(extensions) = &json.extensions else { return Scatter::Diffuse };
        let transmission = extensions.transmission.as_ref().map_or(0.0, |t| t.transmission_factor.0);
        if transmission > 0.0 && transmission < 1.0 {
            notes.add(|| format!("{item}: a transmission of {transmission} is taken for all or nothing"));
        }
        // A factor that is no number is none.
        if transmission.is_nan() || transmission < 0.5 {
            return Scatter::Diffuse;
        }
        let ior = extensions.ior.as_ref().map_or(ORDINARY_GLASS, |ior| ior.ior.0);
        let ior = if ior.is_finite() && ior >= 1.0 {
            ior
        } else {
            notes.add(|| format!("{item}: an index of refraction of {ior} is replaced by {ORDINARY_GLASS}"));
            ORDINARY_GLASS
        };
        match self.document.thickness.get(index) {
            Some(&thickness) if thickness > 0.0 => Scatter::Dielectric { ior },
            _ => Scatter::ThinDielectric { ior },
        }
    }
}

/// The set of texture coordinates that a material looks up with: that of its base colour, if it has one.
pub(crate) fn coordinate_set_of(material: &MaterialJson) -> u32 {
    let base = material.pbr_metallic_roughness.base_color_texture.as_ref();
    base.or(material.emissive_texture.as_ref()).map_or(0, coordinate_set)
}

fn coordinate_set(info: &Info) -> u32 {
    let transform = info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref());
    transform.and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord)
}

fn alpha(json: &MaterialJson, item: &Item) -> Result<Alpha, Problem> {
    match json.alpha_mode {
        Checked::Valid(AlphaMode::Opaque) => Ok(Alpha::Opaque),
        Checked::Valid(AlphaMode::Mask) => {
            let cutoff = json.alpha_cutoff.unwrap_or_default().0;
            if !cutoff.is_finite() {
                return Err(item.invalid("has an alpha cutoff without bounds"));
            }
            // A cutoff above one hides everything, which an alpha of at most one cannot reach.
            Ok(Alpha::Mask { cutoff: cutoff.max(0.0) })
        }
        Checked::Valid(AlphaMode::Blend) => Ok(Alpha::Blend),
        Checked::Invalid => Err(item.invalid("has an unknown alpha mode")),
    }
}
