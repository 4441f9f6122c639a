//! Furnace tests: scenes in which every picture is known.

mod common;

use common::{Model, Shape, glimpse, picture, placed, settings};
use kinetree::Affine;
use kinetree_render::IntegratorKind;
use kinetree_world::{Camera, Material, Sky};

#[test]
fn a_closed_box_that_emits_and_reflects_one_half_shows_twice_its_emission() {
    let material = Material { emission: [3.0, 2.0, 1.0], ..Material::diffuse([0.5; 3]) };
    let frame = Model::default().with(&Shape::cube().inverted(), material, Affine::IDENTITY).frame();
    let camera = Camera::look_at([0.3, -0.2, 0.5], [-1.0, 0.4, -1.0], 2.0);
    for (kind, spp) in [(IntegratorKind::Simple, 4), (IntegratorKind::Path, 1 << 15)] {
        let film = picture(&frame, &camera, &settings(kind, 8, spp)).film;
        for pixel in film.pixels() {
            for (channel, emitted) in [3.0, 2.0, 1.0].into_iter().enumerate() {
                assert!((pixel[channel] / (2.0 * emitted) - 1.0).abs() < 0.005, "{kind}: {pixel:?}");
            }
        }
    }
}

#[test]
fn a_white_convex_body_is_invisible_under_an_even_sky() {
    for shape in [Shape::cube(), Shape::sphere(12)] {
        let placement = placed([1.0, 2.0, 0.5], [1.0, 2.0, 3.0], 0.7, [0.1, 0.2, 0.3]);
        let frame = Model::under(1.0).with(&shape, Material::diffuse([1.0; 3]), placement).frame();
        for kind in [IntegratorKind::Simple, IntegratorKind::Path] {
            let camera = Camera::look_at([4.0, 3.0, 5.0], [0.0; 3], 0.7);
            let film = picture(&frame, &camera, &settings(kind, 24, 16)).film;
            // Both sampling techniques find an even sky with the pdf of the cosine: there is no
            // noise, only rounding.
            assert!(film.pixels().iter().all(|pixel| (pixel[0] - 1.0).abs() < 1e-3), "{kind}");
        }
    }
}

#[test]
fn a_clear_glass_body_is_invisible_under_an_even_sky() {
    let glass = Material { base_color: [1.0; 4], ..Material::glass(1.5) };
    let frame = Model::under(1.0).with(&Shape::sphere(24).smooth(), glass, Affine::IDENTITY).frame();
    for kind in [IntegratorKind::Simple, IntegratorKind::Path] {
        let camera = Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], 0.6);
        let film = picture(&frame, &camera, &settings(kind, 16, 64)).film;
        // Paths caught inside by total internal reflection between facets end after 64 bounces;
        // there are next to none.
        assert!(film.pixels().iter().all(|pixel| (pixel[0] - 1.0).abs() < 0.02), "{kind}");
        assert!((film.mean()[0] - 1.0).abs() < 2e-3, "{kind}: {:?}", film.mean());
    }
}

/// A grey convex object under a white sky has exactly its reflectance as radiance; every ray that
/// hit the surface it left would count it twice.
#[test]
fn no_ray_hits_the_surface_it_left() {
    let far = [1234.5, -567.8, 910.1];
    let back = far.map(|x| -x);
    let grey = || Material::diffuse([0.5; 3]);
    let turned = |scale: f32, position| placed([scale, 1.7 * scale, -0.6 * scale], [1.0, -2.0, 0.5], 1.1, position);
    let cases = [
        ("near", Shape::cube(), turned(1.0, [0.0; 3]), [0.0; 3], 1.0),
        ("a millimetre, a kilometre away", Shape::sphere(8), turned(1e-3, far), far, 1e-3),
        ("ten metres, a kilometre away", Shape::sphere(8), turned(10.0, far), far, 10.0),
        ("a kilometre away in its own space", Shape::cube().moved(far, 1.0), Affine::IDENTITY, far, 1.0),
        ("large coordinates that cancel", Shape::cube().moved(far, 1.0), Affine::from_translation(back), [0.0; 3], 1.0),
        ("a hundred kilometres wide", Shape::sphere(16), turned(1e5, [0.0; 3]), [0.0; 3], 1e5),
    ];
    for (name, shape, placement, center, size) in cases {
        for motion_of_eye in [[3.0, 1.0, 2.0], [-2.0, -3.0, 1.0], [0.1, 4.0, -0.2]] {
            let frame = Model::under(1.0).with(&shape, grey(), placement).frame();
            let eye = std::array::from_fn(|axis| center[axis] + size * motion_of_eye[axis]);
            let camera = Camera::look_at(eye, center, 0.1);
            for kind in [IntegratorKind::Simple, IntegratorKind::Path] {
                let film = picture(&frame, &camera, &settings(kind, 16, 8)).film;
                let worst = film.pixels().iter().map(|pixel| (pixel[0] - 0.5).abs()).fold(0.0, f32::max);
                assert!(worst < 1e-4, "{name}, {kind}: off by {worst}");
            }
        }
    }
}

#[test]
fn smooth_normals_neither_add_light_nor_leak_it() {
    // A coarse sphere with smooth normals may lose a little at facets that are seen at grazing
    // angles, and gain nothing.
    let white = Material::diffuse([1.0; 3]);
    let frame = Model::under(1.0).with(&Shape::sphere(8).smooth(), white.clone(), Affine::IDENTITY).frame();
    for kind in [IntegratorKind::Simple, IntegratorKind::Path] {
        let film = picture(&frame, &Camera::look_at([0.0, 1.0, 4.0], [0.0; 3], 0.6), &settings(kind, 16, 64)).film;
        assert!(film.pixels().iter().all(|pixel| pixel[0] < 1.0 + 1e-3 && pixel[0] > 0.8), "{kind}");
    }
    // A room without windows, whose normals are smooth, stays black under any sky.
    let mut model = Model::default().with(&Shape::sphere(6).smooth().inverted(), white, Affine::IDENTITY);
    model.sky = Sky::Constant([1e3; 3]);
    let frame = model.frame();
    for kind in [IntegratorKind::Simple, IntegratorKind::Path] {
        let inside = glimpse(&frame, [0.0; 3], [0.3, 0.8, -0.5], kind, 64, 0);
        assert!(inside.mean.abs() < 1e-9, "{kind}: {inside:?}");
    }
}
