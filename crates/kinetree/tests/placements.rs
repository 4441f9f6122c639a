//! Awkward placements: thin, skewed, seen from far, and flat. The judge is double precision that
//! shares no code with the library.
//!
//! The environment variable `KINETREE_RAYS` sets how many far rays are traced; a hundred million
//! were, by hand.

mod common;

use common::{Random, cube, grid, sphere};
use kinetree::{Affine, Coherence, Cull, Mesh, Motion, Ray, Scene, Snapshot, Work};

type V = [f64; 3];

fn wide(v: [f32; 3]) -> V {
    v.map(f64::from)
}

fn add(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn times(a: V, s: f64) -> V {
    a.map(|x| x * s)
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: V) -> f64 {
    dot(a, a).sqrt()
}

/// A point of the object in the world.
fn placed(map: &Affine, point: [f32; 3]) -> V {
    let [x, y, z] = wide(point);
    let columns = [map.x_axis, map.y_axis, map.z_axis, map.translation].map(wide);
    add(add(times(columns[0], x), times(columns[1], y)), add(times(columns[2], z), columns[3]))
}

/// The largest row sum of `|M||N|`, N being the inverse of M.
fn skew(map: &Affine) -> f64 {
    let [x, y, z] = [map.x_axis, map.y_axis, map.z_axis].map(wide);
    let rows = [cross(y, z), cross(z, x), cross(x, y)].map(|row| times(row, 1.0 / dot(x, cross(y, z))));
    let sums = rows.map(|row| row.iter().map(|x| x.abs()).sum::<f64>());
    (0..3).map(|i| x[i].abs() * sums[0] + y[i].abs() * sums[1] + z[i].abs() * sums[2]).fold(0.0, f64::max)
}

/// Where a ray crosses a triangle in the world, and how far inside of its edges; negative outside.
struct Crossing {
    t: f64,
    inside: f64,
    /// Between ray and normal; positive when they look the same way.
    cosine: f64,
}

fn crossing(ray: &Ray, corners: [V; 3]) -> Crossing {
    let (origin, direction) = (wide(ray.origin), wide(ray.direction));
    let [a, b, c] = corners;
    let normal = cross(sub(b, a), sub(c, a));
    let normal = times(normal, 1.0 / length(normal));
    let t = dot(normal, sub(a, origin)) / dot(normal, direction);
    let at = add(origin, times(direction, t));
    let inside = [(a, b), (b, c), (c, a)]
        .map(|(from, to)| dot(cross(sub(to, from), sub(at, from)), normal) / length(sub(to, from)));
    let inside = inside.into_iter().fold(f64::INFINITY, f64::min);
    Crossing { t, inside, cosine: dot(normal, direction) / length(direction) }
}

/// All triangles of a frame, in the world.
fn triangles(view: &Snapshot) -> Vec<(u32, u32, [V; 3])> {
    let mut all = Vec::new();
    for instance in view.instances() {
        for (primitive, triangle) in (0..).zip(instance.triangles()) {
            let corners = triangle.map(|v| placed(instance.world_from_object(), instance.positions()[v as usize]));
            all.push((instance.index(), primitive, corners));
        }
    }
    all
}

fn count(usual: usize) -> usize {
    std::env::var("KINETREE_RAYS").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// 4,096 decals of 2 m on a field of 256 m, some of them turned, all very thin.
fn decals(thickness: f32) -> Snapshot {
    let mut random = Random::new(11);
    let mut scene = Scene::new();
    let decal = scene.add_mesh(cube(), Motion::Rigid).unwrap();
    for i in 0..4096 {
        let at = [(i % 64) as f32 * 4.0 - 126.0, 0.0, (i / 64) as f32 * 4.0 - 126.0];
        let place = Affine::from_translation(at)
            * Affine::from_axis_angle([0.0, 1.0, 0.0], random.within(0.0, 6.0))
            * Affine::from_scale([1.0, thickness, 1.0]);
        scene.add_instance(scene.root(), decal, place).unwrap();
    }
    scene.commit()
}

#[test]
fn of_thin_decals_a_ray_enters_those_that_it_meets() {
    for thickness in [1e-3, 1e-6, 1e-7, 1e-12] {
        let view = decals(thickness);
        let bounds = view.bounds();
        assert!((0..3).all(|axis| bounds.max[axis] - bounds.min[axis] < 256.0), "{bounds:?} at {thickness}");
        assert!(bounds.max[1] - bounds.min[1] < 0.01, "{bounds:?} at {thickness}");
        let mut random = Random::new(12);
        for _ in 0..2000 {
            let (from, to) = (random.point(120.0), random.point(120.0));
            let from = [from[0], 100.0, from[2]];
            let direction = [to[0] - from[0], -100.0, to[2] - from[2]];
            let mut work = Work::default();
            view.query().all_hits_counted(&Ray::new(from, direction), &mut work);
            assert!(work.instances <= 3, "{} instances entered at {thickness}", work.instances);
        }
    }
}

/// Cubes under skewed placements around the origin.
fn skewed(seed: u64, least: f64, most: f64) -> Snapshot {
    let mut random = Random::new(seed);
    let mut scene = Scene::new();
    let meshes = [cube(), sphere(4, 6)].map(|mesh| scene.add_mesh(mesh, Motion::Rigid).unwrap());
    let mut number = 0;
    while number < 16 {
        let flattened = random.unit().powi(2) * if most > 100.0 { 1.0 } else { 3.0 };
        let place = Affine::from_translation(random.point(4.0))
            * Affine::from_axis_angle(random.direction(), random.within(0.0, 6.0))
            * Affine::from_scale([random.within(0.5, 2.0), flattened.max(1e-5), random.within(0.5, 2.0)])
            * Affine::from_axis_angle(random.direction(), random.within(0.0, 6.0))
            * Affine::from_scale([1.0, random.within(0.1, 1.0), 1.0]);
        if (least..most).contains(&skew(&place)) {
            scene.add_instance(scene.root(), meshes[number % 2], place).unwrap();
            number += 1;
        }
    }
    scene.commit()
}

/// A ray from up to ten thousand times as far as the scene is large, through a vertex, an edge or
/// the inside of a triangle.
fn far_ray(random: &mut Random, corners: [V; 3]) -> Ray {
    let distance = 10.0_f32.powf(random.within(0.5, 5.0));
    let origin = random.direction().map(|x| x * distance);
    let (u, v) = match random.below(4) {
        0 => (0.0, 0.0),
        1 => (random.unit(), 0.0),
        _ => (random.unit() * 0.5, random.unit() * 0.5),
    };
    let [a, b, c] = corners;
    let (u, v) = (f64::from(u), f64::from(v));
    let target = add(a, add(times(sub(b, a), u), times(sub(c, a), v)));
    let towards = sub(target, wide(origin)).map(|x| x as f32);
    Ray::new(origin, towards)
}

/// Traces some rays at one frame, every way, and says how many double precision could judge.
fn trace_far(view: &Snapshot, seed: u64, batch: u64, rays: usize) -> usize {
    let all = triangles(view);
    let skews: Vec<f64> = view.instances().map(|instance| skew(instance.world_from_object())).collect();
    let mut random = Random::new(seed << 32 | batch);
    let (mut judged, mut traced) = (0, Vec::new());
    for number in 0..rays {
        let (instance, primitive, corners) = all[random.below(all.len())];
        let ray = far_ray(&mut random, corners);
        let said = || format!("{ray:?}, instance {instance}, triangle {primitive}, ray {number} of {seed}, {batch}");
        // Those that the triangle test meets are found by the trees.
        let hit = view.closest_hit(&ray);
        assert_eq!(hit, view.query().brute_force().closest_hit(&ray), "{}", said());
        traced.push((ray, hit));
        // And the triangle test errs by no more than it may.
        let right = crossing(&ray, corners);
        let far = length(wide(ray.origin));
        let skew = skews[instance as usize];
        let unit = f64::from(f32::EPSILON) / 2.0;
        let error = if skew > 16.0 { 64.0 * unit * 10.0 } else { 20.0 * unit * (skew * (far + 10.0) + 10.0) };
        let grazing = right.cosine.abs();
        if right.inside > 4.0 * error / grazing {
            judged += 1;
            let near = (error / grazing / length(wide(ray.direction)) + 4.0 * unit) * 4.0;
            let hits = view.query().all_hits(&ray);
            let found = hits.iter().find(|hit| hit.instance_index() == instance && hit.primitive == primitive);
            let found = found.unwrap_or_else(|| panic!("lost: {}", said()));
            assert!((f64::from(found.t) - right.t).abs() <= near, "{} is not {}: {}", found.t, right.t, said());
            assert!(hit.is_some_and(|hit| hit.t <= found.t) && view.occluded(&ray), "{}", said());
        }
    }
    let rays: Vec<Ray> = traced.iter().map(|(ray, _)| *ray).collect();
    let mut hits = vec![None; rays.len()];
    view.closest_hits(&rays, &mut hits, Coherence::Coherent);
    assert!(hits.iter().zip(&traced).all(|(hit, (_, alone))| hit == alone), "packets differ, {seed}, {batch}");
    judged
}

#[test]
fn no_ray_from_far_loses_a_skewed_instance() {
    const BATCH: usize = 10_000;
    let bounds = [(1.0, 3.2), (3.2, 16.0), (12.0, 16.0), (16.0, 1e3), (1e3, 2e5), (1.0, 1e5)];
    let batches = (count(120_000) / BATCH).div_ceil(bounds.len());
    std::thread::scope(|scope| {
        for (seed, (least, most)) in (1..).zip(bounds) {
            scope.spawn(move || {
                let judged: usize = (0..batches)
                    .map(|batch| {
                        trace_far(&skewed(seed * 1000 + batch as u64 % 97, least, most), seed, batch as u64, BATCH)
                    })
                    .sum();
                assert!(judged > batches * BATCH / 50, "only {judged} judged of skews from {least} to {most}");
            });
        }
    });
}

/// Placements that are flat along one axis, exactly or to within what their numbers can say.
fn flat_placements() -> Vec<Affine> {
    let turned = Affine::from_axis_angle([1.0, 2.0, -3.0], 1.1);
    let tilted = Affine::from_axis_angle([-2.0, 0.3, 1.0], 2.3);
    let moved = Affine::from_translation([30.0, -20.0, 10.0]);
    let sheared = Affine { y_axis: [1.0, 1e-9, 0.0], ..Affine::IDENTITY };
    vec![
        Affine::from_scale([1.0, 0.0, 1.0]),
        Affine::from_scale([5.0, 5.0, 0.0]),
        moved * Affine::from_scale([0.0, -2.0, 3.0]),
        moved * turned * Affine::from_scale([2.0, 0.0, 0.5]),
        Affine::from_scale([2.0, 0.0, 0.5]) * turned,
        moved * tilted * Affine::from_scale([2.0, 0.0, 0.5]) * turned,
        moved * tilted * Affine::from_scale([20.0, 1e-39, 30.0]),
        sheared,
        moved * tilted * Affine { x_axis: [0.0, 1.0, -1e-9], z_axis: [3.0, 0.0, 0.0], ..Affine::IDENTITY } * turned,
    ]
}

/// One mesh, placed once.
fn shown(mesh: Mesh, placement: Affine) -> Snapshot {
    common::placed(mesh, &[placement, Affine::from_translation([1e4, 0.0, 0.0])])
}

#[test]
fn flat_placements_are_shown_from_both_sides() {
    for (number, placement) in flat_placements().into_iter().enumerate() {
        for mesh in [sphere(9, 14), cube(), Random::new(5).soup(40, 0.5, 0.7)] {
            let view = shown(mesh, placement);
            assert_eq!(view.report().left_out, [], "placement {number}");
            let all: Vec<_> = triangles(&view).into_iter().filter(|(instance, ..)| *instance == 0).collect();
            let size = all.iter().flat_map(|(.., corners)| corners).fold(0.0, |most: f64, at| most.max(length(*at)));
            let mut random = Random::new(number as u64);
            let (mut rays, mut fronts, mut backs) = (Vec::new(), 0, 0);
            for ray_number in 0..1500 {
                let (_, primitive, corners) = all[random.below(all.len())];
                if length(cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]))) < 1e-3 {
                    continue;
                }
                let origin = random.point(60.0);
                let (u, v) = (random.unit() * 0.5, random.unit() * 0.5);
                let (u, v) = if ray_number % 4 == 0 { (u, 0.0) } else { (u, v) };
                let across =
                    add(times(sub(corners[1], corners[0]), u.into()), times(sub(corners[2], corners[0]), v.into()));
                let ray = Ray::new(origin, sub(add(corners[0], across), wide(origin)).map(|x| x as f32));
                let right = crossing(&ray, corners);
                let said = format!("{ray:?}, triangle {primitive}, placement {number}");
                if right.cosine.abs() < 0.02 {
                    continue;
                }
                let hit = view.closest_hit(&ray);
                rays.push((ray, hit));
                let looking = view.query().brute_force();
                assert_eq!(hit, looking.closest_hit(&ray), "{said}");
                assert_eq!(view.query().all_hits(&ray), looking.all_hits(&ray), "{said}");
                if right.inside < 1e-5 * size {
                    continue;
                }
                let hits = view.query().all_hits(&ray);
                let found = hits.iter().find(|hit| hit.primitive == primitive && hit.instance_index() == 0);
                let found = found.unwrap_or_else(|| panic!("lost: {said}"));
                let near = 1e-5 / right.cosine.abs();
                assert!((f64::from(found.t) / right.t - 1.0).abs() < near, "{} is not {}: {said}", found.t, right.t);
                // All of it lies in one plane, so the smallest number is the nearest.
                assert_eq!(hit.map(|hit| (hit.t, hit.primitive)), Some((found.t, hits[0].primitive)), "{said}");
                assert!(hits.is_sorted_by(|a, b| (a.t, a.primitive) <= (b.t, b.primitive)), "{said}");
                assert!(view.occluded(&ray), "{said}");
                assert!(!view.occluded(&ray.with_range(0.0, found.t * 0.999)), "{said}");
                assert!(!view.occluded(&ray.with_range(found.t * 1.001, 1e3)), "{said}");
                assert!(view.occluded(&ray.with_range(found.t, found.t)), "{said}");
                // The side that is seen, the normal and the place.
                if found.is_back_face() {
                    backs += 1;
                } else {
                    fronts += 1;
                }
                let (normal, place) = (wide(view.normal(found)), wide(view.position(found)));
                assert!((length(normal) - 1.0).abs() < 1e-5, "{said}");
                assert_eq!(dot(normal, wide(ray.direction)) > 0.0, found.is_back_face(), "{said}");
                assert!(
                    (dot(normal, wide(ray.direction)) / length(wide(ray.direction))).abs() - right.cosine.abs() < 1e-4
                );
                let along = add(wide(ray.origin), times(wide(ray.direction), right.t));
                assert!(length(sub(place, along)) < 2e-5 * (size + 100.0) / right.cosine.abs(), "{said}");
                let (culled, kept) =
                    if found.is_back_face() { (Cull::Back, Cull::Front) } else { (Cull::Front, Cull::Back) };
                let is_found = |cull: Cull| view.query().cull(cull).all_hits(&ray).contains(found);
                assert!(!is_found(culled) && is_found(kept), "{said}");
                let other = |candidate: &kinetree::Candidate<'_>| candidate.primitive() != primitive;
                assert!(!view.query().filter(&other).all_hits(&ray).contains(found), "{said}");
                let filtered = view.query().filter(&other);
                assert_eq!(filtered.closest_hit(&ray), filtered.brute_force().closest_hit(&ray), "{said}");
            }
            assert!(fronts > 100 && backs > 100, "{fronts} fronts, {backs} backs, placement {number}");
            let lone: Vec<Ray> = rays.iter().map(|(ray, _)| *ray).collect();
            let (mut hits, mut dark) = (vec![None; lone.len()], vec![false; lone.len()]);
            view.closest_hits(&lone, &mut hits, Coherence::Coherent);
            view.occluded_each(&lone, &mut dark, Coherence::Coherent);
            assert!(hits.iter().zip(&rays).all(|(hit, (_, alone))| hit == alone), "placement {number}");
            assert!(dark.iter().zip(&hits).all(|(dark, hit)| *dark == hit.is_some()), "placement {number}");
        }
    }
}

#[test]
fn nothing_slips_through_a_flat_sphere() {
    for (number, placement) in flat_placements().into_iter().enumerate() {
        let view = shown(sphere(16, 24), placement);
        let view_of = view.instances().next().unwrap();
        let mut random = Random::new(40 + number as u64);
        for ray_number in 0..4000 {
            // Points well inside of the sphere, and vertices and edges that are not at its outline,
            // lie within the flat image.
            let point = match ray_number % 3 {
                0 => random.point(0.5),
                _ => {
                    let triangle = view_of.triangles()[random.below(view_of.triangles().len())];
                    let [a, b, _] = triangle.map(|vertex| view_of.positions()[vertex as usize]);
                    let (share, shrunk) = (random.unit() * (ray_number % 2) as f32, 0.5);
                    [0, 1, 2].map(|axis| (a[axis] + (b[axis] - a[axis]) * share) * shrunk)
                }
            };
            let (origin, target) = (random.point(90.0), placed(&placement, point));
            let ray = Ray::new(origin, sub(target, wide(origin)).map(|x| x as f32));
            let hits = view.query().all_hits(&ray);
            assert!(hits.len() >= 2, "{} hits of {ray:?}, placement {number}", hits.len());
            assert!(hits.iter().any(|hit| hit.is_back_face()) && hits.iter().any(|hit| !hit.is_back_face()));
        }
    }
}

#[test]
fn a_placement_becomes_flat_and_solid_again() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(grid(4, 2.0), Motion::Deforming).unwrap();
    let instance = scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
    let height =
        |view: &Snapshot, x: f32| view.closest_hit(&Ray::new([x, 10.0, 0.3], [0.0, -1.0, 0.0])).map(|hit| 10.0 - hit.t);
    assert_eq!(height(&scene.commit(), 0.3), Some(0.0));
    scene.place(instance, Affine::from_translation([0.0, 3.0, 0.0]) * Affine::from_scale([2.0, 0.0, 1.0])).unwrap();
    let flat = scene.commit();
    assert_eq!((height(&flat, 0.3), height(&flat, 3.9), height(&flat, 4.1)), (Some(3.0), Some(3.0), None));
    let down = Ray::new([0.3, 10.0, 0.3], [0.0, -1.0, 0.0]);
    assert!(flat.occluded(&down) && !flat.query().without(instance).occluded(&down));
    let bent: Vec<[f32; 3]> = grid(4, 2.0).positions().iter().map(|[x, y, z]| [x * 2.0, y + 1.0, *z]).collect();
    scene.set_positions(mesh, &bent).unwrap();
    let bent = scene.commit();
    assert_eq!((height(&bent, 7.9), height(&bent, 8.1)), (Some(3.0), None));
    scene.place(instance, Affine::from_scale([1.0, 0.0, 0.0])).unwrap();
    assert_eq!(scene.commit().report().left_out, [instance]);
    scene.place(instance, Affine::IDENTITY).unwrap();
    assert_eq!(height(&scene.commit(), 3.9), Some(1.0));
    assert_eq!(height(&flat, 3.9), Some(3.0));
}
