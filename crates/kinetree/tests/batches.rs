//! Batches answer like single calls, to the bit, whatever is claimed about their rays and whatever
//! the processor can do.

mod common;

use common::{QUALITIES, Random, rays, rebuilt, tile, worlds};
use kinetree::simd::Level;
use kinetree::{Affine, Candidate, Coherence, Cull, Motion, Ray, Scene, Snapshot, Work};

const CLAIMS: [Coherence; 3] = [Coherence::Coherent, Coherence::Incoherent, Coherence::Unknown];
const CULLS: [Cull; 3] = [Cull::None, Cull::Back, Cull::Front];

/// Asks both questions of every level with every claim; tells how many rays hit something.
fn compare(name: &str, view: &Snapshot, rays: &[Ray]) -> usize {
    let single: Vec<_> = rays.iter().map(|ray| view.closest_hit(ray)).collect();
    for level in Level::available() {
        let view = view.at_level(level);
        for claim in CLAIMS {
            // Answers that were there before must not shine through.
            let mut hits = single.clone();
            hits.rotate_right(usize::from(!rays.is_empty()));
            let mut dark: Vec<bool> = single.iter().map(|hit| hit.is_none()).collect();
            view.closest_hits(rays, &mut hits, claim);
            view.occluded_each(rays, &mut dark, claim);
            for (at, ray) in rays.iter().enumerate() {
                let what = format!("`{name}`, {level:?}, {claim:?}, ray {at}: {ray:?}");
                assert_eq!(hits[at], single[at], "{what}");
                assert_eq!(dark[at], single[at].is_some(), "{what}");
                let bits = |hit: kinetree::Hit| [hit.t, hit.u, hit.v].map(f32::to_bits);
                assert_eq!(hits[at].map(bits), single[at].map(bits), "{what}");
            }
        }
    }
    single.iter().flatten().count()
}

#[test]
fn batches_of_all_kinds_of_rays_answer_like_single_calls() {
    let mut hits = 0;
    for seed in 0..2 {
        let mut random = Random::new(seed);
        for world in worlds(seed) {
            let name = format!("{}, seed {seed}", world.name);
            hits += compare(&name, &world.view, &rays(&world, 700, &mut random));
        }
    }
    assert!(hits > 10_000, "only {hits} hits were compared");
}

#[test]
fn tiles_answer_like_single_calls() {
    let mut hits = 0;
    for seed in 20..22 {
        let mut random = Random::new(seed);
        for world in worlds(seed) {
            for count in [64, 64, 64, 64, 64, 64, 1, 2, 63, 65, 150] {
                let name = format!("{}, seed {seed}, {count} rays", world.name);
                hits += compare(&name, &world.view, &tile(&world, &mut random, count));
            }
        }
    }
    assert!(hits > 5000, "only {hits} hits were compared");
}

#[test]
fn neighbours_of_rays_that_hit_nothing_or_need_care_are_answered() {
    let nan = f32::NAN;
    let odd = [
        Ray::new([nan, 0.0, 0.0], [0.0, 1.0, 0.0]),
        Ray::new([0.0; 3], [0.0; 3]),
        Ray::new([0.0; 3], [0.0, 1.0, 0.0]).with_range(2.0, 1.0),
        Ray::new([0.0; 3], [0.0, 1.0, f32::INFINITY]),
        Ray::new([3e38, 1.0, -3e38], [-1.0, 0.0, 1.0]),
        Ray::new([0.1, 0.2, -3.0], [1e-39, 0.0, 1e-38]),
        Ray::new([0.1, 0.2, -3.0], [0.0, -0.0, 3e38]),
        Ray::new([0.1, 0.2, -3.0], [0.0, -0.0, 1.0]).with_range(-1.0, f32::INFINITY),
    ];
    let mut random = Random::new(31);
    for world in worlds(31) {
        let mut batch = tile(&world, &mut random, 160);
        for _ in 0..40 {
            let at = random.below(batch.len());
            batch[at] = odd[random.below(odd.len())];
        }
        compare(&world.name, &world.view, &batch);
    }
}

#[test]
fn rays_that_meet_shared_edges_and_vertices_exactly_answer_like_single_calls() {
    let view = common::placed(common::grid(8, 8.0), &[Affine::IDENTITY, Affine::from_translation([0.0, 0.0, 8.0])]);
    // A tile straight down whose rays pass through vertices, edges and diagonals.
    let down: Vec<Ray> = (0..64)
        .map(|at| Ray::new([(at % 8) as f32 * 0.5 + 1.0, 3.0, (at / 8) as f32 * 0.5 + 6.0], [0.0, -1.0, 0.0]))
        .collect();
    assert_eq!(compare("grid from above", &view, &down), down.len());
}

#[test]
fn hidden_instances_stay_hidden() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(common::cube(), Motion::Static).unwrap();
    let seen = scene.add_instance(scene.root(), mesh, Affine::from_translation([0.0, 0.0, 5.0])).unwrap();
    let hidden = scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
    scene.set_mask(hidden, 0).unwrap();
    let view = scene.commit();
    let rays: Vec<Ray> = (0..64).map(|at| Ray::new([at as f32 * 0.01, 0.3, -9.0], [0.0, 0.0, 1.0])).collect();
    compare("a hidden cube", &view, &rays);
    let mut hits = vec![None; rays.len()];
    view.closest_hits(&rays, &mut hits, Coherence::Coherent);
    assert!(hits.iter().all(|hit| hit.is_some_and(|hit| view.instance_id(&hit) == seen)));
}

#[test]
fn filters_are_not_asked_about_opaque_instances_in_batches_either() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(common::cube(), Motion::Static).unwrap();
    let solid = scene.add_instance(scene.root(), mesh, Affine::from_translation([0.0, 0.0, 5.0])).unwrap();
    scene.set_opaque(solid, true).unwrap();
    scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
    let view = scene.commit();
    let rays: Vec<Ray> = (0..130).map(|at| Ray::new([at as f32 * 0.005, 0.3, -9.0], [0.0, 0.0, 1.0])).collect();
    for (level, claim) in Level::available().into_iter().flat_map(|level| CLAIMS.map(|claim| (level, claim))) {
        let view = view.at_level(level);
        let mut hits = vec![None; rays.len()];
        view.query().filter(&|_| false).closest_hits(&rays, &mut hits, claim);
        assert!(hits.iter().all(|hit| hit.is_some_and(|hit| view.instance_id(&hit) == solid)), "{level:?}, {claim:?}");
    }
}

#[test]
fn a_large_incoherent_batch_is_answered_in_its_own_order() {
    // Large enough that the rays are sorted.
    let mut random = Random::new(41);
    let view = common::alone(random.soup(150_000, 10.0, 0.2));
    assert!(view.instance_at(0).bvh().heap_bytes() > 8 << 20);
    let mut batch: Vec<Ray> = (0..6000).map(|_| Ray::new(random.point(12.0), random.direction())).collect();
    batch[17] = Ray::new([f32::NAN; 3], [1.0, 0.0, 0.0]);
    batch[4000] = Ray::new([0.0; 3], [0.0; 3]);
    let single: Vec<_> = batch.iter().map(|ray| view.closest_hit(ray)).collect();
    let mut work = Work::default();
    batch.iter().for_each(|ray| _ = view.query().closest_hit_counted(ray, &mut work));
    assert!(work.nodes + work.leaves > 15 * batch.len() as u64, "rays that are worth sorting: {work}");
    for (ray, hit) in batch.iter().zip(&single).step_by(50) {
        assert_eq!(*hit, view.query().brute_force().closest_hit(ray), "seed 41, {ray:?}");
    }
    for level in Level::available() {
        let view = view.at_level(level);
        let mut hits = vec![None; batch.len()];
        let mut dark = vec![false; batch.len()];
        view.closest_hits(&batch, &mut hits, Coherence::Incoherent);
        view.occluded_each(&batch, &mut dark, Coherence::Incoherent);
        assert!(hits == single, "seed 41, {level:?}");
        assert!(dark.iter().zip(&single).all(|(dark, hit)| *dark == hit.is_some()), "seed 41, {level:?}");
    }

    let filter = |candidate: &Candidate<'_>| is_there(candidate, candidate.ray_index());
    let mut hits = vec![None; batch.len()];
    view.query().filter(&filter).closest_hits(&batch, &mut hits, Coherence::Incoherent);
    let alone = |(at, ray)| {
        let filter = |candidate: &Candidate<'_>| is_there(candidate, at);
        view.query().filter(&filter).closest_hit(ray)
    };
    assert!(hits == (0..).zip(&batch).map(alone).collect::<Vec<_>>(), "seed 41");
}

/// What a filter of these tests says about a place on a triangle, for a ray of a batch.
fn is_there(candidate: &Candidate<'_>, ray: u32) -> bool {
    let bits = candidate.u().to_bits() ^ candidate.v().to_bits() ^ candidate.t().to_bits();
    (bits ^ candidate.primitive() ^ candidate.instance_index() ^ ray).count_ones() % 3 != 0
}

#[test]
fn batches_obey_masks_culling_and_filters_like_single_calls() {
    let (mut refused, mut masked, mut kept) = (0, 0, 0);
    for seed in 50..52 {
        let mut random = Random::new(seed);
        for world in worlds(seed) {
            // Instances with masks of their own, some of them opaque.
            let world = rebuilt(&world, QUALITIES[1]);
            let mut batches = vec![rays(&world, 200, &mut random)];
            batches.extend((0..4).map(|_| tile(&world, &mut random, 150)));
            for (batch, cull) in batches.iter().flat_map(|batch| CULLS.map(|cull| (batch, cull))) {
                for mask in [0b111, 0b101, 0b010, 0] {
                    // The ray's number counts: a filter has to be told which ray it is asked about.
                    let single = |at: usize| {
                        let filter = |candidate: &Candidate<'_>| is_there(candidate, at as u32);
                        world.view.query().mask(mask).cull(cull).filter(&filter).closest_hit(&batch[at])
                    };
                    let expected: Vec<_> = (0..batch.len()).map(single).collect();
                    for (level, claim) in Level::available().into_iter().flat_map(|level| CLAIMS.map(|it| (level, it)))
                    {
                        let view = world.view.at_level(level);
                        let filter = |candidate: &Candidate<'_>| is_there(candidate, candidate.ray_index());
                        let query = view.query().mask(mask).cull(cull).filter(&filter);
                        let mut hits = vec![None; batch.len()];
                        let mut dark = vec![false; batch.len()];
                        query.closest_hits(batch, &mut hits, claim);
                        query.occluded_each(batch, &mut dark, claim);
                        let what =
                            format!("`{}`, seed {seed}, {level:?}, {claim:?}, {cull:?}, mask {mask}", world.name);
                        assert_eq!(hits, expected, "{what}");
                        assert!(dark.iter().zip(&expected).all(|(dark, hit)| *dark == hit.is_some()), "{what}");
                    }
                    let open = |ray: &Ray| world.view.query().mask(mask).cull(cull).closest_hit(ray);
                    refused += batch.iter().zip(&expected).filter(|(ray, hit)| open(ray) != **hit).count();
                    masked +=
                        batch.iter().filter(|ray| open(ray) != world.view.query().cull(cull).closest_hit(ray)).count();
                    kept += expected.iter().flatten().count();
                }
            }
        }
    }
    assert!(refused > 1000 && masked > 1000 && kept > 1000, "{refused} refused, {masked} masked, {kept} kept");
}

#[test]
#[should_panic(expected = "one hit per ray")]
fn a_batch_with_too_few_hits_panics() {
    let rays = [Ray::new([0.0; 3], [1.0, 0.0, 0.0]); 3];
    common::alone(common::cube()).closest_hits(&rays, &mut [None; 2], Coherence::Coherent);
}

#[test]
#[should_panic(expected = "one answer per ray")]
fn a_batch_with_too_many_answers_panics() {
    let rays = [Ray::new([0.0; 3], [1.0, 0.0, 0.0]); 3];
    common::alone(common::cube()).occluded_each(&rays, &mut [false; 4], Coherence::Unknown);
}
