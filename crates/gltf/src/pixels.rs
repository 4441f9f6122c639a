//! Decoding PNG and JPEG into four bytes per pixel, without a second copy of the image.
//!
//! The size is known before anything is decoded, so that the caller can refuse; 16 bits become 8 as
//! they are read; and fewer than four channels are expanded in place.

use std::io::Cursor;

use image::codecs::jpeg::JpegDecoder;
use image::{ColorType, ImageDecoder, Limits};
use png::Transformations;

/// Pixels along either side; larger images are refused.
const LARGEST_SIDE: u32 = 1 << 14;

/// Memory of a decoder, bytes: its tables and a few rows; for a progressive JPEG, all coefficients.
const DECODER_BYTES: usize = 1 << 31;

/// An image whose size is known, before its pixels are decoded.
pub(crate) enum Encoded<'a> {
    Png(Box<png::Reader<Cursor<&'a [u8]>>>),
    Jpeg(Box<JpegDecoder<Cursor<&'a [u8]>>>),
}

impl<'a> Encoded<'a> {
    /// Reads the header. The error is a clause about the image.
    pub(crate) fn new(bytes: &'a [u8]) -> Result<Self, String> {
        let encoded = if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
            let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: DECODER_BYTES });
            decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
            decoder.set_ignore_text_chunk(true);
            Self::Png(Box::new(decoder.read_info().map_err(|error| broken(&error))?))
        } else if bytes.starts_with(b"\xff\xd8\xff") {
            let mut decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(|error| broken(&error))?;
            let mut limits = Limits::default();
            limits.max_alloc = Some(DECODER_BYTES as u64);
            decoder.set_limits(limits).map_err(|error| broken(&error))?;
            Self::Jpeg(Box::new(decoder))
        } else {
            return Err("is neither PNG nor JPEG".to_owned());
        };
        let [width, height] = encoded.size();
        if width == 0 || height == 0 || width.max(height) > LARGEST_SIDE {
            return Err(format!("has a size of {width} x {height}"));
        }
        Ok(encoded)
    }

    /// Columns and rows, each between 1 and 16,384.
    pub(crate) fn size(&self) -> [u32; 2] {
        match self {
            Self::Png(reader) => [reader.info().width, reader.info().height],
            Self::Jpeg(decoder) => decoder.dimensions().into(),
        }
    }

    /// Decodes red, green, blue and alpha of every pixel. The error is a clause about the image.
    pub(crate) fn texels(self) -> Result<Vec<[u8; 4]>, String> {
        let [width, height] = self.size();
        let count = width as usize * height as usize;
        let channels = self.channels()?;
        let mut texels = vec![[0; 4]; count];
        let bytes = &mut texels.as_flattened_mut()[..count * channels];
        match self {
            Self::Png(mut reader) => reader.next_frame(bytes).map(drop).map_err(|error| broken(&error))?,
            Self::Jpeg(decoder) => decoder.read_image(bytes).map_err(|error| broken(&error))?,
        }
        spread(&mut texels, channels);
        Ok(texels)
    }

    /// Bytes that the decoder writes for each pixel, 1 to 4.
    fn channels(&self) -> Result<usize, String> {
        let unknown = |kind: &dyn std::fmt::Debug| Err(format!("has pixels of an unknown kind, {kind:?}"));
        Ok(match self {
            Self::Png(reader) => match reader.output_color_type() {
                (color, png::BitDepth::Eight) => color.samples(),
                other => return unknown(&other),
            },
            Self::Jpeg(decoder) => match decoder.color_type() {
                ColorType::L8 => 1,
                ColorType::Rgb8 => 3,
                other => return unknown(&other),
            },
        })
    }
}

fn broken(error: &dyn std::error::Error) -> String {
    format!("cannot be decoded: {error}")
}

/// Turns pixels of 1 (grey), 2 (grey, alpha) or 3 (colour) bytes, which stand one after the other
/// at the beginning, into pixels of four. From the last to the first, so that nothing is written
/// over before it is read.
fn spread(texels: &mut [[u8; 4]], channels: usize) {
    if channels == 4 {
        return;
    }
    for pixel in (0..texels.len()).rev() {
        let bytes = texels.as_flattened();
        let at = pixel * channels;
        texels[pixel] = match channels {
            1 => [bytes[at], bytes[at], bytes[at], u8::MAX],
            2 => [bytes[at], bytes[at], bytes[at], bytes[at + 1]],
            _ => [bytes[at], bytes[at + 1], bytes[at + 2], u8::MAX],
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_of_any_number_of_channels_become_pixels_of_four() {
        let spread_out = |bytes: &[u8], channels: usize| {
            let count = bytes.len() / channels;
            let mut texels = vec![[0; 4]; count];
            texels.as_flattened_mut()[..bytes.len()].copy_from_slice(bytes);
            spread(&mut texels, channels);
            texels
        };
        assert_eq!(spread_out(&[1, 2, 3], 1), [[1, 1, 1, 255], [2, 2, 2, 255], [3, 3, 3, 255]]);
        assert_eq!(spread_out(&[1, 2, 3, 4], 2), [[1, 1, 1, 2], [3, 3, 3, 4]]);
        assert_eq!(spread_out(&[1, 2, 3, 4, 5, 6], 3), [[1, 2, 3, 255], [4, 5, 6, 255]]);
        assert_eq!(spread_out(&[1, 2, 3, 4], 4), [[1, 2, 3, 4]]);
    }

    #[test]
    fn every_kind_of_png_is_read_as_eight_bits() {
        use image::{DynamicImage, ImageFormat, Rgba};
        let shades = image::ImageBuffer::from_fn(5, 3, |x, y| {
            Rgba([x as u16 * 13_000, y as u16 * 21_000 + 500, 40_000 + x as u16, 65_535 - (x + y) as u16 * 8_000])
        });
        let image = DynamicImage::ImageRgba16(shades);
        let kinds = [
            image.clone(),
            image.to_rgb16().into(),
            image.to_rgba8().into(),
            image.to_rgb8().into(),
            image.to_luma8().into(),
            image.to_luma16().into(),
            image.to_luma_alpha8().into(),
        ];
        for kind in kinds {
            let mut bytes = Cursor::new(Vec::new());
            kind.write_to(&mut bytes, ImageFormat::Png).expect("a small image can be written");
            let encoded = Encoded::new(bytes.get_ref()).expect("a good header");
            assert_eq!(encoded.size(), [5, 3]);
            let texels = encoded.texels().expect("a good image");
            let wanted = kind.to_rgba8();
            for (texel, pixel) in texels.iter().zip(wanted.pixels()) {
                // The upper byte of 16 bits may differ from the nearest of 8 by one.
                assert!((0..4).all(|i| texel[i].abs_diff(pixel[i]) <= 1), "{:?}: {texel:?} {pixel:?}", kind.color());
            }
        }
    }
}
