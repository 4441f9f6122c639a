//! Meshes whose triangles are tested in single precision throughout: right wherever rays do not meet edges within rounding.

mod common;

use common::{Random, placed, sphere};
use kinetree::simd::Level;
use kinetree::{Coherence, Hit, Mesh, Motion, Precision, Ray, Scene, Snapshot};

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
        let truth: Vec<_> = rays.iter().map(|ray| view.query().by_looking().closest_hit(ray)).collect();
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
    let mut scene = Scene::new();
    for (precision, x) in [(Precision::Watertight, 0.0), (Precision::Fast, 5.0)] {
        let mesh = scene.add_mesh(sphere(8, 16).with_precision(precision), Motion::Static).unwrap();
        scene.add_instance(scene.root(), mesh, kinetree::Affine::from_translation([x, 0.0, 0.0])).unwrap();
    }
    let view = scene.commit();
    for x in [0.0, 5.0] {
        let hit = view.closest_hit(&Ray::new([x + 0.1, 0.2, 9.0], [0.0, 0.0, -1.0])).expect("a sphere stands there");
        assert!((hit.t - 8.0).abs() < 0.2, "{hit:?}");
    }
    assert_eq!(Mesh::empty().with_precision(Precision::Fast).triangles().len(), 0);
}
