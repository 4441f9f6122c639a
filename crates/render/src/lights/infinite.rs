//! Infinite lights: suns and the sky.

use std::f32::consts::PI;

use glam::Vec3;
use kinetree_world::{Light, Sky};

use super::LightSample;
use crate::color::{luminance, sanitized};
use crate::warp::{Basis, cone};

/// A sun: a single direction, or a disc around it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sun {
    /// Unit vector to the sun.
    toward: Vec3,
    irradiance: Vec3,
    disc: Option<Disc>,
}

/// The disc of a sun in the sky.
#[derive(Debug, Clone, Copy)]
struct Disc {
    /// One minus the cosine of half the angle.
    versine: f32,
    radiance: Vec3,
}

/// Below this angular diameter, radians, single precision does not resolve a disc.
const SMALLEST_DISC: f32 = 1e-4;

impl Sun {
    /// `None` for other lights, and for a sun without irradiance.
    pub(super) fn new(light: &Light) -> Option<Self> {
        let Light::Sun { direction, irradiance, angle } = *light else { return None };
        let toward = -Vec3::from(direction).try_normalize()?;
        let irradiance = sanitized(irradiance);
        let disc = (angle >= SMALLEST_DISC).then(|| {
            let half = 0.5 * angle.min(PI);
            // The cosine integrated over the disc is pi sin^2 of half the angle, so this radiance
            // gives the irradiance on a surface that faces the sun.
            Disc { versine: 2.0 * (0.5 * half).sin().powi(2), radiance: irradiance / (PI * half.sin().powi(2)) }
        });
        let power = luminance(irradiance);
        (power > 0.0 && power.is_finite()).then_some(Self { toward, irradiance, disc })
    }

    /// Luminance of the irradiance on a surface that faces it.
    pub(super) fn power(&self) -> f32 {
        luminance(self.irradiance)
    }

    /// The direction to its centre, and the irradiance on a surface that faces it.
    pub(super) fn center(&self) -> (Vec3, Vec3) {
        (self.toward, self.irradiance)
    }

    /// Samples a direction of the disc uniformly; a delta light has only one.
    pub(super) fn sample(&self, u: [f32; 2]) -> LightSample {
        let far = LightSample {
            direction: self.toward,
            distance: f32::INFINITY,
            radiance: self.irradiance,
            pdf: 1.0,
            is_delta: true,
        };
        let Some(disc) = self.disc else { return far };
        LightSample {
            direction: Basis::around(self.toward).to_world(cone(u.into(), disc.versine)).normalize(),
            radiance: disc.radiance,
            pdf: disc.pdf(),
            is_delta: false,
            ..far
        }
    }

    /// Radiance from a direction and the pdf with which [`Sun::sample`] samples it, if the disc
    /// covers it.
    pub(super) fn radiance_from(&self, direction: Vec3) -> Option<(Vec3, f32)> {
        let disc = self.disc?;
        // The squared chord between unit vectors is twice the versine of their angle, without
        // cancellation for small angles.
        let inside = direction.distance_squared(self.toward) <= 2.0 * disc.versine;
        inside.then(|| (disc.radiance, disc.pdf()))
    }
}

impl Disc {
    fn pdf(&self) -> f32 {
        1.0 / (2.0 * PI * self.versine)
    }
}

/// Radiance of the sky from a unit direction.
pub(super) fn sky_radiance(sky: &Sky, direction: Vec3) -> Vec3 {
    match *sky {
        Sky::Constant(radiance) => sanitized(radiance),
        Sky::Gradient { zenith, horizon, ground } => {
            let end = if direction.y >= 0.0 { zenith } else { ground };
            sanitized(horizon).lerp(sanitized(end), direction.y.abs().min(1.0))
        }
    }
}

/// Luminance of the mean irradiance: pi times the mean radiance over all directions, linear RGB.
pub(super) fn sky_power(sky: &Sky) -> f32 {
    let mean = match *sky {
        Sky::Constant(radiance) => sanitized(radiance),
        // Height is uniformly distributed over the sphere, so the mean over a hemisphere is the
        // mean of its ends.
        Sky::Gradient { zenith, horizon, ground } => {
            sanitized(zenith) * 0.25 + sanitized(horizon) * 0.5 + sanitized(ground) * 0.25
        }
    };
    let power = PI * luminance(mean);
    if power.is_finite() { power } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sampler;
    use crate::warp::cosine_hemisphere;

    fn sun(angle: f32) -> Sun {
        let light = Light::Sun { direction: [0.0, -2.0, 0.0], irradiance: [3.0, 2.0, 1.0], angle };
        Sun::new(&light).expect("a sun with irradiance")
    }

    #[test]
    fn a_disc_of_any_size_gives_the_irradiance_it_was_asked_for() {
        for angle in [0.0, 1e-3, 0.0093, 0.5, 3.0] {
            let sun = sun(angle);
            let count = 1024;
            let irradiance: Vec3 = (0..count)
                .map(|i| {
                    let light = sun.sample(Sampler::new(3, [0, 0], i).next_2d());
                    light.radiance * (light.direction.y / light.pdf / count as f32)
                })
                .sum();
            assert!((irradiance - Vec3::new(3.0, 2.0, 1.0)).length() < 1e-3, "{angle}: {irradiance}");
        }
    }

    #[test]
    fn a_disc_has_radiance_exactly_where_it_is_sampled() {
        let small = sun(0.0093);
        for i in 0..256 {
            let light = small.sample(Sampler::new(5, [0, 0], i).next_2d());
            let (radiance, pdf) = small.radiance_from(light.direction * (1.0 - 1e-7)).expect("on the disc");
            assert_eq!((radiance, pdf), (light.radiance, light.pdf));
        }
        assert!(small.radiance_from(Vec3::new(0.005, 1.0, 0.0).normalize()).is_none());
        assert!(sun(0.0).radiance_from(Vec3::Y).is_none());
    }

    #[test]
    fn a_gradient_has_the_irradiance_of_its_integral() {
        let sky = Sky::Gradient { zenith: [4.0; 3], horizon: [1.0; 3], ground: [0.0; 3] };
        let count = 1024;
        let irradiance: f32 = (0..count)
            .map(|i| cosine_hemisphere(Sampler::new(7, [0, 0], i).next_2d().into()))
            .map(|local| sky_radiance(&sky, Vec3::new(local.x, local.z, local.y)).x * PI / count as f32)
            .sum();
        // pi horizon + 2 pi / 3 (zenith - horizon).
        assert!((irradiance - 3.0 * PI).abs() < 1e-2, "{irradiance}");
        assert!((sky_power(&sky) - PI * 1.5).abs() < 1e-5);
    }
}
