//! Pictures that were wrong once, each named by the property that was violated.

mod common;

use std::f64::consts::PI;

use common::{Model, Shape, corner_factor, glimpse, picture, placed, settings};
use kinetree::Affine;
use kinetree_render::IntegratorKind;
use kinetree_world::{Camera, Light, Material, Scatter, Sky};

const BOTH: [IntegratorKind; 2] = [IntegratorKind::Simple, IntegratorKind::Path];

/// A square at a position, facing up, with reflectance one half, too small to light what lights it.
fn patch(model: Model, size: f32, position: [f32; 3]) -> Model {
    let placement = placed([size; 3], [0.0, 1.0, 0.0], 0.0, position);
    model.with(&Shape::square(), Material::diffuse([0.5; 3]), placement)
}

fn thin_glass() -> Material {
    Material { scatter: Scatter::ThinDielectric { ior: 1.5 }, ..Material::diffuse([1.0; 3]) }
}

/// The transmittance of a sheet of glass by the cosine of the angle of incidence: the textbook's
/// amplitudes, summed over all internal reflections.
fn passed(cosine: f64) -> f64 {
    let beyond = (1.0 - (1.0 - cosine * cosine) / 2.25).sqrt();
    let reflected =
        [(cosine - 1.5 * beyond) / (cosine + 1.5 * beyond), (1.5 * cosine - beyond) / (1.5 * cosine + beyond)];
    let sheet = reflected.map(|amplitude| amplitude * amplitude).map(|r| 2.0 * r / (1.0 + r));
    1.0 - 0.5 * (sheet[0] + sheet[1])
}

#[test]
fn all_the_light_of_a_lamp_arrives_from_any_distance() {
    // The area light has small object-space coordinates or a placement, and is seen straight or at
    // a grazing angle.
    let lamp = || Material::emissive([50.0; 3]);
    for distance in [0.03_f32, 0.3, 1.0, 3.0, 10.0, 300.0] {
        let side = 0.3 * distance;
        let truth = 0.5 * 50.0 * 4.0 * corner_factor(0.15, 0.15);
        let plain = Shape::square().moved([0.0; 3], side);
        let turned = placed([side, 1.0, -side], [0.0, 1.0, 0.0], PI as f32 / 2.0, [0.0; 3]);
        for (name, shape, placement) in [("plain", &plain, Affine::IDENTITY), ("turned", &Shape::square(), turned)] {
            let model = patch(Model::default(), 0.02 * distance, [0.0, -distance, 0.0]).with(shape, lamp(), placement);
            let eye = [0.1 * distance, -0.8 * distance, 0.05 * distance];
            let seen = glimpse(&model.frame(), eye, [0.0, -distance, 0.0], IntegratorKind::Path, 64, 0);
            seen.assert_is(truth, 0.01, &format!("{name}, {distance} m"));
        }
    }
}

#[test]
fn a_lamp_seen_from_the_side_does_not_shade_itself() {
    // An emissive wall that stands on the floor beside a point: half of the form factor of a
    // perpendicular rectangle.
    for turn in [0.0_f32, 0.3] {
        for distance in [0.01_f32, 1.0, 100.0] {
            let frame = |kind_of_wall: Material| {
                let wall = Affine::from_axis_angle([0.0, 1.0, 0.0], turn)
                    * placed([8.0 * distance; 3], [0.0, 0.0, 1.0], PI as f32 / 2.0, [distance, 0.0, 0.0]);
                patch(Model::default(), 0.02 * distance, [0.0; 3]).with(&Shape::square(), kind_of_wall, wall).frame()
            };
            let eye = [-0.1, 0.2, 0.05].map(|x| x * distance);
            let lit = |kind, spp| glimpse(&frame(Material::emissive([5.0; 3])), eye, [0.0; 3], kind, spp, 0);
            let (path, simple) = (lit(IntegratorKind::Path, 1024), lit(IntegratorKind::Simple, 16_384));
            let error = (path.error.powi(2) + simple.error.powi(2)).sqrt();
            let apart = (path.mean - simple.mean).abs();
            assert!(apart < 5.0 * error && error < 0.02 * simple.mean, "{turn} {distance}: {path:?} {simple:?}");
        }
    }
}

#[test]
fn a_point_light_in_a_surface_is_not_shaded_by_it() {
    let position = [0.0, 2.0, 0.0];
    for tilt in [0.0, 0.7] {
        let ceiling = placed([10.0; 3], [1.0, 0.0, 0.3], tilt, position);
        let light = Light::Point { position, intensity: [10.0; 3], range: f32::INFINITY };
        let model =
            patch(Model::default(), 0.02, [0.4, 0.0, 0.3]).with(&Shape::square(), Material::diffuse([0.0; 3]), ceiling);
        let squared = 4.0 + 0.25_f64;
        let truth = 0.5 / PI * 10.0 / squared * (2.0 / squared.sqrt());
        let frame = model.lit_by(light).frame();
        let seen = glimpse(&frame, [0.5, 0.3, 0.3], [0.4, 0.0, 0.3], IntegratorKind::Path, 4, 0);
        seen.assert_is(truth, 2e-3, &format!("tilted by {tilt}"));
    }
}

#[test]
fn lamps_shine_through_thin_glass_of_any_size() {
    for size in [1.0_f32, 1e3, 1e6] {
        let lamp = placed([0.2, 1.0, 0.2], [0.0, 1.0, 0.0], 0.3, [0.0, 2.0, 0.0]);
        let glass = placed([size, 1.0, size], [0.0, 1.0, 0.0], 0.1, [0.0, 1.0, 0.0]);
        let model = patch(Model::default(), 0.02, [0.0; 3])
            .with(&Shape::square(), Material::emissive([50.0; 3]), lamp)
            .with(&Shape::square(), thin_glass(), glass);
        // The glass covers a small solid angle, so that its transmittance is that at normal
        // incidence.
        let truth = 0.5 * 50.0 * 4.0 * corner_factor(0.05, 0.05) * passed(1.0);
        let seen = glimpse(&model.frame(), [0.1, 0.3, 0.0], [0.0; 3], IntegratorKind::Path, 64, 0);
        seen.assert_is(truth, 0.01, &format!("{size} m"));
    }
}

#[test]
fn a_roof_of_thin_glass_takes_from_sky_and_lamps_what_it_reflects() {
    // The integral over the hemisphere by the midpoint rule.
    let steps = 100_000;
    let part: f64 = (0..steps).map(|i| (f64::from(i) + 0.5) / f64::from(steps)).map(|c| 2.0 * c * passed(c)).sum();
    let part = part / f64::from(steps);
    let roofs = |count: i32| {
        // What the glass reflects of the light from above comes from black ground.
        let ground = placed([1e5; 3], [0.0, 1.0, 0.0], 0.0, [0.0, -0.01, 0.0]);
        let ground = Model::default().with(&Shape::square(), Material::diffuse([0.0; 3]), ground);
        (0..count).fold(patch(ground, 0.02, [0.0; 3]), |model, i| {
            let height = 1.0 + 0.5 * i as f32;
            model.with(
                &Shape::square(),
                thin_glass(),
                placed([4e4, 1.0, 4e4], [0.0, 1.0, 0.0], 0.1, [0.0, height, 0.0]),
            )
        })
    };
    for kind in BOTH {
        let mut under_sky = roofs(1);
        under_sky.sky = Sky::Constant([3.0; 3]);
        let ceiling = placed([4e4, 1.0, 4e4], [0.0, 1.0, 0.0], 0.3, [0.0, 2.0, 0.0]);
        let lamp = Material::emissive([3.0; 3]);
        let under_lamp = roofs(1).with(&Shape::square(), lamp, ceiling);
        for (name, model) in [("sky", under_sky), ("ceiling", under_lamp)] {
            let seen = glimpse(&model.frame(), [0.1, 0.3, 0.0], [0.0; 3], kind, 16_384, 0);
            seen.assert_is(0.5 * 3.0 * part, 2e-3, &format!("{kind}, {name}"));
        }
    }
    // A wide sun straight above two sheets of glass, which both sampling techniques find.
    let angle = 1.0_f32;
    let sun = Light::Sun { direction: [0.0, -1.0, 0.0], irradiance: [2.0; 3], angle };
    let edge = (0.5 * f64::from(angle)).cos();
    let within = |i: i32| edge + (1.0 - edge) * (f64::from(i) + 0.5) / f64::from(steps);
    let sum = |f: &dyn Fn(f64) -> f64| (0..steps).map(|i| f(within(i))).sum::<f64>();
    // Between the two sheets light is reflected to and fro.
    let both = |c: f64| passed(c).powi(2) / (1.0 - (1.0 - passed(c)).powi(2));
    let truth = 0.5 / PI * 2.0 * sum(&|c| c * both(c)) / sum(&|c| c);
    for (kind, spp) in [(IntegratorKind::Simple, 1 << 15), (IntegratorKind::Path, 1 << 12)] {
        let seen = glimpse(&roofs(2).lit_by(sun).frame(), [0.1, 0.3, 0.0], [0.0; 3], kind, spp, 0);
        seen.assert_is(truth, 5e-3, &format!("{kind}, sun"));
    }
}

#[test]
fn a_plate_close_above_a_wide_floor_casts_its_shadow() {
    for (size, height) in [(1e4_f32, 4e-3_f32), (1e5, 1e-2), (1e6, 0.1)] {
        let sun = Light::Sun { direction: [0.0, -1.0, 0.0], irradiance: [PI as f32; 3], angle: 0.0 };
        let floor = Shape::square().moved([0.0; 3], 2.0 * size);
        let plate = Shape::square().moved([0.0, height, 0.0], 4.0);
        let model = Model::default().with(&floor, Material::diffuse([0.5; 3]), Affine::IDENTITY).with(
            &plate,
            Material::diffuse([0.0; 3]),
            Affine::IDENTITY,
        );
        let frame = model.lit_by(sun).frame();
        for kind in BOTH {
            // Below the plate, whose edge is two metres away, and beside it.
            let below = glimpse(&frame, [0.3, 0.5 * height, 0.2], [0.3 + height, 0.0, 0.2], kind, 1, 0);
            assert!(below.mean.abs() < 1e-9, "{kind}, {size} m: {below:?}");
            let beside = glimpse(&frame, [5.0, 1.0, 0.0], [5.0, 0.0, 0.3], kind, 1, 0);
            beside.assert_is(0.5, 1e-4, &format!("{kind}, {size} m"));
        }
    }
}

#[test]
fn a_closed_room_is_dark_however_far_it_is() {
    for distance in [1e3_f32, 1e4, 1e5] {
        for away in [[1.0, 0.0, 0.0], [0.6, -0.3, 0.9]] {
            let middle = away.map(|x| x * distance);
            let walls = Shape::cube();
            let own = (walls.clone().moved(middle, 2.0), Affine::IDENTITY);
            let placement = Affine::from_translation(middle) * Affine::from_scale([2.0; 3]);
            for (shape, placement) in [own, (walls, placement)] {
                let mut model = Model::default().with(&shape, Material::diffuse([0.8; 3]), placement);
                model.sky = Sky::Constant([1e3; 3]);
                let sun = Light::Sun { direction: [0.3, -1.0, 0.2], irradiance: [1e3; 3], angle: 0.1 };
                let lamp = Light::Point { position: [0.0; 3], intensity: [1e12; 3], range: f32::INFINITY };
                let frame = model.lit_by(sun).lit_by(lamp).frame();
                let target = [0, 1, 2].map(|axis| middle[axis] + [1.5, -1.0, 1.2][axis]);
                let camera = Camera::look_at(middle, target, 2.0);
                for kind in BOTH {
                    let film = picture(&frame, &camera, &settings(kind, 64, 4)).film;
                    let lit = film.pixels().iter().filter(|pixel| pixel[0] > 0.0).count();
                    assert_eq!(lit, 0, "{kind}: pixels of a room {distance} m away that see light");
                }
            }
        }
    }
}

#[test]
fn light_without_bounds_loses_no_sample() {
    for strength in [1e25_f32, 3e38, f32::INFINITY] {
        for lamp in [0.5_f32, 100.0] {
            let emitter = placed([lamp; 3], [1.0, 0.0, 0.0], 3.0, [0.0, 2.0, 0.0]);
            let model = Model::default()
                .with(&Shape::square(), Material::diffuse([0.8; 3]), Affine::from_scale([10.0; 3]))
                .with(&Shape::cube(), Material::glass(1.5), Affine::from_translation([0.0, 1.0, 0.0]))
                .with(&Shape::square(), Material::emissive([strength; 3]), emitter)
                .lit_by(Light::Sun { direction: [0.3, -1.0, 0.0], irradiance: [strength; 3], angle: 0.01 })
                .lit_by(Light::Point { position: [1.0, 1.0, 0.0], intensity: [strength; 3], range: f32::INFINITY });
            let frame = model.frame();
            for kind in BOTH {
                // `picture` asserts that no samples are lost.
                picture(&frame, &Camera::look_at([3.0, 2.0, 4.0], [0.0; 3], 0.9), &settings(kind, 32, 16));
            }
        }
    }
}
