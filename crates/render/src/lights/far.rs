//! Light from infinity: suns and the sky.

use std::f32::consts::PI;

use glam::Vec3;

use super::LightSample;
use crate::color::{cleaned, luminance};
use crate::warp::{Basis, cone};
use crate::{Light, Sky};

/// A sun: one direction, or a disc around it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sun {
    /// Unit, from the scene.
    toward: Vec3,
    irradiance: Vec3,
    disc: Option<Disc>,
}

/// The disc that a sun makes in the sky.
#[derive(Debug, Clone, Copy)]
struct Disc {
    /// One minus the cosine of half the angle.
    versine: f32,
    radiance: Vec3,
}

/// Below this angular diameter, radians, single precision cannot tell a disc from a point.
const SMALLEST_DISC: f32 = 1e-4;

impl Sun {
    /// `None` for other lights, and for a sun that gives nothing.
    pub(super) fn new(light: &Light) -> Option<Self> {
        let Light::Sun { direction, irradiance, angle } = *light else { return None };
        let toward = -Vec3::from(direction).try_normalize()?;
        let irradiance = cleaned(irradiance);
        let disc = (angle >= SMALLEST_DISC).then(|| {
            let half = 0.5 * angle.min(PI);
            // The integral of the cosine over the disc is pi sin^2, so the irradiance of a surface that faces it is kept.
            Disc { versine: 2.0 * (0.5 * half).sin().powi(2), radiance: irradiance / (PI * half.sin().powi(2)) }
        });
        let power = luminance(irradiance);
        (power > 0.0 && power.is_finite()).then_some(Self { toward, irradiance, disc })
    }

    /// Luminance of the irradiance on a surface that faces it.
    pub(super) fn power(&self) -> f32 {
        luminance(self.irradiance)
    }

    /// The direction to its middle, and the irradiance.
    pub(super) fn middle(&self) -> (Vec3, Vec3) {
        (self.toward, self.irradiance)
    }

    /// A direction of the disc; the only one there is for a sun without a disc.
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

    /// Radiance from a direction, and the pdf with which [`Sun::sample`] finds it, if the disc is there.
    pub(super) fn seen(&self, direction: Vec3) -> Option<(Vec3, f32)> {
        let disc = self.disc?;
        // The chord between unit vectors squared is twice the versine, and keeps its digits when they are close.
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
        Sky::Constant(radiance) => cleaned(radiance),
        Sky::Gradient { zenith, horizon, ground } => {
            let end = if direction.y >= 0.0 { zenith } else { ground };
            cleaned(horizon).lerp(cleaned(end), direction.y.abs().min(1.0))
        }
    }
}

/// Luminance of the mean irradiance: pi times the mean radiance over all directions.
pub(super) fn sky_power(sky: &Sky) -> f32 {
    let mean = match *sky {
        Sky::Constant(radiance) => cleaned(radiance),
        // Height is uniform over the sphere, so the mean of each half is the mean of its ends.
        Sky::Gradient { zenith, horizon, ground } => {
            cleaned(zenith) * 0.25 + cleaned(horizon) * 0.5 + cleaned(ground) * 0.25
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
        Sun::new(&light).expect("it shines")
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
    fn a_disc_is_seen_exactly_where_it_is_sampled() {
        let small = sun(0.0093);
        for i in 0..256 {
            let light = small.sample(Sampler::new(5, [0, 0], i).next_2d());
            let (radiance, pdf) = small.seen(light.direction * (1.0 - 1e-7)).expect("on the disc");
            assert_eq!((radiance, pdf), (light.radiance, light.pdf));
        }
        assert!(small.seen(Vec3::new(0.005, 1.0, 0.0).normalize()).is_none());
        assert!(sun(0.0).seen(Vec3::Y).is_none());
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
