//! Point and spot lights: delta lights, which BSDF sampling cannot find.

use std::f32::consts::PI;

use glam::Vec3;
use kinetree_world::Light;

use super::{LightSample, MAX_WEIGHED};
use crate::color::{luminance, sanitized};

/// A point or spot light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Punctual {
    position: Vec3,
    intensity: Vec3,
    range: f32,
    cone: Option<Cone>,
}

/// Shadow rays end at this part of the distance to a light, so that a surface in which the light
/// lies does not block it.
const SHADOW_RAY_END: f32 = 1.0 - 1e-5;

/// A computed value that is larger by this factor is larger in exact arithmetic too.
const ROUNDING_MARGIN: f32 = 1.0 + 1e-5;

/// The cone of a spot light.
#[derive(Debug, Clone, Copy)]
struct Cone {
    axis: Vec3,
    inner_cos: f32,
    outer_cos: f32,
}

impl Punctual {
    /// `None` for a sun, and for a light without power or without a finite position.
    pub(super) fn new(light: &Light) -> Option<Self> {
        let (position, intensity, range, cone) = match *light {
            Light::Point { position, intensity, range } => (position, intensity, range, None),
            Light::Spot { position, direction, intensity, range, inner_cos, outer_cos } => {
                let axis = Vec3::from(direction).try_normalize()?;
                if inner_cos.is_nan() || outer_cos.is_nan() {
                    return None;
                }
                let outer_cos = outer_cos.clamp(-1.0, 1.0);
                let inner_cos = inner_cos.clamp(outer_cos, 1.0);
                (position, intensity, range, Some(Cone { axis, inner_cos, outer_cos }))
            }
            Light::Sun { .. } => return None,
        };
        let light = Self { position: position.into(), intensity: sanitized(intensity), range, cone };
        let usable = light.position.is_finite() && range > 0.0 && light.power() > 0.0 && light.power().is_finite();
        usable.then_some(light)
    }

    /// Approximate luminance of its flux; the soft edge of a spot counts half.
    pub(super) fn power(&self) -> f32 {
        let solid_angle = match self.cone {
            None => 4.0 * PI,
            Some(cone) => 2.0 * PI * (1.0 - 0.5 * (cone.inner_cos + cone.outer_cos)),
        };
        luminance(self.intensity) * solid_angle
    }

    /// A conservative test without divisions: whether the light certainly does not contribute,
    /// because `from` is beyond its range or the light is below the horizon of `normal`.
    fn is_culled(&self, from: Vec3, normal: Vec3) -> bool {
        let offset = self.position - from;
        let (squared, height) = (offset.length_squared(), normal.dot(offset));
        squared > self.range * self.range * ROUNDING_MARGIN
            || (height < 0.0 && height * height > squared * (ROUNDING_MARGIN - 1.0))
    }

    /// The light that arrives at a point: irradiance on a surface that faces it.
    pub(super) fn sample(&self, from: Vec3) -> Option<LightSample> {
        let offset = self.position - from;
        let distance = offset.length();
        let direction = offset / distance;
        let edge = self.cone.map_or(1.0, |cone| cone.strength(-direction));
        let radiance = self.intensity * (edge * window(distance / self.range) / (distance * distance));
        (radiance.is_finite() && radiance.max_element() > 0.0).then_some(LightSample {
            direction,
            distance: distance * SHADOW_RAY_END,
            radiance,
            pdf: 1.0,
            is_delta: true,
        })
    }
}

/// Draws one of several lights in proportion to their unshadowed contributions to a surface with a
/// normal, at most [`MAX_WEIGHED`] of them. BSDF sampling never finds these lights, so any
/// probabilities are unbiased as long as no light that contributes has probability zero.
pub(super) fn sample_one(lights: &[Punctual], from: Vec3, normal: Vec3, u: f32) -> Option<LightSample> {
    let (mut weights, mut numbers) = ([0.0; MAX_WEIGHED], [0; MAX_WEIGHED]);
    let (mut count, mut total) = (0, 0.0);
    for (number, light) in lights.iter().enumerate().take(MAX_WEIGHED) {
        if light.is_culled(from, normal) {
            continue;
        }
        let weight = light.sample(from).map_or(0.0, |sample| sample.weight(normal));
        if weight > 0.0 {
            (weights[count], numbers[count]) = (weight, number);
            total += weight;
            count += 1;
        }
    }
    let mut left = u * total;
    let mut chosen = None;
    for (&weight, &number) in weights[..count].iter().zip(&numbers) {
        chosen = Some((weight, number));
        left -= weight;
        if left < 0.0 {
            break;
        }
    }
    let (weight, number) = chosen?;
    let sample = lights[number].sample(from)?;
    Some(LightSample { pdf: weight / total, ..sample }).filter(|sample| sample.pdf > 0.0 && sample.pdf.is_finite())
}

impl LightSample {
    /// Luminance of the irradiance on a surface with a normal.
    fn weight(&self, normal: Vec3) -> f32 {
        luminance(self.radiance) * normal.dot(self.direction).max(0.0)
    }
}

impl Cone {
    /// 1 within the inner angle, 0 beyond the outer one, with a smooth transition
    /// (KHR_lights_punctual).
    fn strength(&self, direction: Vec3) -> f32 {
        let cosine = self.axis.dot(direction);
        if cosine <= self.outer_cos {
            return 0.0;
        }
        let part = ((cosine - self.outer_cos) / (self.inner_cos - self.outer_cos).max(1e-3)).min(1.0);
        part * part
    }
}

/// Attenuation to zero at the range of a light; `part` is the distance over the range
/// (KHR_lights_punctual).
fn window(part: f32) -> f32 {
    (1.0 - part.powi(4)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot() -> Light {
        Light::Spot {
            position: [0.0, 2.0, 0.0],
            direction: [0.0, -3.0, 0.0],
            intensity: [8.0, 4.0, 2.0],
            range: f32::INFINITY,
            inner_cos: 0.9,
            outer_cos: 0.8,
        }
    }

    #[test]
    fn a_spot_is_full_inside_and_nothing_outside() {
        let light = Punctual::new(&spot()).expect("a light with power");
        let below = light.sample(Vec3::ZERO).expect("in the cone");
        assert!((below.radiance - Vec3::new(2.0, 1.0, 0.5)).length() < 1e-6);
        assert!((below.direction - Vec3::Y).length() < 1e-6 && (below.distance - 2.0).abs() < 1e-4);
        assert!(light.sample(Vec3::new(5.0, 0.0, 0.0)).is_none());
        assert!(light.sample(Vec3::new(0.0, 4.0, 0.0)).is_none());
        // At a cosine of 0.85, half way between the angles, a quarter is left.
        let tangent = (1.0_f32 / (0.85 * 0.85) - 1.0).sqrt();
        let edge = light.sample(Vec3::new(2.0 * tangent, 0.0, 0.0)).expect("on the edge");
        assert!((edge.radiance.x * edge.distance.powi(2) - 2.0).abs() < 1e-3);
    }

    #[test]
    fn beyond_its_range_a_light_gives_nothing() {
        let light = Light::Point { position: [0.0; 3], intensity: [1.0; 3], range: 2.0 };
        let light = Punctual::new(&light).expect("a light with power");
        assert!((light.sample(Vec3::X).expect("near").radiance.x - 15.0 / 16.0).abs() < 1e-6);
        assert!(light.sample(Vec3::X * 2.0).is_none());
    }

    #[test]
    fn one_of_many_is_drawn_by_its_contribution() {
        let at = |x: f32, y: f32| Light::Point { position: [x, y, 0.0], intensity: [3.0; 3], range: 100.0 };
        let lights: Vec<_> =
            [at(0.0, 1.0), at(0.0, 2.0), at(3.0, 1.0), at(0.0, -1.0)].iter().filter_map(Punctual::new).collect();
        let count = 4000;
        let draws = (0..count).filter_map(|i| sample_one(&lights, Vec3::ZERO, Vec3::Y, i as f32 / count as f32));
        // Whichever is drawn, its contribution over its probability is the sum of all.
        let all: f32 = lights
            .iter()
            .filter_map(|light| light.sample(Vec3::ZERO))
            .map(|s| s.radiance.x * s.direction.y.max(0.0))
            .sum();
        let mut drawn = 0;
        for sample in draws {
            assert!((sample.radiance.x * sample.direction.y / sample.pdf - all).abs() < 1e-4 * all);
            drawn += 1;
        }
        assert_eq!(drawn, count);
        assert!(sample_one(&lights[3..], Vec3::ZERO, Vec3::Y, 0.5).is_none());
    }

    #[test]
    fn culled_lights_do_not_contribute() {
        let unit = |bits: u32| crate::sampler::unit_hash(bits) * 2.0 - 1.0;
        let vector = |seed: u32| Vec3::new(unit(seed), unit(seed ^ 0x5555), unit(seed ^ 0xaaaa_0000));
        let mut counts = [0, 0];
        for seed in 0..20_000 {
            let normal = vector(3 * seed).normalize();
            // Many lie almost in the surface, or almost at their range.
            let along = normal.any_orthonormal_vector() * (1.0 + 1e-6 * unit(seed));
            let position = if seed % 2 == 0 { along + normal * (1e-6 * unit(seed + 1)) } else { vector(3 * seed + 1) };
            let point = Light::Point { position: position.into(), intensity: [1.0; 3], range: 1.0 };
            let light = Punctual::new(&point).expect("a light with power");
            let weight = light.sample(Vec3::ZERO).map_or(0.0, |sample| sample.weight(normal));
            let is_culled = light.is_culled(Vec3::ZERO, normal);
            assert!(!is_culled || weight == 0.0, "seed {seed}");
            counts[usize::from(is_culled)] += 1;
        }
        assert!(counts.iter().all(|&count| count > 4000), "{counts:?}");
    }

    #[test]
    fn awkward_lights_are_no_lights() {
        for value in [f32::NAN, 0.0, -1.0] {
            let point = |position, intensity, range| Punctual::new(&Light::Point { position, intensity, range });
            assert!(point([0.0; 3], [value; 3], 1.0).is_none());
            assert!(point([0.0; 3], [1.0; 3], value).is_none());
        }
        let here = Light::Point { position: [1.0; 3], intensity: [1.0; 3], range: f32::INFINITY };
        assert!(Punctual::new(&here).expect("a light with power").sample(Vec3::ONE).is_none());
    }
}
