//! Meshes whose triangles are tested in single precision throughout: right wherever rays do not
//! meet edges within rounding.

mod common;

use common::{Random, World, alone, placed, rays, sphere};
use kinetree::simd::Level;
use kinetree::{Affine, Coherence, Hit, Motion, Precision, Ray, Scene, Snapshot};

/// Weights of corners below this are at an edge.
const EDGE: f32 = 1e-3;

fn is_at_edge(hit: &Hit) -> bool {
    hit.u.min(hit.v).min(1.0 - hit.u - hit.v) < EDGE
}

fn views(random: &mut Random, precision: Precision) -> Vec<Snapshot> {
    let placements: Vec<_> = (0..30).map(|_| random.placement(4.0)).collect();
    let meshes = [sphere(40, 80), random.soup(500, 3.0, 0.6)];
    meshes.into_iter().map(|mesh| placed(mesh.with_precision(precision), &placements)).collect()
}

fn random_rays(random: &mut Random, count: usize) -> Vec<Ray> {
    (0..count).map(|_| Ray::new(random.point(6.0), random.direction())).collect()
}

/// Equal to the bit, or else at an edge.
fn compare(what: &str, ray: &Ray, expected: Option<Hit>, found: Option<Hit>) {
    if expected == found {
        return;
    }
    let nearer = match (expected, found) {
        (Some(one), Some(other)) => Some(if one.t <= other.t { one } else { other }),
        (one, other) => one.or(other),
    };
    assert!(nearer.is_some_and(|hit| is_at_edge(&hit)), "{what}, {ray:?}: {expected:?} expected, {found:?} found");
}

#[test]
fn every_level_and_batch_finds_what_looking_everywhere_finds() {
    let seed = 31;
    let mut random = Random::new(seed);
    for (number, view) in views(&mut random, Precision::Fast).into_iter().enumerate() {
        let rays = random_rays(&mut random, 1500);
        let truth: Vec<_> = rays.iter().map(|ray| view.query().brute_force().closest_hit(ray)).collect();
        assert!(truth.iter().flatten().count() > 300, "seed {seed}");
        for level in Level::available() {
            let view = view.at_level(level);
            let what = format!("world {number}, {level:?}, seed {seed}");
            for (ray, expected) in rays.iter().zip(&truth) {
                compare(&what, ray, *expected, view.closest_hit(ray));
                if view.occluded(ray) != expected.is_some() {
                    compare(&what, ray, *expected, None);
                }
            }
            for claim in [Coherence::Coherent, Coherence::Incoherent] {
                let mut hits = vec![None; rays.len()];
                view.closest_hits(&rays, &mut hits, claim);
                rays.iter()
                    .zip(&truth)
                    .zip(hits)
                    .for_each(|((ray, expected), hit)| compare(&what, ray, *expected, hit));
            }
        }
    }
}

#[test]
fn it_finds_what_the_watertight_test_finds() {
    let seed = 32;
    let fast = views(&mut Random::new(seed), Precision::Fast);
    let watertight = views(&mut Random::new(seed), Precision::Watertight);
    let mut random = Random::new(seed + 1);
    for (fast, watertight) in fast.iter().zip(&watertight) {
        for ray in random_rays(&mut random, 5000) {
            let (one, other) = (watertight.closest_hit(&ray), fast.closest_hit(&ray));
            let same = match (one, other) {
                (Some(one), Some(other)) => {
                    one.primitive == other.primitive
                        && (one.t - other.t).abs() <= 1e-4 * one.t + 1e-6
                        && one.is_back_face() == other.is_back_face()
                }
                (one, other) => one == other,
            };
            if !same {
                compare(&format!("seed {seed}"), &ray, one, other);
            }
        }
    }
}

#[test]
fn the_precision_of_a_mesh_can_differ_from_that_of_others() {
    let seed = 34;
    let mut random = Random::new(seed);
    // Long triangles, and rays at their edges: both tests answer, but often with other digits.
    let mesh = random.soup(60, 0.5, 8.0);
    let mut scene = Scene::new();
    let both = [Precision::Watertight, Precision::Fast];
    for (precision, mask) in both.into_iter().zip([0b01, 0b10]) {
        let id = scene.add_mesh(mesh.clone().with_precision(precision), Motion::Static).unwrap();
        let instance = scene.add_instance(scene.root(), id, Affine::IDENTITY).unwrap();
        scene.set_mask(instance, mask).unwrap();
    }
    let together = scene.commit();
    let [watertight, fast] = both.map(|precision| alone(mesh.clone().with_precision(precision)));
    let world = World { name: "long".into(), view: watertight.clone(), size: 5.0 };
    let rays = rays(&world, 3000, &mut random);
    let seen = |hit: Option<Hit>| hit.map(|hit| (hit.primitive, [hit.t, hit.u, hit.v].map(f32::to_bits)));
    let differ = rays.iter().filter(|ray| seen(watertight.closest_hit(ray)) != seen(fast.closest_hit(ray))).count();
    assert!(differ > 100, "seed {seed}: only {differ} rays tell the tests apart");
    for level in Level::available() {
        let together = together.at_level(level);
        for (view, mask) in [(&watertight, 0b01), (&fast, 0b10)] {
            let view = view.at_level(level);
            let (query, what) = (together.query().mask(mask), format!("{level:?}, mask {mask:#b}, seed {seed}"));
            let mut packets = [vec![None; rays.len()], vec![None; rays.len()]];
            query.closest_hits(&rays, &mut packets[0], Coherence::Coherent);
            view.closest_hits(&rays, &mut packets[1], Coherence::Coherent);
            for (at, ray) in rays.iter().enumerate() {
                assert_eq!(seen(query.closest_hit(ray)), seen(view.closest_hit(ray)), "{what}, {ray:?}");
                assert_eq!(seen(packets[0][at]), seen(packets[1][at]), "packets, {what}, {ray:?}");
                let looked = [query, view.query()].map(|query| seen(query.brute_force().closest_hit(ray)));
                assert_eq!(looked[0], looked[1], "brute force, {what}, {ray:?}");
            }
        }
    }
}
