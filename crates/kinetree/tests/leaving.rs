//! Rays that leave surfaces: they do not meet the triangle they left, see what lies close to it,
//! and stay in closed rooms.

mod common;

use common::Random;
use kinetree::{Affine, Coherence, Hit, Mesh, Motion, Precision, Ray, Scene, Snapshot};

type Point = [f64; 3];

fn wide(v: [f32; 3]) -> Point {
    v.map(f64::from)
}

fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: Point) -> Point {
    let length = dot(v, v).sqrt();
    v.map(|x| x / length)
}

fn largest(v: Point) -> f64 {
    v.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// One mesh, placed once.
fn scene(positions: &[[f32; 3]], triangles: &[[u32; 3]], placement: Affine, precision: Precision) -> Snapshot {
    let mut scene = Scene::new();
    let mesh = Mesh::new(positions, triangles).unwrap().with_precision(precision);
    let mesh = scene.add_mesh(mesh, Motion::Static).unwrap();
    scene.add_instance(scene.root(), mesh, placement).unwrap();
    scene.commit()
}

/// A triangle of a size, somewhere within a distance of the origin, that may be as thin as a part
/// of its length.
fn triangle(random: &mut Random, size: f32, distance: f32, thinnest: f32) -> [[f32; 3]; 3] {
    let center = random.point(distance);
    let along = random.direction();
    let across = cross(wide(along), wide(random.direction())).map(|x| x as f32);
    let thin = if random.unit() < 0.3 { thinnest.powf(random.unit()) } else { 1.0 };
    let (along, aside) = (along.map(|x| x * size), across.map(|x| x * size * thin));
    let at = |s: f32, t: f32| [0, 1, 2].map(|i| center[i] + s * along[i] + t * aside[i]);
    [at(-1.0, -0.5), at(1.0, -0.4), at(random.within(-1.0, 1.0), 1.0)]
}

/// A ray from somewhere to a place on a triangle in the world.
fn towards(random: &mut Random, corners: [Point; 3], from: f64) -> Ray {
    let (mut u, mut v) = (f64::from(random.unit()), f64::from(random.unit()));
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    let [a, b, c] = corners;
    let at = [0, 1, 2].map(|i| a[i] * (1.0 - u - v) + b[i] * u + c[i] * v);
    let away = wide(random.direction());
    let origin = [0, 1, 2].map(|i| (at[i] + from * away[i]) as f32);
    Ray::new(origin, [0, 1, 2].map(|i| (at[i] - f64::from(origin[i])) as f32))
}

fn in_world(placement: &Affine, point: [f32; 3]) -> Point {
    let [x, y, z, moved] = [placement.x_axis, placement.y_axis, placement.z_axis, placement.translation].map(wide);
    let p = wide(point);
    [0, 1, 2].map(|i| x[i] * p[0] + y[i] * p[1] + z[i] * p[2] + moved[i])
}

/// Every way of asking misses.
fn misses(view: &Snapshot, ray: &Ray) -> bool {
    let (mut hits, rays) = ([None; 64], [*ray; 64]);
    view.closest_hits(&rays, &mut hits, Coherence::Coherent);
    view.closest_hit(ray).is_none()
        && !view.occluded(ray)
        && view.query().brute_force().closest_hit(ray).is_none()
        && hits.iter().all(Option::is_none)
}

fn placements(random: &mut Random, distance: f32) -> Affine {
    match random.below(4) {
        0 => Affine::IDENTITY,
        1 => Affine::from_translation(random.point(distance)),
        2 => {
            Affine::from_translation(random.point(distance))
                * Affine::from_axis_angle(random.direction(), random.within(0.0, 6.0))
        }
        _ => Affine::from_translation(random.point(distance)) * random.placement(1.0),
    }
}

#[test]
fn a_ray_that_leaves_does_not_meet_the_triangle_it_left() {
    let seed = 1105;
    let mut random = Random::new(seed);
    let (mut asked, mut from_the_ray) = (0, 0);
    for round in 0..3000 {
        let size = 10.0_f32.powf(random.within(-4.0, 6.0));
        let distance = if round % 2 == 0 { size } else { 10.0_f32.powf(random.within(-3.0, 6.0)) };
        // In single precision, distances to long thin triangles are not promised to be right.
        let precision = if round % 5 == 0 { Precision::Fast } else { Precision::Watertight };
        let thinnest = if precision == Precision::Fast { 1.0 } else { 1e-3 };
        let corners = triangle(&mut random, size, distance, thinnest);
        let placement = placements(&mut random, distance);
        let view = scene(&corners, &[[0, 1, 2]], placement, precision);
        let world = corners.map(|corner| in_world(&placement, corner));
        let normal = unit(cross(minus(world[1], world[0]), minus(world[2], world[0])));
        for _ in 0..8 {
            let from = f64::from(size) * f64::from(10.0_f32.powf(random.within(-2.0, 1.0)));
            let ray = towards(&mut random, world, from);
            let Some(hit) = view.closest_hit(&ray) else { continue };
            for kind in 0..4 {
                let mut direction = random.direction();
                if kind == 3 {
                    // Nearly along the surface.
                    let off = f64::from(10.0_f32.powf(random.within(-9.0, -2.0)));
                    let across = dot(normal, wide(direction));
                    direction = [0, 1, 2].map(|i| (f64::from(direction[i]) - (across - off) * normal[i]) as f32);
                }
                let leaving = view.leave(&hit, direction);
                assert!(
                    misses(&view, &leaving),
                    "seed {seed}, round {round}: {corners:?} {placement:?} {leaving:?}: {:?} {:?}",
                    view.closest_hit(&leaving),
                    view.instance(&hit).object_from_world()
                );
                asked += 1;
                from_the_ray += usize::from(!misses(&view, &Ray::new(ray.at(hit.t), direction)));
            }
        }
    }
    // As a check of the test: the plain way fails often.
    assert!(asked > 50_000 && from_the_ray > asked / 5, "{asked} {from_the_ray}");
}

#[test]
fn an_origin_is_next_to_its_place_and_on_the_side_of_its_direction() {
    let seed = 1106;
    let mut random = Random::new(seed);
    let mut asked = 0;
    for round in 0..3000 {
        let size = 10.0_f32.powf(random.within(-4.0, 6.0));
        let distance = 10.0_f32.powf(random.within(-3.0, 6.0));
        let corners = triangle(&mut random, size, distance, 1e-3);
        let placement = placements(&mut random, distance);
        let view = scene(&corners, &[[0, 1, 2]], placement, Precision::Watertight);
        let world = corners.map(|corner| in_world(&placement, corner));
        let normal = unit(cross(minus(world[1], world[0]), minus(world[2], world[0])));
        let ray = towards(&mut random, world, f64::from(size));
        let Some(hit) = view.closest_hit(&ray) else { continue };
        let (position, direction) = (wide(view.position(&hit)), random.direction());
        let leaving = view.leave(&hit, direction);
        // Roundings of the largest numbers that the way into the object's space is summed from.
        let [x, y, z, moved] =
            [placement.x_axis, placement.y_axis, placement.z_axis, placement.translation].map(|v| largest(wide(v)));
        let back = view.instance(&hit).object_from_world();
        let stretch =
            x.max(y).max(z) * [back.x_axis, back.y_axis, back.z_axis].map(|v| largest(wide(v))).iter().sum::<f64>();
        let numbers = (largest(position) + moved) * stretch.max(1.0) * 4.0;
        let bound = numbers * f64::from(f32::EPSILON) + 1e-11 * f64::from(size) * stretch;
        let off = minus(wide(leaving.origin), position);
        assert!(largest(off) <= bound, "seed {seed}, round {round}: {off:?} is beyond {bound}");
        if placement == Affine::IDENTITY {
            let height = dot(normal, minus(wide(leaving.origin), world[0]));
            let side = dot(normal, wide(direction)).signum();
            assert!(height * side > -1e-12 * f64::from(size), "seed {seed}, round {round}: {height} towards {side}");
        }
        asked += 1;
    }
    assert!(asked > 2000, "{asked}");
}

#[test]
fn positions_lie_in_the_plane_and_along_the_ray() {
    let seed = 1107;
    let mut random = Random::new(seed);
    for size in [1.0_f32, 1e3, 1e5, 1e6, 1e7] {
        // A floor of two triangles, level or sloping, and one that a placement has brought there.
        for case in 0..300 {
            let slope = if case % 3 == 0 { 0.0 } else { random.within(-0.5, 0.5) };
            let corner = |x: f32, z: f32| [x * size, slope * x * size, z * size];
            let floor = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
            let placement =
                if case % 2 == 0 { Affine::IDENTITY } else { Affine::from_axis_angle(random.direction(), 1.0) };
            let view = scene(&floor, &[[0, 1, 2], [0, 2, 3]], placement, Precision::Watertight);
            let world = floor.map(|corner| in_world(&placement, corner));
            let normal = unit(cross(minus(world[1], world[0]), minus(world[2], world[0])));
            let (side, down) = (random.direction(), normal.map(|x| -x as f32));
            let near = (0.1 * size).min(3.0);
            let origin = [0, 1, 2].map(|i| near * (2.0 * normal[i] as f32 + side[i]));
            let ray = Ray::new(origin, [0, 1, 2].map(|i| down[i] + 0.3 * side[i]));
            let hit = view.closest_hit(&ray).expect("the floor is below");
            // The plane goes through the origin, but for the rounding of the corners.
            let corners_off = world.map(|corner| dot(normal, corner).abs()).into_iter().fold(0.0, f64::max);
            let t = dot(normal, minus(world[0], wide(origin))) / dot(normal, wide(ray.direction));
            let truth = [0, 1, 2].map(|i| f64::from(origin[i]) + t * f64::from(ray.direction[i]));
            let rounding = 2.0 * f64::from(f32::EPSILON) * largest(truth) + 1e-13 * f64::from(size);
            let along = minus(wide(view.position_along(&hit, &ray)), truth);
            let own = minus(wide(view.position(&hit)), truth);
            let what = format!("seed {seed}, {size} m, case {case}");
            // Triangles of the two halves of the floor differ by the rounding of their corners.
            assert!(largest(along) <= rounding + 4.0 * corners_off, "{what}: {along:?}");
            let weights = 2.0 * f64::from(size) * f64::from(f32::EPSILON);
            assert!(largest(own) <= rounding + 2.0 * weights, "{what}: {own:?}");
            let spacing = f64::from(f32::EPSILON) * largest(wide(view.position(&hit))) + 1e-13 * f64::from(size);
            assert!(dot(normal, own).abs() <= spacing + 4.0 * corners_off, "{what}: {own:?} off the plane");
        }
    }
}

#[test]
fn what_lies_close_above_a_large_floor_shades_it() {
    // A plate of a metre, 4 mm, 1 cm and 10 cm above floors of 10, 100 and 1000 km to each side.
    for (size, height) in [(1e4_f32, 4e-3_f32), (1e5, 1e-2), (1e6, 0.1), (1e6, 4e-3)] {
        for center in [[0.0, 0.0], [0.3 * size, -0.7 * size]] {
            let [x, z] = center;
            let square = |half: f32, x: f32, y: f32, z: f32| {
                [[x - half, y, z - half], [x - half, y, z + half], [x + half, y, z + half], [x + half, y, z - half]]
            };
            let mut positions = square(size, 0.0, 0.0, 0.0).to_vec();
            positions.extend(square(4.0, x, height, z));
            let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
            for turned in [false, true] {
                let placement = if turned {
                    Affine::from_axis_angle([0.0, 1.0, 0.0], 0.7) * Affine::from_scale([2.0; 3])
                } else {
                    Affine::IDENTITY
                };
                let view = scene(&positions, &triangles, placement, Precision::Watertight);
                let mut random = Random::new(1108);
                for _ in 0..500 {
                    // From just below the plate, so that the floor is hit.
                    let eye = [x + random.within(-3.0, 3.0), 0.5 * height, z + random.within(-3.0, 3.0)];
                    let eye = placement.transform_point(eye);
                    let Some(hit) = view.closest_hit(&Ray::new(eye, [0.1, -1.0, 0.05])) else { continue };
                    assert!(hit.primitive < 2, "{size} {height} {center:?}: the plate is above");
                    let up = view.leave(&hit, [0.0, 1.0, 0.0]);
                    let above = view.closest_hit(&up);
                    assert!(above.is_some_and(|hit| hit.primitive >= 2), "{size} {height} {center:?} {turned}: {up:?}");
                }
            }
        }
    }
}

/// A cube from -1 to 1 of single sheets.
fn cube() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let corner = |i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -1.0 } else { 1.0 });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}

/// How far a point lies within each triangle of a room that faces outwards, metres.
fn heights(view: &Snapshot, point: Point) -> Vec<f64> {
    let room = view.instance_at(0);
    let inside = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| in_world(room.world_from_object(), room.positions()[corner as usize]));
        dot(unit(cross(minus(c, a), minus(b, a))), minus(point, a))
    };
    room.triangles().iter().map(inside).collect()
}

/// Follows paths in a closed room until one gets out; how many bounces there were.
fn wander(view: &Snapshot, middle: [f32; 3], seed: u64, what: &str) {
    let mut random = Random::new(seed);
    for path in 0..4000 {
        let mut ray = Ray::new(middle, random.direction());
        let mut trail = Vec::new();
        for bounce in 0..12 {
            let Some(hit) = view.closest_hit(&ray) else {
                let heights = heights(view, wide(ray.origin));
                let local = view.instance_at(0).ray_in_object(&ray);
                panic!(
                    "seed {seed}, {what}: path {path} is out after {bounce} bounces by {ray:?}, {local:?} in its own \
                     space; heights over the walls are {heights:?}; before were {trail:#?}"
                )
            };
            trail.push((ray, view.instance_at(0).ray_in_object(&ray), hit));
            ray = next(view, &hit, &ray, &mut random);
        }
    }
}

/// Off the wall, to the side that the ray came from.
fn next(view: &Snapshot, hit: &Hit, ray: &Ray, random: &mut Random) -> Ray {
    let normal = wide(view.normal(hit));
    let inward = -dot(normal, wide(ray.direction)).signum();
    let mut direction = random.direction();
    // Every other one along the wall, into the corners.
    let across = dot(normal, wide(direction));
    let wanted = inward * if random.unit() < 0.5 { across.abs() } else { 1e-3 };
    direction = [0, 1, 2].map(|i| (f64::from(direction[i]) + (wanted - across) * normal[i]) as f32);
    view.leave(hit, direction)
}

#[test]
fn nothing_leaves_a_closed_room_however_far_it_is() {
    let (corners, triangles) = cube();
    for distance in [0.0_f32, 1e3, 1e4, 1e5] {
        for away in [[1.0, 0.0, 0.0], [0.6, -0.3, 0.9]] {
            let middle = away.map(|x| x * distance);
            for turn in [0.0, 0.4] {
                let turned = Affine::from_axis_angle([0.3, 1.0, -0.5], turn) * Affine::from_scale([2.0; 3]);
                let placement = Affine::from_translation(middle) * turned;
                // As its own corners have it, and as an instance has it.
                let moved: Vec<_> = corners.iter().map(|&corner| placement.transform_point(corner)).collect();
                let view = scene(&moved, &triangles, Affine::IDENTITY, Precision::Watertight);
                wander(&view, middle, 1109, &format!("corners {distance} m away, turned by {turn}"));
                let view = scene(&corners, &triangles, placement, Precision::Watertight);
                wander(&view, middle, 1110, &format!("placed {distance} m away, turned by {turn}"));
                // Scaled unevenly on top.
                let squeezed = placement * Affine::from_scale([1.0, 0.6, 1.5]);
                let view = scene(&corners, &triangles, squeezed, Precision::Watertight);
                wander(&view, middle, 1111, &format!("squeezed {distance} m away, turned by {turn}"));
            }
        }
    }
}

#[test]
fn awkward_directions_give_rays_that_hit_nothing_and_do_not_panic() {
    let (corners, triangles) = cube();
    for scale in [1e-20_f32, 1.0, 1e15] {
        let view = scene(&corners, &triangles, Affine::from_scale([scale; 3]), Precision::Watertight);
        let hit = view.closest_hit(&Ray::new([0.0; 3], [0.3, 0.2, 1.0])).expect("the room is closed");
        for value in [0.0, f32::NAN, f32::INFINITY] {
            assert_eq!(view.closest_hit(&view.leave(&hit, [value; 3])), None);
        }
        assert!(view.closest_hit(&view.leave(&hit, [0.0, 0.0, -1.0])).is_some(), "{scale}");
        assert!(view.closest_hit(&view.leave(&hit, [0.0, 0.0, 1e-30])).is_none(), "{scale}");
        assert!(view.closest_hit(&view.leave(&hit, [1e-30, 0.0, 1e30])).is_none(), "{scale}");
    }
}

#[test]
fn rays_leave_flat_and_skewed_placements() {
    let (corners, triangles) = cube();
    let flat = Affine::from_scale([2.0, 0.0, 3.0]);
    let skewed = Affine { y_axis: [30.0, 1.0, 0.0], ..Affine::IDENTITY };
    for (name, placement) in [("flat", flat), ("skewed", skewed)] {
        let turned =
            Affine::from_translation([7.0, -3.0, 5.0]) * Affine::from_axis_angle([1.0, 2.0, 3.0], 0.8) * placement;
        for placement in [placement, turned] {
            let view = scene(&corners, &triangles, placement, Precision::Watertight);
            let center = placement.transform_point([0.1, 0.0, 0.2]);
            let seed = 1112;
            let mut random = Random::new(seed);
            for _ in 0..2000 {
                let away = random.direction();
                let eye = [0, 1, 2].map(|i| center[i] + 50.0 * away[i]);
                let Some(hit) = view.closest_hit(&Ray::new(eye, away.map(|x| -x))) else { continue };
                let back = view.leave(&hit, away);
                let met = view.closest_hit(&back);
                assert!(met.is_none(), "seed {seed}, {name}: {back:?} {met:?}");
            }
        }
    }
}
