//! Alpha, mirrored and unevenly scaled instances, and bad data.

mod common;

use common::{Estimate, Model, Shape, glimpse, picture, placed, settings};
use kinetree::Affine;
use kinetree_render::IntegratorKind;
use kinetree_world::{Alpha, Camera, Filter, Light, Material, Scatter, Sky, Texture, Wrap};

const BOTH: [IntegratorKind; 2] = [IntegratorKind::Simple, IntegratorKind::Path];

/// Opaque on the left (u below a half), and with an alpha on the right.
fn half_there(alpha: u8) -> Texture {
    let texels = vec![[255; 4], [255, 255, 255, alpha]];
    Texture { width: 2, height: 1, texels, srgb: true, wrap: [Wrap::Clamp; 2], filter: Filter::Nearest }
}

fn veil(alpha: Alpha, texture_alpha: u8) -> Model {
    let mut model = Model::under(1.0);
    model.material_set.textures.push(half_there(texture_alpha));
    let material = Material { alpha, base_color_texture: Some(0.into()), ..Material::diffuse([0.0; 3]) };
    model.with(&Shape::square(), material, Affine::IDENTITY)
}

/// Straight down, +x to the right, one unit wide.
fn from_above() -> Camera {
    let placement = Affine::from_translation([0.0, 5.0, 0.0])
        * Affine::from_axis_angle([1.0, 0.0, 0.0], -std::f32::consts::FRAC_PI_2);
    Camera { world_from_camera: placement, fov_y: 2.0 * (0.5_f32 / 5.0).atan() }
}

#[test]
fn a_masked_surface_lets_exactly_the_masked_part_through() {
    for kind in BOTH {
        let film = picture(&veil(Alpha::Mask { cutoff: 0.5 }, 127).frame(), &from_above(), &settings(kind, 16, 4)).film;
        for y in 1..15 {
            for x in 1..15 {
                let expected = if x < 8 { 0.0 } else { 1.0 };
                assert!((film.pixel([x, y])[0] - expected).abs() < 1e-6, "{kind}: {x} {y}");
            }
        }
        let solid =
            picture(&veil(Alpha::Mask { cutoff: 0.5 }, 128).frame(), &from_above(), &settings(kind, 16, 4)).film;
        assert!(solid.pixel([12, 8])[0].abs() < 1e-6, "{kind}");
    }
}

#[test]
fn an_opaque_surface_ignores_its_alpha() {
    let film = picture(&veil(Alpha::Opaque, 0).frame(), &from_above(), &settings(IntegratorKind::Path, 16, 4)).film;
    assert!(film.pixel([12, 8])[0].abs() < 1e-6);
}

#[test]
fn a_blended_surface_transmits_one_minus_alpha() {
    for kind in BOTH {
        let film = picture(&veil(Alpha::Blend, 51).frame(), &from_above(), &settings(kind, 32, 64)).film;
        let right: Vec<f64> = (0..32 * 14).map(|i| f64::from(film.pixel([17 + i % 14, 1 + i / 15])[0])).collect();
        Estimate::of(&right).assert_is(0.8, 0.02, kind.name());
    }
}

#[test]
fn shadows_have_the_holes_of_what_casts_them() {
    for kind in BOTH {
        let mut model = veil(Alpha::Mask { cutoff: 0.5 }, 0);
        model.sky = Sky::Constant([0.0; 3]);
        let ground = placed([100.0; 3], [0.0, 1.0, 0.0], 0.0, [0.0, -1.0, 0.0]);
        let sun = Light::Sun { direction: [0.0, -1.0, 0.0], irradiance: [1.0; 3], angle: 0.0 };
        let frame = model.with(&Shape::square(), Material::diffuse([1.0; 3]), ground).lit_by(sun).frame();
        let lit = |x: f32| glimpse(&frame, [x, -0.5, 2.0], [x, -1.0, 0.1], kind, 1, 0).mean;
        assert!(lit(-0.2).abs() < 1e-6, "{kind}");
        assert!((lit(0.2) * std::f64::consts::PI - 1.0).abs() < 0.01, "{kind}");
    }
}

#[test]
fn vertex_colours_textures_and_base_colour_multiply() {
    let mut model = Model::under(1.0);
    model.material_set.textures.push(Texture { srgb: false, ..half_there(255) });
    model.material_set.textures[0].texels = vec![[255, 128, 64, 255]; 2];
    let material = Material { base_color_texture: Some(0.into()), ..Material::diffuse([0.5, 0.5, 1.0]) };
    let mut model = model.with(&Shape::square(), material, Affine::IDENTITY);
    model.material_set.surfaces[0].colors = vec![[0.25, 1.0, 1.0, 1.0]; 4];
    let film = picture(&model.frame(), &from_above(), &settings(IntegratorKind::Path, 8, 8)).film;
    let expected = [0.125, 0.5 * 128.0 / 255.0, 64.0 / 255.0];
    for channel in 0..3 {
        assert!((film.pixel([4, 4])[channel] - expected[channel]).abs() < 2e-3, "{:?}", film.pixel([4, 4]));
    }
}

#[test]
fn mirrored_and_stretched_instances_are_lit_by_their_normals_in_the_world() {
    let sun = Light::Sun { direction: [0.0, -1.0, 0.0], irradiance: [1.0; 3], angle: 0.0 };
    // A sloped roof in object space, flattened or steepened by its instance, with normals of the
    // mesh and without.
    for (scale, turn) in
        [([1.0, 0.5, 1.0], 0.0), ([-2.0, 3.0, 1.0], 0.4), ([1.0, 1.0, -0.3], -0.2), ([-1.0, 0.2, -4.0], 0.9)]
    {
        let slope = 0.7_f32;
        let tilted = |[x, _, z]: [f32; 3]| [x, slope * x, z];
        let mut shape = Shape::square();
        shape.positions = shape.positions.into_iter().map(tilted).collect();
        for normals in [None, Some(vec![[-slope, 1.0, 0.0]; 4])] {
            shape.normals = normals;
            let placement = placed(scale, [0.0, 1.0, 0.0], turn, [0.0; 3]);
            let steep = f64::from(slope * scale[1] / scale[0]);
            let truth = 1.0 / (1.0 + steep * steep).sqrt();
            for kind in BOTH {
                let model = Model::default().with(&shape, Material::diffuse([1.0; 3]), placement).lit_by(sun);
                let seen = glimpse(&model.frame(), [0.0, 3.0, 0.1], [0.0; 3], kind, 1, 0);
                assert!((seen.mean * std::f64::consts::PI - truth).abs() < 1e-3, "{kind} {scale:?}: {seen:?} {truth}");
            }
        }
    }
}

#[test]
fn one_sided_lamps_shine_from_their_front_however_they_are_placed() {
    let lamp = Material { two_sided: false, ..Material::emissive([5.0; 3]) };
    for scale in [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, 2.0, -3.0], [-0.5, 1.0, -1.0]] {
        let frame = Model::default().with(&Shape::square(), lamp.clone(), Affine::from_scale(scale)).frame();
        for kind in BOTH {
            let above = glimpse(&frame, [0.1, 1.0, 0.0], [0.0; 3], kind, 1, 0).mean;
            let below = glimpse(&frame, [0.1, -1.0, 0.0], [0.0; 3], kind, 1, 0).mean;
            assert!((above - 5.0).abs() < 1e-6 && below.abs() < 1e-6, "{kind} {scale:?}: {above} {below}");
        }
    }
}

#[test]
fn bad_data_never_reaches_the_film() {
    let nan = f32::NAN;
    let mut shape = Shape::sphere(4).smooth();
    // Triangles without area, normals without length, texture coordinates and colours that are NaN.
    shape.triangles.extend([[0, 0, 0], [1, 1, 2], [3, 4, 3]]);
    shape.normals = shape.normals.map(|mut normals| {
        normals.iter_mut().step_by(3).for_each(|normal| *normal = [0.0; 3]);
        normals.iter_mut().skip(1).step_by(5).for_each(|normal| *normal = [1e-38, -1e-38, 0.0]);
        normals
    });
    shape.uvs.iter_mut().step_by(2).for_each(|uv| *uv = [nan, f32::INFINITY]);
    let materials = [
        Material { base_color: [nan, -1.0, f32::INFINITY, nan], alpha: Alpha::Blend, ..Material::default() },
        Material { emission: [nan, 1.0, -5.0], base_color_texture: Some(77.into()), ..Material::default() },
        Material { base_color: [0.5, nan, 2.0, 1.0], alpha: Alpha::Mask { cutoff: nan }, ..Material::default() },
        Material { emission: [1.0; 3], emission_texture: Some(0.into()), ..Material::default() },
        Material::glass(nan),
        Material::glass(0.0),
        Material::glass(-1.5),
        Material { scatter: Scatter::ThinDielectric { ior: f32::INFINITY }, ..Material::default() },
    ];
    let lights = [
        Light::Point { position: [nan; 3], intensity: [1.0; 3], range: 1.0 },
        Light::Point { position: [0.0; 3], intensity: [nan, f32::INFINITY, 1.0], range: nan },
        Light::Sun { direction: [0.0; 3], irradiance: [1.0; 3], angle: nan },
        Light::Sun { direction: [0.0, -1.0, 0.0], irradiance: [1.0; 3], angle: 1e9 },
        Light::Spot {
            position: [0.0, 3.0, 0.0],
            direction: [0.0, -1.0, 0.0],
            intensity: [1.0; 3],
            range: f32::INFINITY,
            inner_cos: nan,
            outer_cos: nan,
        },
    ];
    let mut model = Model::under(1.0);
    model.sky = Sky::Gradient { zenith: [nan; 3], horizon: [1.0, -1.0, 2.0], ground: [0.0; 3] };
    model.material_set.textures.push(Texture { texels: Vec::new(), ..half_there(9) });
    for (index, material) in materials.into_iter().enumerate() {
        let place = Affine::from_translation([(index % 4) as f32 * 2.0 - 3.0, 0.0, (index / 4) as f32 * 2.0]);
        model = model.with(&shape, material, place);
    }
    // Surfaces and materials that do not exist.
    model.material_set.surfaces[2].parts[0].material = 1000;
    model.material_set.surfaces[3].parts[0].first_triangle = 10;
    model.material_set.surfaces[3].parts.push(kinetree_world::Part { first_triangle: 5, material: 0 });
    model.material_set.surfaces.pop();
    let frame = lights.into_iter().fold(model, Model::lit_by).frame();
    for kind in IntegratorKind::ALL {
        picture(&frame, &Camera::look_at([0.0, 2.0, 8.0], [0.0; 3], 0.9), &settings(kind, 32, 16));
    }
}
