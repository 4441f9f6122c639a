//! From linear radiance to display colours: exposure, a filmic tone curve, sRGB.
//!
//! The curve is the rational function with which Narkowicz 2015, "ACES Filmic Tone Mapping Curve",
//! follows the film-like response of the Academy Color Encoding System: dark tones get a short toe,
//! bright ones run softly into white.

use crate::Film;
use crate::color::{clamp_positive, luminance, sanitized, srgb_from_linear};

/// Exposure, the filmic curve and sRGB encoding: eight-bit RGB, three bytes per pixel, row by row
/// from the top.
///
/// `exposure` multiplies the film; see [`metered_exposure`](crate::metered_exposure) and
/// [`automatic_exposure`].
pub fn tone_map(film: &Film, exposure: f32) -> Vec<u8> {
    srgb_bytes(film, |channel| filmic(channel * exposure))
}

/// sRGB encoding only, for pictures that show data, such as a heat map: eight-bit RGB, three bytes
/// per pixel, row by row from the top.
pub fn encode_srgb(film: &Film) -> Vec<u8> {
    srgb_bytes(film, |channel| channel)
}

fn srgb_bytes(film: &Film, tone: impl Fn(f32) -> f32) -> Vec<u8> {
    film.pixels().iter().flat_map(|pixel| pixel.map(|channel| srgb_from_linear(tone(channel)))).collect()
}

/// The filmic curve: from 0 for black and negative values up to 1.
fn filmic(linear: f32) -> f32 {
    // Beyond 1e4 the curve is flat, and squares of larger numbers would overflow.
    let x = clamp_positive(linear, 1e4);
    (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)
}

/// The luminance to which the geometric mean of the picture is exposed.
const MIDDLE_GREY: f32 = 0.18;

/// The exposure that brings a film to middle brightness: the factor that makes the geometric mean
/// of the pixels middle grey. The darkest and the brightest twentieth are left out, so that neither
/// lamps nor holes in the scene decide; a film that is black everywhere gets 1.
///
/// Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images".
pub fn automatic_exposure(film: &Film) -> f32 {
    exposure_of(film.pixels())
}

/// As [`automatic_exposure`], for linear RGB pixels.
pub(crate) fn exposure_of(pixels: &[[f32; 3]]) -> f32 {
    let mut logs: Vec<f32> = pixels
        .iter()
        .map(|&pixel| luminance(sanitized(pixel)))
        .filter(|&brightness| brightness > 1e-8 && brightness.is_finite())
        .map(f32::ln)
        .collect();
    if logs.is_empty() {
        return 1.0;
    }
    logs.sort_unstable_by(f32::total_cmp);
    let cut = logs.len() / 20;
    let kept = &logs[cut..logs.len() - cut];
    let mean = kept.iter().copied().map(f64::from).sum::<f64>() / kept.len() as f64;
    (MIDDLE_GREY / mean.exp() as f32).clamp(1e-9, 1e9)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film_of(values: &[f32]) -> Film {
        let mut film = Film::new(values.len() as u32, 1);
        film.set_row([0, 0], &values.iter().map(|&value| [value; 3]).collect::<Vec<_>>());
        film
    }

    #[test]
    fn the_curve_rises_from_black_to_white() {
        let tones: Vec<f32> = (0..2000).map(|i| filmic(i as f32 * 0.01)).collect();
        assert!(tones.windows(2).all(|pair| pair[0] <= pair[1]));
        assert!(tones[0].abs() < 1e-9);
        assert!(tones[1999] > 0.99);
    }

    #[test]
    fn awkward_light_becomes_a_byte() {
        let film = film_of(&[f32::NAN, f32::INFINITY, -1.0, 0.0, f32::MAX]);
        let bytes = tone_map(&film, 1.0);
        assert_eq!(bytes.chunks(3).map(|pixel| pixel[0]).collect::<Vec<_>>(), [0, 255, 0, 0, 255]);
        assert_eq!(encode_srgb(&film_of(&[1.0])), [255; 3]);
    }

    #[test]
    fn exposure_follows_the_scene_and_ignores_lamps() {
        let mut values = vec![2.0; 100];
        assert!((automatic_exposure(&film_of(&values)) - 0.09).abs() < 1e-5);
        values.extend([1e6, 1e6, 0.0, 1e-7]);
        assert!((automatic_exposure(&film_of(&values)) - 0.09).abs() < 1e-5);
        assert!((automatic_exposure(&film_of(&[0.0, f32::NAN])) - 1.0).abs() < 1e-9);
        assert!((automatic_exposure(&Film::new(0, 0)) - 1.0).abs() < 1e-9);
    }
}
