//! Images as textures: PNG and JPEG, each decoded once.

use std::collections::HashMap;
use std::io::Cursor;

use gltf::json::texture::{MagFilter, MinFilter, Sampler, Texture as TextureJson, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Image, Index};
use image::error::ImageError;
use image::{ImageReader, Limits};
use kinetree_render::{Filter, Texture, Wrap};

use crate::accessor::Accessors;
use crate::budget::Budget;
use crate::document::Document;
use crate::error::{Item, Problem};
use crate::notes::Notes;
use crate::source::Source;

/// Pixels along either side; more is taken for an attack.
const LARGEST_SIDE: u32 = 1 << 14;

/// The textures that materials have asked for so far.
pub(crate) struct Textures<'a> {
    document: &'a Document,
    source: &'a Source,
    accessors: &'a Accessors<'a>,
    budget: &'a Budget,
    loaded: Vec<Texture>,
    /// From an image and how it is sampled to its place in `loaded`; `None` for an image of an unknown format.
    places: HashMap<(usize, [u8; 3]), Option<u32>>,
    /// From an image to the first place where it is in `loaded`.
    decoded: HashMap<usize, u32>,
}

impl<'a> Textures<'a> {
    pub(crate) fn new(
        document: &'a Document,
        source: &'a Source,
        accessors: &'a Accessors<'a>,
        budget: &'a Budget,
    ) -> Self {
        Self {
            document,
            source,
            accessors,
            budget,
            loaded: Vec::new(),
            places: HashMap::new(),
            decoded: HashMap::new(),
        }
    }

    /// In the order in which they were asked for.
    pub(crate) fn into_textures(self) -> Vec<Texture> {
        self.loaded
    }

    /// The place of a colour texture among the loaded ones; `None` if it has no image of a known format.
    pub(crate) fn color(
        &mut self,
        index: Index<TextureJson>,
        from: &Item,
        notes: &mut Notes,
    ) -> Result<Option<u32>, Problem> {
        let texture = self.document.get(index, "texture", from)?;
        let item = Item::named("texture", index.value(), texture.name.as_ref());
        if texture.source.value() == u32::MAX as usize {
            notes.add(|| format!("{item} has no image that is known, and is left out"));
            return Ok(None);
        }
        let (wrap, filter) = match texture.sampler {
            Some(sampler) => sampling(self.document.get(sampler, "sampler", &item)?),
            None => Default::default(),
        };
        let key = (texture.source.value(), [wrap[0] as u8, wrap[1] as u8, filter as u8]);
        if let Some(&place) = self.places.get(&key) {
            return Ok(place);
        }
        let place = match self.decode(texture.source, &item, notes)? {
            Some(image) => {
                let place = self.loaded.len() as u32;
                self.loaded.push(Texture { wrap, filter, ..image });
                self.decoded.entry(key.0).or_insert(place);
                Some(place)
            }
            None => None,
        };
        self.places.insert(key, place);
        Ok(place)
    }

    fn decode(&self, index: Index<Image>, from: &Item, notes: &mut Notes) -> Result<Option<Texture>, Problem> {
        let image = self.document.get(index, "image", from)?;
        let item = Item::named("image", index.value(), image.name.as_ref());
        if let Some(known) = self.decoded.get(&index.value()).map(|&place| &self.loaded[place as usize]) {
            self.budget.spend_texels(known.texels.len() as u64, &item)?;
            return Ok(Some(known.clone()));
        }
        let fetched;
        let bytes = match (image.buffer_view, &image.uri) {
            (Some(view), _) => self.accessors.view(view, &item)?,
            (None, Some(uri)) => {
                fetched = self.source.fetch(uri)?;
                &fetched
            }
            (None, None) => return Err(item.invalid("has neither a buffer view nor a URI")),
        };
        let broken = |error: ImageError| item.invalid(format!("cannot be decoded: {error}"));
        let reader = || ImageReader::new(Cursor::new(bytes)).with_guessed_format().expect("a slice can be read");
        let (width, height) = match reader().into_dimensions() {
            Ok(size) => size,
            Err(ImageError::Unsupported(_)) => {
                notes.add(|| format!("{item} is neither PNG nor JPEG, and is left out"));
                return Ok(None);
            }
            Err(error) => return Err(broken(error)),
        };
        if width == 0 || height == 0 || width.max(height) > LARGEST_SIDE {
            return Err(item.invalid(format!("has a size of {width} x {height}")));
        }
        self.budget.spend_texels(u64::from(width) * u64::from(height), &item)?;
        let mut reader = reader();
        let mut limits = Limits::default();
        limits.max_image_width = Some(LARGEST_SIDE);
        limits.max_image_height = Some(LARGEST_SIDE);
        limits.max_alloc = Some(1 << 31);
        reader.limits(limits);
        let pixels = reader.decode().map_err(broken)?.into_rgba8();
        let (width, height) = pixels.dimensions();
        let texels = pixels.as_raw().as_chunks().0.to_vec();
        Ok(Some(Texture { width, height, texels, srgb: true, wrap: Default::default(), filter: Default::default() }))
    }
}

fn sampling(sampler: &Sampler) -> ([Wrap; 2], Filter) {
    let wrap = |mode: Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    };
    // What a texel looks like from nearby decides; from afar, samples are averaged anyway.
    let filter = match (sampler.mag_filter, sampler.min_filter) {
        (Some(Checked::Valid(MagFilter::Nearest)), _) => Filter::Nearest,
        (Some(_), _) => Filter::Bilinear,
        (None, Some(Checked::Valid(MinFilter::Nearest | MinFilter::NearestMipmapNearest))) => Filter::Nearest,
        (None, _) => Filter::Bilinear,
    };
    ([wrap(sampler.wrap_s), wrap(sampler.wrap_t)], filter)
}
