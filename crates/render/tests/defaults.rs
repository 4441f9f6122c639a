//! The default camera, lighting and exposure.

mod common;

use std::sync::Arc;

use common::{Model, Shape, picture, placed, settings};
use kinetree::{Affine, Mesh, Motion, Ray, Scene};
use kinetree_render::{IntegratorKind, daylight, default_camera, default_lighting, is_dark, metered_exposure};
use kinetree_world::{Camera, Frame, Light, Material, MaterialSet, Sky, Surface, World};

fn grey() -> Material {
    Material::diffuse([0.5; 3])
}

/// The fraction of the picture that shows surfaces within a distance of a point.
fn shows(frame: &Frame, camera: &Camera, center: [f32; 3], distance: f32) -> f32 {
    let placement = camera.world_from_camera;
    let half = (0.5 * camera.fov_y).tan();
    let mut count = 0;
    for i in 0..40 * 40 {
        let (x, y) = ((i % 40) as f32 / 20.0 - 0.975, (i / 40) as f32 / 20.0 - 0.975);
        let ray = Ray::new(camera.position(), placement.transform_vector([x * half, y * half, -1.0]));
        if let Some(hit) = frame.snapshot.closest_hit(&ray) {
            let at = ray.at(hit.t);
            let apart: f32 = (0..3).map(|axis| (at[axis] - center[axis]).powi(2)).sum();
            count += u32::from(apart < distance * distance);
        }
    }
    count as f32 / 1600.0
}

fn crowd() -> Model {
    (0..25).fold(Model::default(), |model, i| {
        let position = [(i % 5) as f32 * 2.0 - 4.0, 0.5, (i / 5) as f32 * 2.0 - 4.0];
        model.with(&Shape::sphere(8), grey(), placed([0.8; 3], [0.0, 1.0, 0.0], i as f32, position))
    })
}

#[test]
fn a_few_triangles_kilometres_away_do_not_shrink_the_picture_to_a_dot() {
    let far = Affine::from_translation([9000.0, 4000.0, -7000.0]);
    let dome = Affine::from_scale([5000.0; 3]);
    let frame = crowd()
        .with(&Shape::square(), grey(), far)
        .with(&Shape::sphere(6).inverted(), grey(), dome)
        .with(&Shape::square(), grey(), Affine::from_scale([3000.0, 1.0, 3000.0]))
        .frame();
    let camera = default_camera(&frame, 1.0);
    let part = shows(&frame, &camera, [0.0; 3], 8.0);
    assert!(part > 0.3, "{part} by {camera:?}");
    assert!(camera.position()[1] > 0.0, "{camera:?}");
}

#[test]
fn a_closed_room_is_seen_from_within() {
    for walls in [Shape::cube(), Shape::cube().inverted()] {
        let mut model = Model::default().with(&walls, grey(), Affine::from_scale([4.0, 1.5, 3.0]));
        // Furniture of many triangles along the walls, and a table.
        for i in 0..12 {
            let angle = i as f32 * 0.52;
            let position = [3.2 * angle.sin(), -1.0 + 0.3 * (i % 3) as f32, 2.3 * angle.cos()];
            model = model.with(&Shape::sphere(10), grey(), placed([0.3; 3], [0.0, 1.0, 0.0], angle, position));
        }
        let frame =
            model.with(&Shape::cube(), grey(), placed([0.6, 0.4, 0.6], [0.0, 1.0, 0.0], 0.3, [0.0, -1.1, 0.0])).frame();
        let camera = default_camera(&frame, 16.0 / 9.0);
        let [x, y, z] = camera.position();
        assert!(x.abs() < 4.0 && y.abs() < 1.5 && z.abs() < 3.0, "{camera:?}");
        let part = shows(&frame, &camera, [0.0; 3], 10.0);
        assert!(part > 0.9, "{part}");
    }
}

#[test]
fn a_single_body_is_seen_from_outside_and_fills_the_picture_well() {
    for (size, center) in [(1.0, [0.0; 3]), (1e-3, [5.0, 0.0, 0.0]), (1e4, [-1e4, 2e4, 0.0])] {
        let placement = Affine::from_translation(center) * Affine::from_scale([size, 0.5 * size, 2.0 * size]);
        let frame = Model::default().with(&Shape::sphere(16), grey(), placement).frame();
        let camera = default_camera(&frame, 1.5);
        let apart: f32 = (0..3).map(|axis| (camera.position()[axis] - center[axis]).powi(2)).sum::<f32>().sqrt();
        assert!(apart > size, "{camera:?}");
        let part = shows(&frame, &camera, center, 3.0 * size);
        assert!((0.15..=1.0).contains(&part), "{part} for {size} by {camera:?}");
    }
}

/// Projects a point: from -1 to 1 to the right and up, and its distance.
fn seen_at(camera: &Camera, aspect: f32, point: [f32; 3]) -> [f32; 3] {
    let placement = camera.world_from_camera;
    let along = |axis: [f32; 3]| (0..3).map(|i| axis[i] * (point[i] - camera.position()[i])).sum::<f32>();
    let (depth, half) = (-along(placement.z_axis), (0.5 * camera.fov_y).tan());
    [along(placement.x_axis) / (depth * half * aspect), along(placement.y_axis) / (depth * half), depth]
}

#[test]
fn a_race_in_a_wide_land_is_seen_from_near() {
    let cars: Vec<[f32; 3]> = (0..6).map(|i| [150.0 + 6.0 * i as f32, 1.0, -80.0 + 4.0 * (i % 2) as f32]).collect();
    let mut model = Model::default().with(&Shape::square(), grey(), Affine::from_scale([800.0, 1.0, 800.0]));
    for i in 0..150 {
        let position = [(i * 37 % 400) as f32 - 200.0, 0.0, (i * 91 % 400) as f32 - 200.0];
        model = model.with(&Shape::sphere(6), grey(), placed([1.5, 5.0, 1.5], [0.0, 1.0, 0.0], 0.0, position));
    }
    for &car in &cars {
        let body = placed([2.0, 0.8, 1.0], [0.0, 1.0, 0.0], 0.1, car);
        model = model.with_moving(&Shape::cube(), grey(), body, Motion::Rigid);
        for x in [-1.3, 1.3] {
            let wheel = placed([0.4; 3], [0.0, 1.0, 0.0], 0.0, [car[0] + x, 0.4, car[2] + 1.0]);
            model = model.with_moving(&Shape::sphere(4), grey(), wheel, Motion::Rigid);
        }
    }
    // A bird alone, and a train.
    let bird = Affine::from_translation([-100.0, 60.0, 20.0]);
    let train = Affine::from_translation([0.0, 3.0, 150.0]) * Affine::from_scale([60.0, 3.0, 2.0]);
    let frame = model
        .with_moving(&Shape::cube(), grey(), bird, Motion::Rigid)
        .with_moving(&Shape::cube(), grey(), train, Motion::Rigid)
        .frame();
    let camera = default_camera(&frame, 16.0 / 9.0);
    for car in cars {
        let [x, y, depth] = seen_at(&camera, 16.0 / 9.0, car);
        assert!(depth > 0.0 && x.abs() < 1.0 && y.abs() < 1.0, "{car:?} is at {x} {y} {depth} of {camera:?}");
        let part = 4.0 / (2.0 * depth * (0.5 * camera.fov_y).tan() * 16.0 / 9.0);
        assert!((0.03..0.4).contains(&part), "{car:?} takes {part} of the width of {camera:?}");
    }
}

#[test]
fn where_all_moves_all_of_it_is_in_the_picture() {
    let places: Vec<[f32; 3]> = (0..9).map(|i| [(i % 3) as f32 * 3.0, 0.0, (i / 3) as f32 * 2.5]).collect();
    let frame = places
        .iter()
        .fold(Model::default(), |model, &place| {
            model.with_moving(&Shape::sphere(8), grey(), Affine::from_translation(place), Motion::Deforming)
        })
        .frame();
    let camera = default_camera(&frame, 1.5);
    for place in places {
        for side in [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]] {
            let [x, y, depth] = seen_at(&camera, 1.5, [0, 1, 2].map(|axis| place[axis] + 0.9 * side[axis]));
            assert!(depth > 1.0 && x.abs() < 1.0 && y.abs() < 1.0, "{place:?} is at {x} {y} {depth} of {camera:?}");
        }
    }
}

/// An object with little surface in its outer parts: ears, hands, a tail.
fn figure() -> Shape {
    let mut shape = Shape::sphere(16);
    for (tip, side) in [([0.5, 2.2, 0.0], [0.1, 0.0, 0.0]), ([-2.6, 0.1, 0.2], [0.0, 0.1, 0.0])] {
        let base = shape.positions.len() as u32;
        shape.positions.extend([tip, side, side.map(|x: f32| -x)]);
        shape.uvs.extend([[0.0; 2]; 3]);
        shape.triangles.push([base, base + 1, base + 2]);
    }
    shape
}

#[test]
fn a_single_object_is_in_the_picture_as_a_whole() {
    let shape = figure();
    let around = [
        ("nothing", None),
        ("the ground", Some((Shape::square(), placed([300.0; 3], [0.0, 1.0, 0.0], 0.1, [0.0, -1.0, 0.0])))),
        ("a dome", Some((Shape::sphere(64).inverted(), Affine::from_scale([500.0; 3])))),
    ];
    for (name, backdrop) in &around {
        for motion in [Motion::Static, Motion::Deforming] {
            let mut model = Model::default().with_moving(&shape, grey(), Affine::IDENTITY, motion);
            if let Some((shape, placement)) = backdrop {
                model = model.with(shape, grey(), *placement);
            }
            let frame = model.frame();
            for aspect in [0.7, 1.0, 16.0 / 9.0] {
                let camera = default_camera(&frame, aspect);
                let mut widest = 0.0_f32;
                for &point in &shape.positions {
                    let [x, y, depth] = seen_at(&camera, aspect, point);
                    let is_in = depth > 0.0 && x.abs() < 1.0 && y.abs() < 1.0;
                    assert!(is_in, "with {name}: {point:?} is at {x} {y} of {camera:?}");
                    widest = widest.max(x.abs()).max(y.abs());
                }
                assert!(widest > 0.75, "with {name}: lost in the picture of {camera:?}");
            }
        }
    }
}

#[test]
fn awkward_frames_have_a_camera_and_always_the_same() {
    let flat = Model::default().with(&Shape::square(), grey(), Affine::IDENTITY);
    let point =
        Model::default().with(&Shape { triangles: vec![[0, 0, 0]], ..Shape::square() }, grey(), Affine::IDENTITY);
    let huge = Model::default().with(&Shape::cube(), grey(), Affine::from_scale([1e18; 3]));
    for model in [Model::default(), flat, point, huge, crowd()] {
        let frame = model.frame();
        for aspect in [1.0, 0.0, f32::NAN, 100.0] {
            let camera = default_camera(&frame, aspect);
            assert!(camera.world_from_camera.is_finite() && camera.fov_y > 0.0, "{camera:?}");
            assert_eq!(camera, default_camera(&frame, aspect));
        }
    }
}

fn world(material: Material, sky: Sky) -> World {
    let shape = Shape::cube();
    let mut scene = Scene::new();
    let mesh = Mesh::new(&shape.positions, &shape.triangles).expect("a good mesh");
    let mesh = scene.add_mesh(mesh, Motion::Static).expect("a mesh fits");
    let instance = scene.add_instance(scene.root(), mesh, Affine::IDENTITY).expect("an instance fits");
    let material_set =
        MaterialSet { materials: vec![material], surfaces: vec![Surface::of(0)], ..MaterialSet::default() };
    let mut world = World::new(scene);
    world.material_set = Arc::new(material_set);
    world.material_bindings.bind(instance, 0);
    world.sky = sky;
    world
}

#[test]
fn a_dark_world_gets_daylight_and_a_lit_one_stays_as_it_is() {
    let black = Sky::Constant([0.0; 3]);
    let mut dark = world(grey(), black);
    assert!(default_lighting(&mut dark).expect("nothing moves"));
    assert!(!default_lighting(&mut dark).expect("nothing moves"));
    assert_eq!(dark.lights.len(), 1);

    assert!(!default_lighting(&mut world(Material::emissive([1.0; 3]), black)).expect("nothing moves"));
    assert!(!default_lighting(&mut world(grey(), Sky::Constant([0.1; 3]))).expect("nothing moves"));
}

#[test]
fn lamps_light_a_scene_when_most_of_it_is_in_their_light() {
    let ground = || Model::default().with(&Shape::square(), grey(), Affine::from_scale([100.0; 3]));
    let camera = Camera::look_at([0.0, 30.0, 60.0], [0.0; 3], 0.8);
    // A floodlight.
    let lamp = |range| Light::Point { position: [0.0, 20.0, 0.0], intensity: [1000.0; 3], range };
    assert!(is_dark(&ground().frame(), &camera));
    assert!(is_dark(&ground().lit_by(lamp(21.0)).frame(), &camera));
    assert!(!is_dark(&ground().lit_by(lamp(f32::INFINITY)).frame(), &camera));
    // An indicator that glows.
    let indicator = placed([0.1; 3], [0.0, 1.0, 0.0], 0.0, [0.0, -1.0, 0.0]);
    assert!(is_dark(&ground().with(&Shape::cube(), Material::emissive([9.0; 3]), indicator).frame(), &camera));
}

/// The exposure of a picture of a frame in daylight.
fn exposure_in_daylight(model: Model, camera: &Camera) -> f32 {
    let (sky, sun) = daylight();
    let mut model = model.lit_by(sun);
    model.sky = sky;
    let frame = model.frame();
    let film = picture(&frame, camera, &settings(IntegratorKind::Path, 64, 16)).film;
    metered_exposure(&frame, camera, &film)
}

#[test]
fn the_background_does_not_count_for_the_exposure() {
    let ball = || Model::default().with(&Shape::sphere(16), grey(), Affine::IDENTITY);
    // The same side of the same ball, large in the picture and small in front of the sky.
    let [near, far] =
        [0.55, 1.6].map(|fov| exposure_in_daylight(ball(), &Camera::look_at([3.0, 1.0, 3.0], [0.0; 3], fov)));
    assert!((near / far - 1.0).abs() < 0.15, "{near} {far}");
    // A mountain far behind is background as well.
    let white = Material::diffuse([1.0; 3]);
    let mountain = Affine::from_translation([-3000.0, 0.0, -3000.0]) * Affine::from_scale([1000.0; 3]);
    let before = ball().with(&Shape::sphere(4), white, mountain);
    let before = exposure_in_daylight(before, &Camera::look_at([3.0, 1.0, 3.0], [0.0; 3], 1.2));
    assert!((before / near - 1.0).abs() < 0.15, "{near} {before}");
}

#[test]
fn in_daylight_black_stays_dark_and_white_bright() {
    let exposure = |reflectance: f32| {
        let ground = Affine::from_scale([100.0; 3]);
        let model = Model::default().with(&Shape::square(), Material::diffuse([reflectance; 3]), ground);
        exposure_in_daylight(model, &Camera::look_at([0.0, 3.0, 4.0], [0.0; 3], 0.8))
    };
    let (coal, card, snow) = (exposure(0.02), exposure(0.18), exposure(0.95));
    assert!(coal <= 1.6 * card && snow >= 0.45 * card, "{coal} {card} {snow}");
    // Coal is below a quarter of the grey card's brightness in the picture, snow above twice.
    assert!(coal * 0.02 < 0.25 * card * 0.18 && snow * 0.95 > 2.0 * card * 0.18, "{coal} {card} {snow}");
}

#[test]
fn where_daylight_does_not_get_in_there_is_a_lamp() {
    let black = Sky::Constant([0.0; 3]);
    let mut chamber = world(grey(), black);
    let eye = Camera::look_at([0.5, 0.2, 0.5], [-1.0, -0.3, -1.0], 1.0);
    chamber.cameras.push(kinetree_world::CameraSource { name: String::new(), node: None, camera: eye });
    assert!(default_lighting(&mut chamber).expect("nothing moves"));
    assert_eq!(chamber.sky, black);
    assert!(matches!(chamber.lights[..], [kinetree_world::LightSource { light: Light::Point { .. }, .. }]));
    let frame = chamber.frame(0.0).expect("nothing moves");
    let film = picture(&frame, &eye, &settings(IntegratorKind::Path, 32, 16)).film;
    let stops = metered_exposure(&frame, &eye, &film).log2();
    assert!(stops.abs() < 4.0, "{stops}");
    assert!(!default_lighting(&mut chamber).expect("nothing moves"), "it is lit now");
}

#[test]
fn triangles_without_area_do_not_frame_anything() {
    let mut shape = Shape::sphere(8);
    let far = shape.positions.len() as u32;
    shape.positions.push([500.0, 0.0, 0.0]);
    shape.triangles.extend(std::iter::repeat_n([far; 3], 5000));
    let frame = Model::default().with(&shape, grey(), Affine::IDENTITY).frame();
    let alone = Model::default().with(&Shape::sphere(8), grey(), Affine::IDENTITY).frame();
    assert_eq!(default_camera(&frame, 1.5), default_camera(&alone, 1.5));
}
