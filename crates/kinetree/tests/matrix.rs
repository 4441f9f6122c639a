//! Every builder with every layout, level, question and kind of batch, on every awkward and random
//! world, against brute force.

mod common;

use std::ops::Range;

use common::{QUALITIES, Random, World, rays, rebuilt, tile, worlds};
use kinetree::build::{self, BuildOptions};
use kinetree::geometry::{Triangles, WatertightRay};
use kinetree::simd::Level;
use kinetree::tree::Target;
use kinetree::{Aabb, Affine, Bvh, Candidate, Coherence, Cull, Hit, MeshBvh, Query, Ray, Snapshot, Work};

const CLAIMS: [Coherence; 3] = [Coherence::Coherent, Coherence::Incoherent, Coherence::Unknown];

/// What looking at every triangle has to say about a ray.
struct Truth {
    ray: Ray,
    closest: Option<Hit>,
    all: Vec<Hit>,
}

fn truth_about(rays: Vec<Ray>, query: Query<'_>) -> Vec<Truth> {
    let looking = query.brute_force();
    rays.into_iter()
        .map(|ray| {
            let (closest, all) = (looking.closest_hit(&ray), looking.all_hits(&ray));
            assert_eq!(looking.occluded(&ray), closest.is_some(), "{ray:?}");
            assert_eq!(all.first(), closest.as_ref(), "{ray:?}");
            Truth { ray, closest, all }
        })
        .collect()
}

fn hits_of(truths: &[Truth]) -> usize {
    truths.iter().filter(|truth| truth.closest.is_some()).count()
}

fn differing(some: &[Truth], others: &[Truth]) -> usize {
    some.iter().zip(others).filter(|(one, other)| one.closest != other.closest).count()
}

fn compare_single(what: &str, query: Query<'_>, truths: &[Truth]) {
    let mut work = Work::default();
    for Truth { ray, closest, all } in truths {
        assert_eq!(query.closest_hit(ray), *closest, "closest in {what} for {ray:?}");
        assert_eq!(query.closest_hit_counted(ray, &mut work), *closest, "closest, counted, in {what} for {ray:?}");
        assert_eq!(query.occluded(ray), closest.is_some(), "occluded in {what} for {ray:?}");
        assert_eq!(query.occluded_counted(ray, &mut work), closest.is_some(), "the same, counted, {what}, {ray:?}");
        assert_eq!(query.all_hits(ray), *all, "all hits in {what} for {ray:?}");
        assert_eq!(query.all_hits_counted(ray, &mut work), *all, "all hits, counted, in {what} for {ray:?}");
    }
}

fn compare_batches(what: &str, view: &Snapshot, truths: &[Truth]) {
    let rays: Vec<Ray> = truths.iter().map(|truth| truth.ray).collect();
    for claim in CLAIMS {
        // Answers that are wrong until they are written.
        let mut hits: Vec<Option<Hit>> = truths.iter().rev().map(|truth| truth.closest).collect();
        let mut dark: Vec<bool> = truths.iter().map(|truth| truth.closest.is_none()).collect();
        view.closest_hits(&rays, &mut hits, claim);
        view.occluded_each(&rays, &mut dark, claim);
        for (at, Truth { ray, closest, .. }) in truths.iter().enumerate() {
            assert_eq!(hits[at], *closest, "{claim:?} batch in {what}, ray {at}: {ray:?}");
            assert_eq!(dark[at], closest.is_some(), "{claim:?} batch, occluded in {what}, ray {at}: {ray:?}");
        }
    }
}

fn every_tree_is_valid(world: &World) {
    assert_eq!(world.view.top_level().validate(), Ok(()), "{}", world.name);
    for view in world.view.instances() {
        assert_eq!(view.bvh().validate(), Ok(()), "{}", world.name);
        assert_eq!(view.bvh().primitive_count(), view.triangles().len(), "{}", world.name);
    }
}

#[test]
fn every_quality_level_question_and_batch_agrees_with_looking_everywhere() {
    let mut hits = 0;
    for seed in 100..102 {
        let mut random = Random::new(seed);
        for world in worlds(seed) {
            let mut mixed = rays(&world, 330, &mut random);
            mixed.extend(tile(&world, &mut random, 64));
            let mixed = truth_about(mixed, world.view.query());
            let picture = truth_about(tile(&world, &mut random, 128), world.view.query());
            hits += hits_of(&mixed) + hits_of(&picture);
            for quality in QUALITIES {
                let world = rebuilt(&world, quality);
                every_tree_is_valid(&world);
                for level in Level::available() {
                    let what = format!("`{}`, {level:?}, seed {seed}", world.name);
                    let view = world.view.at_level(level);
                    compare_single(&what, view.query(), &mixed);
                    compare_single(&what, view.query(), &picture);
                    compare_batches(&what, &view, &mixed);
                    compare_batches(&what, &view, &picture);
                }
            }
        }
    }
    assert!(hits > 5000, "only {hits} hits were compared");
}

#[test]
fn masks_culling_and_filters_hold_for_every_quality_and_level() {
    let holes = |candidate: &Candidate<'_>| (candidate.primitive() + candidate.instance_index()) % 3 != 0;
    let seed = 110;
    let mut random = Random::new(seed);
    // Hits that are left, those that filters change, and those that masks and culling change.
    let mut counts = [0; 3];
    for world in worlds(seed) {
        let mut asked = rays(&world, 60, &mut random);
        asked.extend(tile(&world, &mut random, 20));
        for quality in QUALITIES {
            let world = rebuilt(&world, quality);
            for (mask, cull) in [(0b101, Cull::None), (0b010, Cull::Back), (0b011, Cull::Front), (0b111, Cull::Back)] {
                let query = world.view.query().mask(mask).cull(cull);
                let plain = truth_about(asked.clone(), query);
                let filtered = truth_about(asked.clone(), query.filter(&holes));
                let open = truth_about(asked.clone(), world.view.query());
                counts[0] += hits_of(&filtered);
                counts[1] += differing(&filtered, &plain);
                counts[2] += differing(&plain, &open);
                for level in Level::available() {
                    let what = format!("`{}`, {level:?}, mask {mask:#b}, {cull:?}, seed {seed}", world.name);
                    let view = world.view.at_level(level);
                    let query = view.query().mask(mask).cull(cull);
                    compare_single(&what, query, &plain);
                    compare_single(&format!("{what}, with holes"), query.filter(&holes), &filtered);
                }
            }
        }
    }
    assert!(counts.iter().all(|&count| count > 1000), "{counts:?} are too few to say anything");
}

/// Every hit on the way through a binary tree. Boxes are entered generously, so that the tree and
/// its walk are on trial and not this.
struct Hits<'a> {
    ray: Ray,
    sheared: WatertightRay,
    tree: &'a Bvh,
    triangles: &'a Triangles,
    found: Vec<(u32, u32)>,
}

impl Hits<'_> {
    /// Visits every leaf whose box, and whose ancestors' boxes, are entered.
    fn walk(&mut self) {
        let mut pending: Vec<u32> = (0..self.tree.node_count().min(1) as u32).collect();
        while let Some(at) = pending.pop() {
            let node = self.tree.nodes()[at as usize];
            match node.link.target() {
                _ if !self.enters(&node.bounds) => {}
                Target::Node(first) => pending.extend([first, first + 1]),
                Target::Primitives(range) => self.leaf(range),
            }
        }
    }

    fn enters(&self, bounds: &Aabb) -> bool {
        let (mut entry, mut exit) = (0.0_f64, f64::INFINITY);
        let from_origin = |plane: f32, axis: usize| f64::from(plane) - f64::from(self.ray.origin[axis]);
        let far = (0..3)
            .map(|axis| from_origin(bounds.min[axis], axis).abs().max(from_origin(bounds.max[axis], axis).abs()))
            .fold(0.0, f64::max);
        for axis in 0..3 {
            let low = from_origin(bounds.min[axis], axis) - 1e-5 * far;
            let high = from_origin(bounds.max[axis], axis) + 1e-5 * far;
            let direction = f64::from(self.ray.direction[axis]);
            if direction == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return false;
                }
                continue;
            }
            let (one, other) = (low / direction, high / direction);
            entry = entry.max(one.min(other));
            exit = exit.min(one.max(other));
        }
        entry <= exit
    }

    fn leaf(&mut self, range: Range<u32>) {
        for &primitive in &self.tree.primitives()[range.start as usize..range.end as usize] {
            let hit = self.sheared.hit(&self.triangles.get(primitive), self.ray.t_min, self.ray.t_max);
            self.found.extend(hit.map(|hit| (hit.t.to_bits(), primitive)));
        }
    }
}

/// What each builder makes of the triangles.
fn grown(triangles: &Triangles) -> Vec<(String, Bvh)> {
    let options = BuildOptions::default();
    let bounds_of = |triangle| triangles.bounds_of(triangle);
    let boxes: Vec<Aabb> = (0..triangles.len() as u32).map(bounds_of).collect();
    let mut trees = vec![
        ("binned".into(), build::build_binned(triangles.len(), bounds_of, &options)),
        ("clustered".into(), build::build_clustered(triangles.len(), bounds_of, &options)),
        ("spatial".into(), build::build_spatial(triangles, &options)),
        ("agglomerate".into(), build::agglomerate(&boxes).bvh),
    ];
    for quality in QUALITIES {
        let mut options = options.clone();
        options.quality = quality;
        trees.push((format!("{quality:?}"), build::build_triangles(triangles, &options)));
    }
    trees
}

#[test]
fn every_builder_and_layout_is_valid_and_walks_of_binary_trees_find_every_hit() {
    let seed = 120;
    let mut random = Random::new(seed);
    let mut hits = 0;
    for world in worlds(seed) {
        if world.view.instances().len() != 1 || *world.view.instance_at(0).world_from_object() != Affine::IDENTITY {
            continue;
        }
        let mesh = world.view.instance_at(0);
        let triangles = Triangles::new(mesh.positions().to_vec(), mesh.triangles().into()).unwrap();
        let truths = truth_about(rays(&world, 550, &mut random), world.view.query());
        hits += hits_of(&truths);
        for (builder, tree) in grown(&triangles) {
            let what = format!("`{}`, {builder}, seed {seed}", world.name);
            assert_eq!(tree.validate(), Ok(()), "{what}");
            let wide = MeshBvh::new(&tree, &triangles);
            assert_eq!(wide.validate(), Ok(()), "{what}");
            assert_eq!(wide.primitive_count(), triangles.len(), "{what}");
            for Truth { ray, all, .. } in &truths {
                let sheared = WatertightRay::new(ray);
                let mut visitor = Hits { ray: *ray, sheared, tree: &tree, triangles: &triangles, found: Vec::new() };
                visitor.walk();
                visitor.found.sort_unstable();
                visitor.found.dedup();
                let mut expected: Vec<_> = all.iter().map(|hit| (hit.t.to_bits(), hit.primitive)).collect();
                expected.sort_unstable();
                assert_eq!(visitor.found, expected, "{what} for {ray:?}");
            }
        }
    }
    assert!(hits > 1000, "only {hits} hits were compared");
}
