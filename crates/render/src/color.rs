//! Linear RGB as three floats: luminance, clamping, sRGB.

use glam::Vec3;

/// Luminance of linear RGB with the primaries of sRGB (ITU-R BT.709).
pub(crate) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// A number clamped to `0..=max`; NaN becomes zero.
pub(crate) fn clamp_positive(value: f32, max: f32) -> f32 {
    if value > 0.0 { value.min(max) } else { 0.0 }
}

/// Upper bound of radiance, irradiance and intensity. The surface of the sun has 2e7 W/(m^2 sr);
/// products of this bound with areas, squared distances and inverse pdfs stay finite.
pub(crate) const MAX_RADIANCE: f32 = 1e20;

/// Channels clamped to `0..=MAX_RADIANCE`; NaN becomes zero.
pub(crate) fn sanitized(color: [f32; 3]) -> Vec3 {
    Vec3::from(color.map(|channel| clamp_positive(channel, MAX_RADIANCE)))
}

/// Channels clamped to `0..=1`; NaN becomes zero.
pub(crate) fn reflectance(color: [f32; 3]) -> Vec3 {
    sanitized(color).min(Vec3::ONE)
}

/// The nearest eight-bit sRGB value of a linear one, which is clamped to 0..=1; NaN is black.
pub(crate) fn srgb_from_linear(linear: f32) -> u8 {
    let linear = clamp_positive(linear, 1.0);
    let encoded = if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

/// HSV to RGB: hue in turns, saturation and value in 0..=1.
pub(crate) fn from_hue(hue: f32, saturation: f32, value: f32) -> Vec3 {
    let wheel = Vec3::new(hue, hue + 1.0 / 3.0, hue + 2.0 / 3.0);
    let channel = ((wheel - wheel.floor()) * 6.0 - Vec3::splat(3.0)).abs() - Vec3::ONE;
    let channel = channel.clamp(Vec3::ZERO, Vec3::ONE);
    (Vec3::ONE - (Vec3::ONE - channel) * saturation) * value
}

#[cfg(test)]
mod tests {
    use kinetree_world::linear_from_srgb;

    use super::*;

    #[test]
    fn encoding_undoes_decoding() {
        for value in 0..=255 {
            assert_eq!(srgb_from_linear(linear_from_srgb(value)), value);
        }
    }

    #[test]
    fn invalid_channels_are_clamped() {
        assert_eq!(sanitized([f32::NAN, -1.0, f32::INFINITY]), Vec3::new(0.0, 0.0, MAX_RADIANCE));
        assert_eq!(reflectance([f32::NAN, 0.5, 7.0]), Vec3::new(0.0, 0.5, 1.0));
        assert_eq!(srgb_from_linear(f32::NAN), 0);
    }
}
