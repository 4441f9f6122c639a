//! Textures: eight-bit images with sRGB decoding, wrap modes and bilinear filtering.

use std::fmt;
use std::sync::LazyLock;

use glam::{Vec2, Vec4};

/// An image with its sampling.
#[derive(Clone, PartialEq)]
pub struct Texture {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// RGBA, row by row from the top, `width * height` of them.
    pub texels: Vec<[u8; 4]>,
    /// Whether colour is encoded as sRGB, and decoded by a lookup; alpha never is.
    pub srgb: bool,
    /// The wrap modes along u and v.
    pub wrap: [Wrap; 2],
    /// The filter.
    pub filter: Filter,
}

/// Prints the size, not the texels.
impl fmt::Debug for Texture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Texture")
            .field("width", &self.width)
            .field("height", &self.height)
            .field("srgb", &self.srgb)
            .field("wrap", &self.wrap)
            .field("filter", &self.filter)
            .finish_non_exhaustive()
    }
}

/// How texture coordinates beyond the image are wrapped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image again, every other one mirrored.
    Mirror,
    /// The texel at the edge.
    Clamp,
}

/// How texels are filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// Bilinear interpolation of four texels.
    #[default]
    Bilinear,
}

/// The linear value, in 0..=1, of an eight-bit sRGB value (IEC 61966-2-1).
pub fn linear_from_srgb(value: u8) -> f32 {
    let encoded = f32::from(value) / 255.0;
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// [`linear_from_srgb`] of all values.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|value| linear_from_srgb(value as u8)));

impl Wrap {
    /// Wraps the index of a texel into `0..size`.
    fn fold(self, place: i64, size: u32) -> usize {
        let (size, is_power_of_two) = (i64::from(size), size.is_power_of_two());
        let folded = match self {
            // The remainder without a division.
            Self::Repeat if is_power_of_two => place & (size - 1),
            Self::Repeat => place.rem_euclid(size),
            Self::Mirror => {
                let twice = place.rem_euclid(2 * size);
                twice.min(2 * size - 1 - twice)
            }
            Self::Clamp => place.clamp(0, size - 1),
        };
        folded as usize
    }
}

impl Texture {
    /// The filtered colour at texture coordinates, linear RGBA in 0..=1. (0, 0) is the upper left
    /// corner of the image, (1, 1) the lower right. A texture without texels, or with too few, is
    /// white; coordinates that are not finite count as (0, 0).
    pub fn lookup(&self, uv: [f32; 2]) -> [f32; 4] {
        let texels = u64::from(self.width) * u64::from(self.height);
        if texels == 0 || (self.texels.len() as u64) < texels {
            return [1.0; 4];
        }
        let uv = Vec2::from(uv);
        let uv = if uv.is_finite() { uv } else { Vec2::ZERO };
        let place = uv * Vec2::new(self.width as f32, self.height as f32);
        match self.filter {
            Filter::Nearest => self.texel(floor(place.x) as i64, floor(place.y) as i64).to_array(),
            Filter::Bilinear => {
                let corner = place - Vec2::splat(0.5);
                let corner = Vec2::new(floor(corner.x), floor(corner.y));
                let part = (place - Vec2::splat(0.5) - corner).clamp(Vec2::ZERO, Vec2::ONE);
                let (x, y) = (corner.x as i64, corner.y as i64);
                let (right, below) = (x.saturating_add(1), y.saturating_add(1));
                let upper = self.texel(x, y).lerp(self.texel(right, y), part.x);
                let lower = self.texel(x, below).lerp(self.texel(right, below), part.x);
                upper.lerp(lower, part.y).to_array()
            }
        }
    }

    fn texel(&self, x: i64, y: i64) -> Vec4 {
        let (x, y) = (self.wrap[0].fold(x, self.width), self.wrap[1].fold(y, self.height));
        let [r, g, b, a] = self.texels[y * self.width as usize + x];
        let plain = |value: u8| f32::from(value) / 255.0;
        let color = |value: u8| if self.srgb { LINEAR[usize::from(value)] } else { plain(value) };
        Vec4::new(color(r), color(g), color(b), plain(a))
    }
}

/// `f32::floor` without a function call at processor levels that have no instruction for it.
fn floor(x: f32) -> f32 {
    // Numbers from 2^23 on have no fraction; NaN stays NaN.
    if x.abs() < 8_388_608.0 {
        let toward_zero = x as i32 as f32;
        if toward_zero > x { toward_zero - 1.0 } else { toward_zero }
    } else {
        x
    }
}

/// A reference from a material to a texture, with a transform of texture coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureRef {
    /// Index into [`MaterialSet::textures`](crate::MaterialSet::textures).
    pub texture: u32,
    /// Texture coordinates are scaled by `scale`, rotated by `rotation`, and moved by `offset`, in
    /// this order (KHR_texture_transform).
    pub scale: [f32; 2],
    /// Radians, counter-clockwise as in KHR_texture_transform.
    pub rotation: f32,
    /// Added last.
    pub offset: [f32; 2],
}

impl From<u32> for TextureRef {
    fn from(texture: u32) -> Self {
        Self { texture, scale: [1.0; 2], rotation: 0.0, offset: [0.0; 2] }
    }
}

impl TextureRef {
    /// Transforms texture coordinates of a mesh into those of the image.
    #[inline]
    pub fn transformed(&self, uv: [f32; 2]) -> [f32; 2] {
        let (sin, cos) = if self.rotation == 0.0 { (0.0, 1.0) } else { self.rotation.sin_cos() };
        let [u, v] = [uv[0] * self.scale[0], uv[1] * self.scale[1]];
        // Counter-clockwise as seen in the image, where v points down.
        [cos * u + sin * v + self.offset[0], -sin * u + cos * v + self.offset[1]]
    }

    /// The colour at texture coordinates of a mesh, linear RGBA in 0..=1; white when there is no
    /// such texture.
    #[inline]
    pub fn lookup(&self, textures: &[Texture], uv: [f32; 2]) -> [f32; 4] {
        textures.get(self.texture as usize).map_or([1.0; 4], |texture| texture.lookup(self.transformed(uv)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn board(wrap: Wrap, filter: Filter) -> Texture {
        let texels = vec![[0, 0, 0, 255], [255, 255, 255, 255], [255, 0, 0, 0], [188, 188, 188, 51]];
        Texture { width: 2, height: 2, texels, srgb: true, wrap: [wrap; 2], filter }
    }

    #[test]
    fn floor_is_that_of_the_standard_library() {
        let values = [0.0, 0.25, 1.0, 1.5, 7.999_999_5, 8_388_607.5, 8_388_608.0, 16_777_217.0, 1e30, f32::INFINITY];
        for value in values.into_iter().flat_map(|value| [value, -value]) {
            assert!(floor(value) == value.floor(), "{value}");
        }
        assert!(floor(f32::NAN).is_nan());
    }

    #[test]
    fn a_power_of_two_folds_like_any_other_size() {
        for place in [i64::MIN, -9, -8, -1, 0, 1, 7, 8, 9, 1 << 40, i64::MAX] {
            for size in [1, 2, 8, 1 << 31] {
                assert_eq!(Wrap::Repeat.fold(place, size), place.rem_euclid(i64::from(size)) as usize);
            }
        }
    }

    fn close(a: [f32; 4], b: [f32; 4]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-3)
    }

    #[test]
    fn colour_is_decoded_and_alpha_is_not() {
        let texture = board(Wrap::Clamp, Filter::Nearest);
        assert!(close(texture.lookup([0.75, 0.75]), [0.503, 0.503, 0.503, 0.2]));
        let raw = Texture { srgb: false, ..texture };
        assert!(close(raw.lookup([0.75, 0.75]), [0.737, 0.737, 0.737, 0.2]));
    }

    #[test]
    fn bilinear_is_the_texel_at_its_centre_and_the_mean_between() {
        let texture = board(Wrap::Clamp, Filter::Bilinear);
        assert!(close(texture.lookup([0.75, 0.25]), [1.0; 4]));
        assert!(close(texture.lookup([0.5, 0.25]), [0.5, 0.5, 0.5, 1.0]));
    }

    #[test]
    fn beyond_the_edge_lies_what_the_wrap_says() {
        let at = |wrap, u| board(wrap, Filter::Nearest).lookup([u, 0.25])[0];
        assert!(at(Wrap::Repeat, 1.25) < 0.5 && at(Wrap::Repeat, -0.25) > 0.5);
        assert!(at(Wrap::Mirror, 1.25) > 0.5 && at(Wrap::Mirror, -0.25) < 0.5);
        assert!(at(Wrap::Clamp, 1.25) > 0.5 && at(Wrap::Clamp, -0.25) < 0.5);
    }

    #[test]
    fn awkward_places_and_textures_have_a_colour() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for filter in [Filter::Nearest, Filter::Bilinear] {
                for u in [f32::NAN, f32::INFINITY, f32::MAX, -f32::MAX, 1e20, -1e-30] {
                    assert!(board(wrap, filter).lookup([u, u]).iter().all(|channel| (0.0..=1.0).contains(channel)));
                }
            }
        }
        let short = Texture { height: 1000, ..board(Wrap::Clamp, Filter::Bilinear) };
        assert!(close(short.lookup([0.5, 0.9]), [1.0; 4]));
        assert!(close(TextureRef::from(3).lookup(&[], [0.0; 2]), [1.0; 4]));
    }

    #[test]
    fn a_reference_scales_then_turns_then_moves() {
        let quarter = std::f32::consts::FRAC_PI_2;
        let reference = TextureRef { texture: 0, scale: [2.0, 3.0], rotation: quarter, offset: [0.5, 0.25] };
        let [u, v] = reference.transformed([1.0, 0.0]);
        assert!((u - 0.5).abs() < 1e-6 && (v + 1.75).abs() < 1e-6);
        let [u, v] = reference.transformed([0.0, 1.0]);
        assert!((u - 3.5).abs() < 1e-6 && (v - 0.25).abs() < 1e-6);
    }
}
