//! Every question, on every awkward and random world, against brute force.

mod common;

use common::{QUALITIES, Random, rays, rebuilt, worlds};
use kinetree::{Affine, Candidate, Cull, Hit, Mesh, Query, Ray, Work};

const RAYS: usize = 3000;

/// Tells whether there is a hit.
fn compare(name: &str, query: Query<'_>, ray: &Ray) -> bool {
    let twin = query.brute_force();
    let expected = twin.closest_hit(ray);
    assert_eq!(query.closest_hit(ray), expected, "closest in `{name}` for {ray:?}");
    assert_eq!(query.occluded(ray), expected.is_some(), "occluded in `{name}` for {ray:?}");
    assert_eq!(twin.occluded(ray), expected.is_some());
    let all = twin.all_hits(ray);
    assert_eq!(all.first(), expected.as_ref(), "the nearest of all in `{name}` for {ray:?}");
    assert_eq!(query.all_hits(ray), all, "all hits in `{name}` for {ray:?}");
    expected.is_some()
}

#[test]
fn every_question_agrees_with_looking_everywhere() {
    for seed in 0..3 {
        let mut random = Random::new(seed);
        for world in worlds(seed) {
            let name = format!("{}, seed {seed}", world.name);
            let hit = |ray: &Ray| compare(&name, world.view.query(), ray);
            let hits = rays(&world, RAYS, &mut random).iter().filter(|ray| hit(ray)).count();
            let expected = if world.view.instances().all(|view| view.triangles().is_empty()) { 0 } else { RAYS / 20 };
            assert!(hits >= expected, "only {hits} rays hit anything in `{name}`");
        }
    }
}

#[test]
fn masks_culling_and_filters_agree_with_looking_everywhere() {
    let holes = |candidate: &Candidate<'_>| (candidate.primitive() + candidate.instance_index()) % 3 != 0;
    let mut random = Random::new(7);
    for world in worlds(7) {
        // Instances with masks of their own, some of them opaque.
        let world = rebuilt(&world, QUALITIES[2]);
        for (i, ray) in rays(&world, RAYS / 3, &mut random).iter().enumerate() {
            let cull = [Cull::None, Cull::Back, Cull::Front][i % 3];
            let mask = [0b111, 0b010, 0b101, 0][i / 3 % 4];
            let query = world.view.query().cull(cull).mask(mask);
            compare(&world.name, query, ray);
            compare(&world.name, query.filter(&holes), ray);
            // The rules once more, by themselves: the slow twin could share a fault.
            let counts = |hit: &Hit| {
                let instance = world.view.instance(hit);
                let culled = match cull {
                    Cull::None => false,
                    Cull::Back => hit.is_back_face(),
                    Cull::Front => !hit.is_back_face(),
                };
                let hole = (hit.primitive + hit.instance_index()) % 3 == 0;
                !culled && instance.mask() & mask != 0 && (instance.is_opaque() || !hole)
            };
            let expected: Vec<Hit> = world.view.query().all_hits(ray).into_iter().filter(counts).collect();
            assert_eq!(query.filter(&holes).all_hits(ray), expected, "`{}`, {cull:?}, {mask:#b}, {ray:?}", world.name);
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
        assert!(work.blocks <= work.triangles && work.triangles <= 4 * work.blocks, "{work}");
        if world.view.instances().any(|view| view.triangles().len() > 10) {
            let all: usize = world.view.instances().map(|view| view.triangles().len()).sum();
            assert!(work.triangles < (all * rays.len()) as u64, "a tree tests fewer triangles than all");
        }
    }
}

#[test]
fn work_is_counted_one_by_one() {
    let corner = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
    let mesh = |xs: &[f32]| {
        let positions = xs.iter().flat_map(|&x| corner(x)).collect::<Vec<_>>();
        Mesh::new(&positions, &(0..positions.len() as u32).collect::<Vec<_>>()).unwrap()
    };
    let ahead = |x: f32| Ray::new([x + 0.2, 0.2, 5.0], [0.0, 0.0, -1.0]);
    let work = |counts: [u64; 5]| {
        let mut work = Work::default();
        [work.nodes, work.leaves, work.blocks, work.triangles, work.instances] = counts;
        work
    };
    let apart = [0.0, 100.0].map(|x| Affine::from_translation([x, 0.0, 0.0]));
    let one = common::alone(mesh(&[0.0]));
    let three = common::alone(mesh(&[0.0, 0.1, 0.2]));
    let two_instances = common::placed(mesh(&[0.0]), &apart);
    assert_eq!(three.instance_at(0).bvh().blocks().len(), 1);
    // A lone instance is entered without a look at the tree above it.
    for (what, view, x, mask, expected) in [
        ("one triangle", &one, 0.0, 1, [1, 1, 1, 1, 1]),
        ("beside one triangle", &one, 50.0, 1, [1, 0, 0, 0, 1]),
        ("a block of three", &three, 0.0, 1, [1, 1, 1, 3, 1]),
        ("one instance of two", &two_instances, 100.0, 1, [2, 2, 1, 1, 1]),
        ("between both instances", &two_instances, 50.0, 1, [1, 0, 0, 0, 0]),
        ("an instance that the mask hides", &two_instances, 0.0, 0, [1, 1, 0, 0, 0]),
    ] {
        let (query, ray, mut counted) = (view.query().mask(mask), ahead(x), Work::default());
        let is_hit = expected[2] > 0;
        assert_eq!(query.closest_hit_counted(&ray, &mut counted).is_some(), is_hit, "{what}");
        assert_eq!(counted, work(expected), "{what}");
        assert_eq!(query.occluded_counted(&ray, &mut counted), is_hit, "{what}");
        assert_eq!(counted, work(expected.map(|count| 2 * count)), "{what}");
        assert_eq!(!query.all_hits_counted(&ray, &mut counted).is_empty(), is_hit, "{what}");
        assert_eq!(counted, work(expected.map(|count| 3 * count)), "{what}");
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
