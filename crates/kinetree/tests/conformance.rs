//! Every question, on every awkward and random world, against looking at every triangle.

mod common;

use common::{Random, rays, worlds};
use kinetree::{Candidate, Cull, Hit, Query, Ray, Work};

const RAYS: usize = 3000;

fn agree(found: Option<Hit>, expected: Option<Hit>) -> bool {
    match (found, expected) {
        (None, None) => true,
        (Some(found), Some(expected)) => found.agrees_with(&expected),
        _ => false,
    }
}

fn compare(name: &str, query: Query<'_>, ray: &Ray) {
    let twin = query.by_looking();
    let (found, expected) = (query.closest_hit(ray), twin.closest_hit(ray));
    assert!(agree(found, expected), "closest in `{name}`: {found:?}, not {expected:?}, for {ray:?}");
    assert_eq!(query.occluded(ray), expected.is_some(), "occluded in `{name}` for {ray:?}");
    assert_eq!(twin.occluded(ray), expected.is_some());
    let (found, expected) = (query.all_hits(ray), twin.all_hits(ray));
    assert_eq!(found, expected, "all hits in `{name}` for {ray:?}");
}

#[test]
fn every_question_agrees_with_looking_everywhere() {
    for seed in 0..3 {
        let mut random = Random::new(seed);
        for world in worlds(seed) {
            let name = format!("{}, seed {seed}", world.name);
            for ray in rays(&world, RAYS, &mut random) {
                compare(&name, world.view.query(), &ray);
            }
        }
    }
}

#[test]
fn masks_culling_and_filters_agree_with_looking_everywhere() {
    let holes = |candidate: &Candidate<'_>| (candidate.primitive() + candidate.instance_index()) % 3 != 0;
    let mut random = Random::new(7);
    for world in worlds(7) {
        for (i, ray) in rays(&world, RAYS / 3, &mut random).iter().enumerate() {
            let cull = [Cull::None, Cull::Back, Cull::Front][i % 3];
            compare(&world.name, world.view.query().cull(cull), ray);
            compare(&world.name, world.view.query().cull(cull).filter(&holes), ray);
            assert_eq!(world.view.query().mask(0).closest_hit(ray), None);
        }
    }
}

#[test]
fn every_tree_keeps_its_promises() {
    for world in worlds(11) {
        assert_eq!(world.view.top_level().validate(), Ok(()), "{}", world.name);
        for view in world.view.instances() {
            assert_eq!(view.bvh().validate(), Ok(()), "{}", world.name);
            assert_eq!(view.bvh().primitive_count(), view.triangles().len(), "{}", world.name);
        }
    }
}

#[test]
fn batches_answer_like_single_calls_and_work_is_counted() {
    let mut random = Random::new(5);
    for world in worlds(5) {
        let rays = rays(&world, 500, &mut random);
        let mut hits = vec![None; rays.len()];
        let mut dark = vec![false; rays.len()];
        let mut work = Work::default();
        world.view.closest_hits(&rays, &mut hits, kinetree::Coherence::Unknown);
        world.view.occluded_each(&rays, &mut dark, kinetree::Coherence::Incoherent);
        for ((ray, hit), dark) in rays.iter().zip(hits).zip(dark) {
            assert_eq!(world.view.query().closest_hit_counted(ray, &mut work), hit);
            assert_eq!(dark, hit.is_some());
        }
        if world.view.instances().any(|view| view.triangles().len() > 10) {
            assert!(work.nodes > 0 && work.triangles > 0 && work.instances > 0);
            let all: usize = world.view.instances().map(|view| view.triangles().len()).sum();
            assert!(work.triangles < (all * rays.len()) as u64, "a tree tests fewer triangles than all");
        }
    }
}

#[test]
fn senseless_rays_hit_nothing() {
    let inside = [0.0; 3];
    let nan = f32::NAN;
    let senseless = [
        Ray::new([nan, 0.0, 0.0], [0.0, 1.0, 0.0]),
        Ray::new([f32::INFINITY, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        Ray::new(inside, [0.0, nan, 1.0]),
        Ray::new(inside, [0.0, f32::INFINITY, 0.0]),
        Ray::new(inside, [0.0; 3]),
        Ray::new(inside, [0.0, 1.0, 0.0]).with_range(nan, 9.0),
        Ray::new(inside, [0.0, 1.0, 0.0]).with_range(0.0, nan),
        Ray::new(inside, [0.0, 1.0, 0.0]).with_range(2.0, 1.0),
        Ray::new(inside, [0.0, 1.0, 0.0]).with_range(0.0, -1.0),
    ];
    for world in worlds(3) {
        for ray in &senseless {
            assert_eq!(world.view.closest_hit(ray), None, "{ray:?} in `{}`", world.name);
            assert!(!world.view.occluded(ray) && world.view.query().all_hits(ray).is_empty());
        }
    }
}

#[test]
fn a_negative_start_counts_as_zero() {
    let view = common::alone(common::cube());
    let ray = Ray::new([0.0, 0.0, 0.0], [0.0, 0.3, 1.0]).with_range(-5.0, 5.0);
    assert_eq!(view.query().all_hits(&ray).len(), 1);
    assert_eq!(view.closest_hit(&ray).map(|hit| hit.t), Some(1.0));
}

#[test]
fn directions_of_any_length_see_the_same_things() {
    for world in worlds(13).iter().filter(|world| world.size < 1e3) {
        let mut random = Random::new(13);
        for ray in rays(world, 300, &mut random) {
            let expected = world.view.closest_hit(&ray);
            for exponent in [-60, -30, 20, 60] {
                let factor = 2.0_f32.powi(exponent);
                let stretched = Ray::new(ray.origin, ray.direction.map(|x| x * factor))
                    .with_range(ray.t_min / factor, ray.t_max / factor);
                let hit = world.view.closest_hit(&stretched);
                let seen = |hit: Option<Hit>| hit.map(|hit| (hit.instance_index(), hit.primitive));
                assert_eq!(seen(hit), seen(expected), "2^{exponent} in `{}` for {ray:?}", world.name);
            }
        }
    }
}
