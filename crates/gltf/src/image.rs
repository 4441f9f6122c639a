//! Textures: the images of materials, each decoded once and stored with the sampler that it is used
//! with.
//!
//! A texture whose image is missing, damaged or too large is left out, with a note; the file is
//! loaded all the same.

use std::borrow::Cow;
use std::collections::HashMap;

use kinetree_world::{Filter, Texture, Wrap};

use crate::accessor::Accessors;
use crate::container::Container;
use crate::document::Document;
use crate::error::{Item, Problem};
use crate::json::{self, Index, Sampler};
use crate::notes::Notes;
use crate::pixels::Encoded;

/// The textures that materials have used so far.
pub(crate) struct Textures<'a> {
    document: &'a Document,
    container: &'a Container,
    accessors: &'a Accessors<'a>,
    /// How many bytes further textures may take.
    bytes_left: u64,
    loaded: Vec<Texture>,
    /// Of each loaded texture, the smallest alpha of any texel, in 0..=1.
    least_alpha: Vec<f32>,
    /// From a texture's image and how it is sampled to its index in `loaded`; `None` if it could
    /// not be loaded.
    indices: HashMap<(usize, [u8; 3]), Option<u32>>,
    /// From an image to the first index in `loaded` that has it; `None` if it could not be decoded.
    decoded: HashMap<usize, Option<u32>>,
}

impl<'a> Textures<'a> {
    /// No textures yet; all of them together will take at most `max_bytes`.
    pub(crate) fn new(
        document: &'a Document,
        container: &'a Container,
        accessors: &'a Accessors<'a>,
        max_bytes: u64,
    ) -> Self {
        Self {
            document,
            container,
            accessors,
            bytes_left: max_bytes,
            loaded: Vec::new(),
            least_alpha: Vec::new(),
            indices: HashMap::new(),
            decoded: HashMap::new(),
        }
    }

    /// In the order of their indices.
    pub(crate) fn into_textures(self) -> Vec<Texture> {
        self.loaded
    }

    /// The smallest alpha of a loaded texture, in 0..=1.
    pub(crate) fn least_alpha(&self, loaded_index: u32) -> f32 {
        self.least_alpha[loaded_index as usize]
    }

    /// The index of a colour texture among the loaded ones; `None`, and a note, if it cannot be
    /// loaded.
    pub(crate) fn color(&mut self, index: Index<json::Texture>, from: &Item, notes: &mut Notes) -> Option<u32> {
        let texture = match self.document.get(index, "texture", from) {
            Ok(texture) => texture,
            Err(problem) => {
                notes.add(|| format!("{problem}; the texture is left out"));
                return None;
            }
        };
        let item = Item::named("texture", index.value(), texture.name.as_deref());
        let Some(image) = texture.source else {
            notes.add(|| format!("{item} has no image that is known, and is left out"));
            return None;
        };
        let sampler = texture.sampler.map(|sampler| self.document.get(sampler, "sampler", &item)).transpose();
        let sampler = sampler.unwrap_or_else(|problem| {
            notes.add(|| format!("{problem}; the texture is sampled as if it named none"));
            None
        });
        let (wrap, filter) = sampler.map(sampling).unwrap_or_default();
        let key = (image.value(), [wrap[0] as u8, wrap[1] as u8, filter as u8]);
        if let Some(&loaded_index) = self.indices.get(&key) {
            return loaded_index;
        }
        let loaded_index = self.load(image, wrap, filter, &item, notes);
        self.indices.insert(key, loaded_index);
        loaded_index
    }

    /// Adds an image with a sampler to the loaded textures.
    fn load(
        &mut self,
        image: Index<json::Image>,
        wrap: [Wrap; 2],
        filter: Filter,
        from: &Item,
        notes: &mut Notes,
    ) -> Option<u32> {
        let texture = match self.decoded.get(&image.value()) {
            Some(&known) => self.copy(known?, image, from),
            None => self.decode(image, from),
        };
        let texture = match texture {
            Ok(texture) => texture,
            Err(problem) => {
                notes.add(|| format!("{problem}; the texture is left out"));
                self.decoded.entry(image.value()).or_insert(None);
                return None;
            }
        };
        let loaded_index = self.loaded.len() as u32;
        let least = texture.texels.iter().map(|texel| texel[3]).min().unwrap_or(u8::MAX);
        self.least_alpha.push(f32::from(least) / 255.0);
        self.loaded.push(Texture { wrap, filter, ..texture });
        self.decoded.entry(image.value()).or_insert(Some(loaded_index));
        Some(loaded_index)
    }

    /// The same image for another sampler.
    fn copy(&mut self, loaded_index: u32, image: Index<json::Image>, from: &Item) -> Result<Texture, Problem> {
        let (width, height) = (self.loaded[loaded_index as usize].width, self.loaded[loaded_index as usize].height);
        let item = self.document.get(image, "image", from).map(|json| image_item(image, json))?;
        self.spend(width, height, &item)?;
        Ok(self.loaded[loaded_index as usize].clone())
    }

    fn decode(&mut self, index: Index<json::Image>, from: &Item) -> Result<Texture, Problem> {
        let image = self.document.get(index, "image", from)?;
        let item = image_item(index, image);
        let bytes = match (image.buffer_view, &image.uri) {
            (Some(view), _) => Cow::Borrowed(self.accessors.view(view, &item)?),
            (None, Some(uri)) => {
                Cow::Owned(self.container.fetch(uri).map_err(|problem| item.invalid(problem.to_string()))?)
            }
            (None, None) => return Err(item.invalid("has neither a buffer view nor a URI")),
        };
        let encoded = Encoded::new(&bytes).map_err(|reason| item.invalid(reason))?;
        let [width, height] = encoded.size();
        self.spend(width, height, &item)?;
        let texels = encoded.texels().map_err(|reason| item.invalid(reason))?;
        Ok(Texture { width, height, texels, srgb: true, wrap: Default::default(), filter: Default::default() })
    }

    /// Subtracts the memory of an image from what is left.
    fn spend(&mut self, width: u32, height: u32, item: &Item) -> Result<(), Problem> {
        let bytes = 4 * u64::from(width) * u64::from(height);
        let left = self.bytes_left.checked_sub(bytes).ok_or_else(|| {
            let left = self.bytes_left;
            item.invalid(format!("needs {bytes} bytes, where textures may take {left} more (max_texture_bytes)"))
        })?;
        self.bytes_left = left;
        Ok(())
    }
}

fn image_item(index: Index<json::Image>, image: &json::Image) -> Item {
    Item::named("image", index.value(), image.name.as_deref())
}

fn sampling(sampler: &Sampler) -> ([Wrap; 2], Filter) {
    const NEAREST: u32 = 9728;
    const NEAREST_MIPMAP_NEAREST: u32 = 9984;
    const CLAMP_TO_EDGE: u32 = 33071;
    const MIRRORED_REPEAT: u32 = 33648;
    let wrap = |mode: Option<u32>| match mode {
        Some(CLAMP_TO_EDGE) => Wrap::Clamp,
        Some(MIRRORED_REPEAT) => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    // The filter for magnification decides; at a distance, the samples of a pixel are averaged
    // anyway.
    let filter = match (sampler.mag_filter, sampler.min_filter) {
        (Some(NEAREST), _) | (None, Some(NEAREST | NEAREST_MIPMAP_NEAREST)) => Filter::Nearest,
        _ => Filter::Bilinear,
    };
    ([wrap(sampler.wrap_s), wrap(sampler.wrap_t)], filter)
}
