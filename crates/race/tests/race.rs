//! The promises of the race to renderers and benchmarks.

use std::collections::BTreeSet;

use kinetree::{Motion, Ray, Snapshot};
use kinetree_race::world;
use kinetree_world::{Frame, World};

const SEED: u64 = 1;

/// A hash of every coordinate of everything in the frame (FNV-1a).
fn fingerprint(frame: &Frame) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    let mut eat = |bits: u32| hash = (hash ^ u64::from(bits)).wrapping_mul(0x0100_0000_01b3);
    for instance in frame.snapshot.instances() {
        let placement = instance.world_from_object();
        eat(frame.surface_index(instance.index()).expect("every instance has a surface"));
        for column in [placement.x_axis, placement.y_axis, placement.z_axis, placement.translation] {
            column.iter().for_each(|value| eat(value.to_bits()));
        }
        // The crowd's meshes never change: reading them once for each spectator would take long.
        if instance.motion() != Motion::Rigid || instance.triangles().len() > 1000 {
            instance.positions().iter().flatten().for_each(|value| eat(value.to_bits()));
            instance.triangles().iter().flatten().for_each(|&index| eat(index));
        }
    }
    hash
}

fn frame(world: &mut World, seconds: f64) -> Frame {
    world.frame(seconds).expect("a frame at any time")
}

/// The triangles of the smoke, which alone is rebuilt.
fn smoke(frame: &Frame) -> usize {
    let rebuilt = frame.snapshot.instances().filter(|instance| instance.motion() == Motion::Dynamic);
    rebuilt.map(|instance| instance.triangles().len()).sum()
}

/// Indices of the instances of the two cars' bodies.
fn bodies(view: &Snapshot) -> Vec<u32> {
    let rigid = view.instances().filter(|instance| instance.motion() == Motion::Rigid);
    rigid.filter(|instance| instance.triangles().len() > 5000).map(|instance| instance.index()).collect()
}

#[test]
fn the_same_seed_makes_the_same_race_and_another_seed_another() {
    let [a, b, other] = [SEED, SEED, 2].map(|seed| fingerprint(&frame(&mut world(seed), 3.7)));
    assert_eq!(a, b);
    assert_ne!(a, other);
}

#[test]
fn a_frame_depends_on_its_time_alone() {
    let fresh = fingerprint(&frame(&mut world(SEED), 3.7));
    let mut used = world(SEED);
    for seconds in [11.0, 0.0, 19.99, 4.0] {
        frame(&mut used, seconds);
    }
    assert_eq!(fingerprint(&frame(&mut used, 3.7)), fresh);
}

#[test]
fn the_race_begins_again_without_a_seam() {
    let mut race = world(SEED);
    let duration = race.animation.duration();
    assert!(duration > 0.0);
    let first = frame(&mut race, 1.25);
    assert_eq!(fingerprint(&first), fingerprint(&frame(&mut race, 1.25 + duration)));
    assert_eq!(fingerprint(&first), fingerprint(&frame(&mut race, 1.25 - duration)));

    // Shortly before the end everything is nearly where it is at the beginning.
    let (end, begin) = (frame(&mut race, duration - 1e-4), frame(&mut race, 0.0));
    let moving = |frame: &Frame| -> Vec<([f32; 3], Vec<[f32; 3]>)> {
        let parts = frame
            .snapshot
            .instances()
            .filter(|instance| matches!(instance.motion(), Motion::Rigid | Motion::Deforming));
        parts
            .map(|part| (part.world_from_object().transform_point([0.0, 0.3, 0.3]), part.positions().to_vec()))
            .collect()
    };
    let apart = |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|axis| (a[axis] - b[axis]).abs()).fold(0.0, f32::max);
    for ((place_a, points_a), (place_b, points_b)) in moving(&end).iter().zip(&moving(&begin)) {
        assert!(apart(place_a, place_b) < 0.02, "{place_a:?} {place_b:?}");
        assert!(points_a.iter().zip(points_b).all(|(a, b)| apart(a, b) < 0.02));
    }
}

#[test]
fn every_kind_of_motion_is_there_and_the_scenery_is_large() {
    let mut race = world(SEED);
    let view = frame(&mut race, 0.0).snapshot;
    let (mut seen, mut scenery) = (Vec::new(), 0);
    let mut kinds = [0; 4];
    for instance in view.instances() {
        if seen.contains(&instance.mesh_id()) {
            continue;
        }
        seen.push(instance.mesh_id());
        let kind = instance.motion();
        scenery += if kind == Motion::Static { instance.triangles().len() } else { 0 };
        kinds[[Motion::Static, Motion::Rigid, Motion::Deforming, Motion::Dynamic]
            .iter()
            .position(|&m| m == kind)
            .unwrap_or(0)] += 1;
    }
    assert!(scenery >= 100_000, "{scenery}");
    assert!(kinds.iter().all(|&count| count > 0), "{kinds:?}");
    assert!((20..60).contains(&kinds[2]), "trees and flags: {}", kinds[2]);
    assert!(view.instances().len() > 3000, "{}", view.instances().len());
}

#[test]
fn every_frame_commits_and_every_tree_is_sound() {
    let mut race = world(SEED);
    for step in 0..12 {
        let seconds = f64::from(step) * 1.73;
        let view = frame(&mut race, seconds).snapshot;
        assert!(view.report().left_out.is_empty(), "at {seconds}");
        let mut last = None;
        for instance in view.instances() {
            // Trees of static meshes are checked once.
            let again = step > 0 && matches!(instance.motion(), Motion::Static | Motion::Rigid);
            if !again && last != Some(instance.mesh_id()) {
                last = Some(instance.mesh_id());
                assert!(instance.bvh().validate().is_ok(), "at {seconds}: {:?}", instance.bvh().validate());
            }
        }
    }
}

#[test]
fn trees_and_flags_bend_while_their_triangles_stay() {
    let mut race = world(SEED);
    let [a, b] = [2.0, 2.6].map(|seconds| frame(&mut race, seconds).snapshot);
    let deforming = |view: &'_ Snapshot| -> Vec<u32> {
        let parts = view.instances().filter(|instance| instance.motion() == Motion::Deforming);
        parts.map(|part| part.index()).collect()
    };
    for (before, after) in deforming(&a).into_iter().zip(deforming(&b)) {
        let (before, after) = (a.instance_at(before), b.instance_at(after));
        assert_eq!(before.triangles(), after.triangles());
        let pairs = before.positions().iter().zip(after.positions());
        let most = pairs.flat_map(|(a, b)| (0..3).map(|axis| (a[axis] - b[axis]).abs())).fold(0.0, f32::max);
        assert!(most > 0.01 && most < 3.0, "{most}");
    }
}

#[test]
fn smoke_comes_and_goes() {
    let mut race = world(SEED);
    let counts: Vec<usize> = (0..40).map(|i| smoke(&frame(&mut race, f64::from(i) * 0.5))).collect();
    assert!(counts.contains(&0), "{counts:?}");
    assert!(counts.iter().filter(|&&count| count > 50).count() > 4, "{counts:?}");
    let different: BTreeSet<usize> = counts.into_iter().collect();
    assert!(different.len() > 4, "{different:?}");
}

#[test]
fn every_surface_fits_its_mesh() {
    let mut race = world(SEED);
    for seconds in [0.0, 7.0, 13.0] {
        let frame = frame(&mut race, seconds);
        let material_set = &frame.material_set;
        for instance in frame.snapshot.instances() {
            let surface = frame.surface(instance.index()).expect("every instance has a surface");
            let vertices = instance.positions().len();
            if vertices > 0 {
                assert!(surface.uvs.len() == vertices && surface.colors.len() == vertices);
            }
            assert_eq!(surface.parts[0].first_triangle, 0);
            assert!(surface.parts.windows(2).all(|pair| pair[0].first_triangle < pair[1].first_triangle));
            assert!(surface.parts.iter().all(|part| (part.material as usize) < material_set.materials.len()));
        }
        for material in &material_set.materials {
            assert!(
                material.base_color_texture.is_none_or(|image| (image.texture as usize) < material_set.textures.len())
            );
        }
        for texture in &material_set.textures {
            assert_eq!(texture.texels.len(), (texture.width * texture.height) as usize);
        }
    }
}

#[test]
fn the_first_camera_sees_both_cars_and_trees_at_the_start() {
    let mut race = world(SEED);
    let frame = frame(&mut race, 0.0);
    assert_eq!(race.cameras[0].name, "track");
    let camera = race.camera(&race.cameras[0]).expect("it stands still");
    let bodies = bodies(&frame.snapshot);
    assert_eq!(bodies.len(), 2);
    let (mut cars, mut trees) = ([0; 2], 0);
    let (width, height) = (240, 135);
    for row in 0..height {
        for column in 0..width {
            let tangent = (0.5 * camera.fov_y).tan();
            let across = ((column as f32 + 0.5) / width as f32 * 2.0 - 1.0) * tangent * 16.0 / 9.0;
            let up = (1.0 - (row as f32 + 0.5) / height as f32 * 2.0) * tangent;
            let ray = Ray::new(camera.position(), camera.world_from_camera.transform_vector([across, up, -1.0]));
            let Some(hit) = frame.snapshot.closest_hit(&ray) else { continue };
            for (car, &body) in bodies.iter().enumerate() {
                cars[car] += usize::from(hit.instance_index() == body);
            }
            trees += usize::from(frame.snapshot.instance(&hit).motion() == Motion::Deforming);
        }
    }
    assert!(cars.iter().all(|&pixels| pixels > 150), "{cars:?}");
    assert!(trees > 500, "{trees}");
}

#[test]
fn wheels_stand_on_the_mesh_of_the_road() {
    let mut race = world(SEED);
    for step in 0..10 {
        let view = frame(&mut race, f64::from(step) * 2.0).snapshot;
        let bodies = bodies(&view);
        // Each car's wheels follow its body.
        for wheel in bodies.iter().flat_map(|&body| body + 1..body + 5) {
            let hub = view.instance_at(wheel).world_from_object().translation;
            let ray = Ray::new(hub, [0.0, -1.0, 0.0]).with_range(0.0, 2.0);
            let below = view.query().all_hits(&ray);
            let road =
                below.iter().find(|hit| view.instance(hit).motion() == Motion::Static).expect("a road below the wheel");
            let gap = road.t * view.normal(road)[1] - 0.335;
            assert!(gap.abs() < 0.05, "at {}: {gap}", f64::from(step) * 2.0);
        }
    }
}

#[test]
fn every_seed_makes_a_race() {
    for seed in [0, 7, u64::MAX] {
        let view = frame(&mut world(seed), 0.0).snapshot;
        assert!(view.instances().len() > 3000, "seed {seed}: {}", view.instances().len());
        assert!(view.report().left_out.is_empty(), "seed {seed}");
    }
}

#[test]
fn awkward_times_are_times() {
    let mut race = world(SEED);
    for seconds in [f64::NAN, f64::INFINITY, -1e300, 1e300, -0.0] {
        assert!(frame(&mut race, seconds).snapshot.instances().len() > 3000);
    }
}
