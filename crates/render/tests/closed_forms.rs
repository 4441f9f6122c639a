//! Pictures whose radiance is known in closed form.

mod common;

use std::f64::consts::PI;

use common::{Model, Shape, corner_factor, glimpse, placed};
use kinetree::Affine;
use kinetree_render::IntegratorKind;
use kinetree_world::{Light, Material, Scatter, Sky};

const BOTH: [IntegratorKind; 2] = [IntegratorKind::Simple, IntegratorKind::Path];

fn floor() -> Model {
    Model::default().with(&Shape::square(), Material::diffuse([0.8, 0.5, 0.2]), Affine::from_scale([100.0; 3]))
}

/// The radiance of the centre of the floor, seen from the side.
fn on_the_floor(model: Model, kind: IntegratorKind, spp: u32) -> common::Estimate {
    glimpse(&model.frame(), [1.0, 0.5, 0.3], [0.0; 3], kind, spp, 0)
}

#[test]
fn a_small_area_light_gives_the_irradiance_of_its_view_factor() {
    let (width, depth, height, radiance) = (0.3_f64, 0.2, 0.7, 50.0);
    let truth = 0.8 * radiance * 4.0 * corner_factor(0.5 * width / height, 0.5 * depth / height);
    let lamp = Material { two_sided: false, ..Material::emissive([50.0, 40.0, 30.0]) };
    let (x, z, y) = (width as f32, depth as f32, height as f32);
    // The same area light in four ways: as it is, turned over, mirrored, and scaled unevenly.
    let ways = [
        ("turned over", Shape::square(), placed([x, 1.0, z], [1.0, 0.0, 0.0], std::f32::consts::PI, [0.0, y, 0.0])),
        ("facing down", Shape::square().inverted(), placed([x, 9.0, z], [0.0, 1.0, 0.0], 0.0, [0.0, y, 0.0])),
        ("mirrored", Shape::square().inverted(), placed([-x, 1.0, z], [0.0, 1.0, 0.0], 0.0, [0.0, y, 0.0])),
        ("mirrored upside down", Shape::square(), placed([x, -0.1, z], [0.0, 1.0, 0.0], 0.0, [0.0, y, 0.0])),
    ];
    for (name, shape, placement) in ways {
        let model = || floor().with(&shape, lamp.clone(), placement);
        on_the_floor(model(), IntegratorKind::Path, 256).assert_is(truth, 0.01, name);
        on_the_floor(model(), IntegratorKind::Simple, 4096).assert_is(truth, 0.05, name);
        // No light is emitted upwards.
        let above = glimpse(&model().frame(), [0.01, 2.0, 0.0], [0.0, 0.7, 0.0], IntegratorKind::Path, 16, 0);
        assert!(above.mean.abs() < 1e-9, "{name}: {above:?}");
    }
}

#[test]
fn area_lights_under_uneven_scale_are_weighed_by_their_area_in_the_world() {
    // One lamp is stretched a hundredfold along x and is far larger in the world than in object
    // space; the other is small. With wrong powers the mean would be right but the noise would not:
    // both lamps face the floor from the same height, so drawing them by power makes the estimate
    // nearly constant.
    let lamp = || Material::emissive([1.0; 3]);
    let (height, sizes) = (20.0, [[4.0, 0.2, 0.04], [0.04, 5.0, 4.0]]);
    let mut model = floor();
    let mut truth = 0.0;
    for size in sizes {
        let placement = Affine::from_translation([0.0, height, 0.0]) * Affine::from_scale(size);
        model = model.with(&Shape::square(), lamp(), placement);
        let factor = corner_factor(0.5 * f64::from(size[0] / height), 0.5 * f64::from(size[2] / height));
        truth += 0.8 * 4.0 * factor;
    }
    let estimate = on_the_floor(model, IntegratorKind::Path, 16);
    estimate.assert_is(truth, 0.01, "two lamps");
    // 64 pixels of 16 samples: the geometry term alone leaves a thousandth of the mean.
    assert!(estimate.error < 1e-3 * truth, "{estimate:?}");
}

#[test]
fn an_even_sky_and_a_gradient_give_the_irradiance_of_their_integrals() {
    for kind in BOTH {
        let mut model = floor();
        model.sky = Sky::Constant([2.0; 3]);
        on_the_floor(model, kind, 4).assert_is(1.6, 1e-3, "even sky");
        let mut model = floor();
        model.sky = Sky::Gradient { zenith: [4.0; 3], horizon: [1.0; 3], ground: [7.0; 3] };
        on_the_floor(model, kind, 256).assert_is(0.8 * 3.0, 2e-3, "gradient");
    }
}

#[test]
fn a_sun_gives_its_irradiance_by_the_cosine_whatever_its_size() {
    let direction = [0.6, -0.8, 0.0];
    for (angle, kinds) in [(0.0, &BOTH[..]), (0.0093, &BOTH[1..]), (0.6, &BOTH[..])] {
        for &kind in kinds {
            let model = floor().lit_by(Light::Sun { direction, irradiance: [3.0; 3], angle });
            on_the_floor(model, kind, 4096).assert_is(0.8 / PI * 3.0 * 0.8, 0.01, &format!("{kind}, angle {angle}"));
        }
    }
}

#[test]
fn points_and_spots_follow_the_inverse_square_and_the_cosine() {
    let position = [0.0, 3.0, 4.0];
    let cosine = 3.0 / 5.0;
    let truth = 0.8 / PI * 10.0 / 25.0 * cosine;
    for kind in BOTH {
        let point = Light::Point { position, intensity: [10.0; 3], range: f32::INFINITY };
        on_the_floor(floor().lit_by(point), kind, 4).assert_is(truth, 2e-3, "point");
        let spot = |direction| Light::Spot {
            position,
            direction,
            intensity: [10.0; 3],
            range: f32::INFINITY,
            inner_cos: 0.95,
            outer_cos: 0.9,
        };
        on_the_floor(floor().lit_by(spot([0.0, -0.6, -0.8])), kind, 4).assert_is(truth, 2e-3, "spot");
        let aside = on_the_floor(floor().lit_by(spot([0.0, -0.6, 0.8])), kind, 4);
        assert!(aside.mean.abs() < 1e-9, "{kind}: {aside:?}");
    }
}

#[test]
fn several_lights_add_up() {
    let lights = [
        Light::Point { position: [0.0, 2.0, 0.0], intensity: [4.0; 3], range: f32::INFINITY },
        Light::Point { position: [0.0, 0.5, 0.0], intensity: [0.1; 3], range: f32::INFINITY },
        Light::Sun { direction: [0.0, -1.0, 0.0], irradiance: [1.0; 3], angle: 0.0 },
        Light::Sun { direction: [0.0, -1.0, 0.0], irradiance: [0.5; 3], angle: 0.2 },
    ];
    for kind in BOTH {
        let model = lights.into_iter().fold(floor(), Model::lit_by);
        on_the_floor(model, kind, 4096).assert_is(0.8 / PI * (1.0 + 0.4 + 1.0 + 0.5), 0.01, "four lights");
    }
}

/// Fresnel's reflectances of a boundary by the textbook formulas: amplitudes from the two angles.
fn fresnel(angle: f64, ior: f64) -> (f64, f64) {
    let beyond = (angle.sin() / ior).asin();
    let across = ((angle - beyond).sin() / (angle + beyond).sin()).powi(2);
    let along = ((angle - beyond).tan() / (angle + beyond).tan()).powi(2);
    (across, along)
}

#[test]
fn reflection_and_transmission_of_glass_follow_fresnel() {
    // Above the boundary all radiance is one; below, one minus the sine of the depth angle.
    let sky = Sky::Gradient { zenith: [1.0; 3], horizon: [1.0; 3], ground: [0.0; 3] };
    let seen = |scatter, angle: f64, kind| {
        let material = Material { scatter, ..Material::diffuse([1.0; 3]) };
        let mut model = Model::default().with(&Shape::square(), material, Affine::from_scale([10.0; 3]));
        model.sky = sky;
        let eye = [angle.sin() as f32, angle.cos() as f32, 0.0];
        glimpse(&model.frame(), eye, [0.0; 3], kind, 1024, 0)
    };
    for kind in BOTH {
        for angle in [0.2, 0.8, 1.2, 1.4] {
            let (across, along) = fresnel(angle, 1.5);
            let reflected = 0.5 * (across + along);
            let beyond = (angle.sin() / 1.5).asin();
            let truth = reflected + (1.0 - reflected) * (1.0 - beyond.cos()) / 2.25;
            seen(Scatter::Dielectric { ior: 1.5 }, angle, kind).assert_is(truth, 0.02, &format!("boundary at {angle}"));

            let reflected = across / (1.0 + across) + along / (1.0 + along);
            let truth = reflected + (1.0 - reflected) * (1.0 - angle.cos());
            seen(Scatter::ThinDielectric { ior: 1.5 }, angle, kind).assert_is(truth, 0.02, &format!("pane at {angle}"));
        }
    }
}

#[test]
fn thin_glass_transmits_all_lights_by_one_minus_its_reflectance() {
    let thin_glass = |model: Model| {
        let material = Material { scatter: Scatter::ThinDielectric { ior: 1.5 }, ..Material::diffuse([0.5, 0.9, 1.0]) };
        model.with(&Shape::square(), material, Affine::from_translation([0.0, 0.3, 0.0]) * Affine::from_scale([0.8; 3]))
    };
    let (across, along) = fresnel(1e-9_f64.max(0.6435), 1.5);
    let passed = 0.5 * (1.0 - (across / (1.0 + across) + along / (1.0 + along)));
    for kind in BOTH {
        // At an angle whose cosine is 0.8.
        let sun = Light::Sun { direction: [0.6, -0.8, 0.0], irradiance: [3.0; 3], angle: 0.0 };
        let frame = thin_glass(floor()).lit_by(sun).frame();
        let under = glimpse(&frame, [0.3, 0.1, 0.0], [0.0; 3], kind, 4, 0);
        // The light that the glass reflects back to the floor is seen in a mirror image of the
        // floor; it is small, since the floor around the glass is lit fully, and so is its mirror
        // image.
        let direct = 0.8 / PI * 3.0 * 0.8 * passed;
        assert!(under.mean > direct * 0.999 && under.mean < direct * 1.25, "{kind}: {under:?} for {direct}");
    }
    // An area light seen through the glass: both sampling techniques have to account for the glass.
    let lamp = Affine::from_translation([0.0, 0.6, 0.0]) * Affine::from_scale([0.2; 3]);
    let model = || thin_glass(floor()).with(&Shape::square(), Material::emissive([20.0; 3]), lamp);
    let simple = glimpse(&model().frame(), [0.3, 0.1, 0.0], [0.0; 3], IntegratorKind::Simple, 8192, 0);
    let path = glimpse(&model().frame(), [0.3, 0.1, 0.0], [0.0; 3], IntegratorKind::Path, 256, 0);
    let error = (simple.error.powi(2) + path.error.powi(2)).sqrt();
    assert!((simple.mean - path.mean).abs() < 5.0 * error && error < 0.01 * path.mean, "{simple:?} {path:?}");
}
