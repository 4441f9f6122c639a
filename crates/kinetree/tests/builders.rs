//! Every quality of tree, on every awkward and random world, against brute force and
//! against each other.

mod common;

use std::sync::Arc;

use common::{Backwards, QUALITIES, Random, rays, rebuilt, worlds};
use kinetree::build::{BuildOptions, Quality, build_triangles};
use kinetree::geometry::Triangles;
use kinetree::{Aabb, Affine, Hit, Mesh, MeshBvh, Motion, Ray, Scene, Snapshot, Threads, Work};

fn diagonals(count: usize, seed: u64) -> Vec<[f32; 3]> {
    let mut random = Random::new(seed);
    let mut positions = Vec::new();
    for _ in 0..count {
        let (from, along, aside) = (random.point(1.0), random.direction(), random.direction());
        let length = random.within(0.3, 0.7);
        positions.push(from);
        positions.push([0, 1, 2].map(|axis| from[axis] + along[axis] * length));
        positions.push([0, 1, 2].map(|axis| from[axis] + along[axis] * length + aside[axis] * 0.01));
    }
    positions
}

fn loose(positions: Vec<[f32; 3]>) -> Triangles {
    let indices: Arc<[[u32; 3]]> = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Triangles::new(positions, indices).unwrap()
}

fn soup(count: usize, seed: u64) -> Triangles {
    let mesh = Random::new(seed).soup(count, 3.0, 0.6);
    Triangles::new(mesh.positions().to_vec(), mesh.triangles().into()).unwrap()
}

fn view_of(positions: &[[f32; 3]], indices: &[[u32; 3]], quality: Quality) -> Snapshot {
    common::alone(Mesh::new(positions, indices).unwrap().with_quality(quality))
}

#[test]
fn every_quality_agrees_with_looking_everywhere() {
    let mut random = Random::new(21);
    for world in worlds(21).iter().filter(|world| world.view.instances().len() < 100) {
        for quality in QUALITIES {
            let world = rebuilt(world, quality);
            for view in world.view.instances() {
                assert_eq!(view.bvh().validate(), Ok(()), "{}", world.name);
                assert_eq!(view.bvh().primitive_count(), view.triangles().len(), "{}", world.name);
            }
            for ray in rays(&world, 1000, &mut random) {
                let (query, twin) = (world.view.query(), world.view.query().brute_force());
                let (found, expected) = (query.closest_hit(&ray), twin.closest_hit(&ray));
                let agree = match (&found, &expected) {
                    (Some(found), Some(expected)) => found.agrees_with(expected),
                    (found, expected) => found.is_none() && expected.is_none(),
                };
                assert!(agree, "closest in `{}`: {found:?}, not {expected:?}, for {ray:?}", world.name);
                assert_eq!(query.occluded(&ray), expected.is_some(), "occluded in `{}` for {ray:?}", world.name);
                assert_eq!(query.all_hits(&ray), twin.all_hits(&ray), "all hits in `{}` for {ray:?}", world.name);
            }
        }
    }
}

#[test]
fn every_quality_gives_the_same_valid_tree_for_any_threads() {
    for geometry in [soup(40_000, 3), loose(diagonals(20_000, 4)), soup(1, 5), soup(0, 6)] {
        for quality in QUALITIES {
            let build = |threads| {
                let mut options = BuildOptions::default();
                (options.quality, options.threads) = (quality, threads);
                build_triangles(&geometry, &options)
            };
            let tree = build(Threads::one());
            assert_eq!(tree.validate(), Ok(()), "{quality:?}");
            for threads in [Threads::default(), Threads::of(Arc::new(Backwards))] {
                let other = build(threads);
                assert_eq!(other.nodes(), tree.nodes(), "{quality:?}");
                assert_eq!(other.primitives(), tree.primitives(), "{quality:?}");
            }
        }
    }
}

#[test]
fn a_split_tree_has_the_same_hits_as_a_whole_one() {
    let mut random = Random::new(31);
    let geometry = loose(diagonals(20_000, 32));
    let [fast, best] =
        [Quality::Fast, Quality::Best].map(|quality| view_of(geometry.positions(), geometry.indices(), quality));
    let key = |hit: Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.primitive));
    for i in 0..300_000 {
        let origin = random.point(1.5);
        let corner = geometry.positions()[random.below(geometry.positions().len())];
        let direction = if i % 2 == 0 { random.direction() } else { [0, 1, 2].map(|axis| corner[axis] - origin[axis]) };
        let ray = Ray::new(origin, direction);
        assert_eq!(key(best.closest_hit(&ray)), key(fast.closest_hit(&ray)), "{ray:?}");
    }
}

#[test]
fn long_diagonals_are_cut_and_rays_meet_far_fewer_of_them() {
    let geometry = loose(diagonals(20_000, 41));
    let mut options = BuildOptions::default();
    let whole = build_triangles(&geometry, &options);
    options.quality = Quality::Best;
    let split = build_triangles(&geometry, &options);
    assert!(!whole.has_duplicates() && split.has_duplicates());
    assert!(split.primitives().len() <= 6 * geometry.len());
    assert!(split.cost(1.0, 1.0) < 0.5 * whole.cost(1.0, 1.0));
    // Counted, not only expected: the same rays, in both trees.
    let [of_whole, of_split] = [Quality::Fast, Quality::Best].map(|quality| {
        let view = view_of(geometry.positions(), geometry.indices(), quality);
        let (mut random, mut work) = (Random::new(42), Work::default());
        for _ in 0..5000 {
            let ray = Ray::new(random.point(2.0), random.direction());
            view.query().closest_hit_counted(&ray, &mut work);
        }
        work
    });
    println!("whole: {of_whole}; split: {of_split}");
    assert!(2 * of_split.triangles < of_whole.triangles && 2 * of_split.nodes < of_whole.nodes);
    // Well-shaped triangles need no more than the usual budget.
    let mesh = common::sphere(80, 120);
    let geometry = Triangles::new(mesh.positions().to_vec(), mesh.triangles().into()).unwrap();
    assert!(build_triangles(&geometry, &options).primitives().len() as f32 <= 1.31 * geometry.len() as f32);
}

#[test]
fn reinsertion_lowers_the_cost() {
    for geometry in [soup(20_000, 51), loose(diagonals(5000, 52))] {
        let mut options = BuildOptions::default();
        let mut cost = |quality| {
            options.quality = quality;
            build_triangles(&geometry, &options).cost(1.0, 1.0)
        };
        let without = cost(Quality::Fastest);
        let once = cost(Quality::Fast);
        assert!(once < without && cost(Quality::Balanced) < once);
    }
}

/// A closed, very long and thin prism of slivers that lies askew, so that spatial splits cut it
/// many times.
fn skewed_tube(turn: f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let place = Affine::from_axis_angle([1.0, 2.0, 3.0], turn) * Affine::from_scale([0.05, 40.0, 0.05]);
    let (around, along) = (24_u32, 3_u32);
    let mut positions = Vec::new();
    for ring in 0..=along {
        for i in 0..around {
            let angle = std::f32::consts::TAU * i as f32 / around as f32;
            let at = [angle.cos(), ring as f32 / along as f32 * 2.0 - 1.0, angle.sin()];
            positions.push(place.transform_point(at));
        }
    }
    let caps = [place.transform_point([0.0, -1.0, 0.0]), place.transform_point([0.0, 1.0, 0.0])];
    positions.extend(caps);
    let mut triangles = Vec::new();
    for i in 0..around {
        let next = (i + 1) % around;
        for ring in 0..along {
            let at = |ring: u32, i: u32| ring * around + i;
            triangles.push([at(ring, i), at(ring + 1, i), at(ring, next)]);
            triangles.push([at(ring, next), at(ring + 1, i), at(ring + 1, next)]);
        }
        triangles.push([positions.len() as u32 - 2, i, next]);
        triangles.push([positions.len() as u32 - 1, along * around + next, along * around + i]);
    }
    (positions, triangles)
}

#[test]
fn rays_at_split_planes_edges_and_vertices_never_slip_between_pieces() {
    let mut random = Random::new(61);
    for turn in [0.3, 0.9, 2.2] {
        let (positions, indices) = skewed_tube(turn);
        let mut options = BuildOptions::default();
        options.quality = Quality::Best;
        let geometry = Triangles::new(positions.clone(), indices.clone().into()).unwrap();
        let tree = build_triangles(&geometry, &options);
        assert!(tree.primitives().len() as f32 > 1.2 * geometry.len() as f32, "the tube is cut");
        // Faces of leaves: that is where the planes were.
        let faces: Vec<Aabb> = tree.nodes().iter().filter(|node| node.link.is_leaf()).map(|node| node.bounds).collect();
        let view = view_of(&positions, &indices, Quality::Best);
        let axis_of_tube = |s: f32| {
            let [a, b] = [positions[positions.len() - 2], positions[positions.len() - 1]];
            [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * s)
        };
        for i in 0..400_000 {
            let origin = axis_of_tube(random.within(0.01, 0.99));
            let [a, b, c] = indices[random.below(indices.len())].map(|vertex| positions[vertex as usize]);
            let mut target = match i % 4 {
                0 => a,
                1 => [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * 0.37),
                _ => {
                    let (u, v) = (random.unit() * 0.5, random.unit() * 0.5);
                    [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * u + (c[axis] - a[axis]) * v)
                }
            };
            if i % 4 == 3 {
                // Onto the plane of a face, and in it when the origin is moved there too.
                let face = faces[random.below(faces.len())];
                let axis = random.below(3);
                target[axis] = if random.unit() < 0.5 { face.min[axis] } else { face.max[axis] };
            }
            let ray = Ray::new(origin, [0, 1, 2].map(|axis| target[axis] - origin[axis]));
            assert!(view.occluded(&ray), "turn {turn}: {ray:?} slipped out");
            assert!(view.closest_hit(&ray).is_some(), "turn {turn}: {ray:?} slipped out");
        }
    }
}

#[test]
fn rays_that_run_in_split_planes_meet_the_pieces_on_both_sides() {
    let mut random = Random::new(71);
    let geometry = loose(diagonals(3000, 72));
    let mut options = BuildOptions::default();
    options.quality = Quality::Best;
    let tree = build_triangles(&geometry, &options);
    let leaves: Vec<Aabb> = tree.nodes().iter().filter(|node| node.link.is_leaf()).map(|node| node.bounds).collect();
    let [fast, best] =
        [Quality::Fast, Quality::Best].map(|quality| view_of(geometry.positions(), geometry.indices(), quality));
    let key = |hit: Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.primitive));
    for _ in 0..300_000 {
        let face = leaves[random.below(leaves.len())];
        let axis = random.below(3);
        let mut origin = random.point(1.2);
        let mut direction = random.direction();
        origin[axis] = if random.unit() < 0.5 { face.min[axis] } else { face.max[axis] };
        direction[axis] = 0.0;
        if random.unit() < 0.3 {
            let straight = (axis + 1) % 3;
            direction = [0.0; 3];
            direction[straight] = 1.0;
            origin[straight] = -2.0;
        }
        let ray = Ray::new(origin, direction);
        if let Some(ray) = (direction != [0.0; 3]).then_some(ray) {
            assert_eq!(key(best.closest_hit(&ray)), key(fast.closest_hit(&ray)), "{ray:?}");
        }
    }
}

#[test]
fn a_split_tree_that_is_refitted_still_has_every_hit() {
    let mut random = Random::new(81);
    let still = diagonals(2000, 82);
    let indices: Vec<[u32; 3]> = (0..2000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mut scene = Scene::new();
    let mesh = Mesh::new(&still, &indices).unwrap().with_quality(Quality::Best);
    let mesh = scene.add_mesh(mesh, Motion::Deforming).unwrap();
    scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
    scene.commit();
    for step in 1..4 {
        let bent: Vec<_> = still.iter().map(|p| [p[0] + 0.02 * step as f32 * p[1], p[1], p[2] * 1.01]).collect();
        scene.set_positions(mesh, &bent).unwrap();
        let view = scene.commit();
        assert_eq!(view.instance_at(0).bvh().validate(), Ok(()));
        for _ in 0..2000 {
            let origin = random.point(1.5);
            let target = bent[random.below(bent.len())];
            let ray = Ray::new(origin, [0, 1, 2].map(|axis| target[axis] - origin[axis]));
            assert_eq!(view.query().all_hits(&ray), view.query().brute_force().all_hits(&ray), "{ray:?}");
        }
    }
}

#[test]
fn the_quality_of_a_mesh_overrides_that_of_its_motion() {
    let positions = diagonals(3000, 91);
    let indices: Vec<[u32; 3]> = (0..3000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let blocks = |quality| view_of(&positions, &indices, quality).instance_at(0).bvh().blocks().len();
    assert!(blocks(Quality::Best) > blocks(Quality::Fast) * 3 / 2);
}

#[test]
fn every_motion_builds_with_the_quality_that_its_table_says() {
    let geometry = soup(3000, 95);
    let nodes_of = |quality| {
        let mut options = BuildOptions::default();
        options.quality = quality;
        MeshBvh::new(&build_triangles(&geometry, &options), &geometry).tree().nodes().to_vec()
    };
    let table = [
        (Motion::Static, Quality::Balanced),
        (Motion::Rigid, Quality::Fast),
        (Motion::Deforming, Quality::Fast),
        (Motion::Dynamic, Quality::Fastest),
    ];
    for (motion, quality) in table {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh::new(geometry.positions(), geometry.indices()).unwrap(), motion).unwrap();
        scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
        let nodes = scene.commit().instance_at(0).bvh().tree().nodes().to_vec();
        for other in QUALITIES {
            assert_eq!(nodes == nodes_of(other), other == quality, "{motion:?}, {other:?}");
        }
    }
}
