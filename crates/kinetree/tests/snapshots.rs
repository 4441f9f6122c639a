//! A snapshot stays what it is, whatever is edited and committed later.

mod common;

use std::sync::atomic::{AtomicBool, Ordering};

use common::{Random, cube, grid, sphere};
use kinetree::{Affine, Hit, InstanceId, Mesh, MeshId, MorphTarget, Motion, NodeId, Pose, Ray, Scene, Snapshot};

/// One of each motion, in nested nodes.
struct Stage {
    scene: Scene,
    car: NodeId,
    wheel: NodeId,
    oak: MeshId,
    flag: MeshId,
    smoke: MeshId,
    crates: Vec<InstanceId>,
    box_mesh: MeshId,
}

fn stage() -> Stage {
    let mut scene = Scene::new();
    let root = scene.root();
    let track = scene.add_mesh(grid(20, 40.0), Motion::Static).unwrap();
    scene.add_instance(root, track, Affine::from_translation([-20.0, -2.0, -20.0])).unwrap();
    let body = scene.add_mesh(cube(), Motion::Rigid).unwrap();
    let car = scene.add_node(root, Affine::IDENTITY).unwrap();
    scene.add_instance(car, body, Affine::from_scale([2.0, 0.5, 1.0])).unwrap();
    let wheel = scene.add_node(car, Affine::from_translation([1.5, -0.5, 1.0])).unwrap();
    let round = scene.add_mesh(sphere(8, 12), Motion::Rigid).unwrap();
    scene.add_instance(wheel, round, Affine::from_scale([0.5, 0.5, 0.2])).unwrap();
    let oak = scene.add_mesh(sphere(20, 30), Motion::Deforming).unwrap();
    scene.add_instance(root, oak, Affine::from_translation([5.0, 0.0, -3.0])).unwrap();
    let cloth = grid(12, 3.0);
    let bend =
        MorphTarget { positions: cloth.positions().iter().map(|p| [0.0, p[0] * p[0], 0.0]).collect(), normals: vec![] };
    let flag = scene.add_mesh(cloth.with_morph_targets(vec![bend]).unwrap(), Motion::Deforming).unwrap();
    scene.add_instance(root, flag, Affine::from_translation([-6.0, 1.0, 0.0])).unwrap();
    let smoke = scene.add_mesh(Mesh::empty(), Motion::Dynamic).unwrap();
    scene.add_instance(root, smoke, Affine::IDENTITY).unwrap();
    let crates = (0..30)
        .map(|i| {
            let at = Affine::from_translation([(i % 6) as f32 * 3.0 - 9.0, (i / 6) as f32 * 2.5, -8.0]);
            scene.add_instance(root, body, at * Affine::from_scale([0.7; 3])).unwrap()
        })
        .collect();
    Stage { scene, car, wheel, oak, flag, smoke, crates, box_mesh: body }
}

/// Every kind of update, a different one each frame and all of them in time.
fn update(stage: &mut Stage, frame: u32, random: &mut Random) {
    let Stage { scene, car, wheel, oak, flag, smoke, crates, box_mesh } = stage;
    let phase = frame as f32 * 0.3;
    scene.place(*car, Affine::from_translation([phase.sin() * 4.0, 0.0, phase.cos() * 4.0])).unwrap();
    scene.place(*wheel, Affine::from_axis_angle([0.0, 0.0, 1.0], phase)).unwrap();
    if frame % 2 == 0 {
        let bent: Vec<_> = sphere(20, 30).positions().iter().map(|p| [p[0] + p[1] * phase.sin(), p[1], p[2]]).collect();
        scene.set_positions(*oak, &bent).unwrap();
    }
    if frame % 5 == 4 {
        // Neighbours part: this drifts, and is rebuilt.
        let torn: Vec<_> = sphere(20, 30).positions().iter().map(|_| random.point(2.0)).collect();
        scene.set_positions(*oak, &torn).unwrap();
    }
    scene.pose(*flag, &Pose { weights: &[phase.cos() * 0.3], joints: &[] }).unwrap();
    let puffs = random.soup(frame as usize % 4 * 25, 4.0, 0.5);
    scene.set_triangles(*smoke, puffs.positions(), puffs.triangles()).unwrap();
    match frame % 3 {
        0 => scene.remove_instance(crates.remove(0)).unwrap(),
        1 => {
            let at = Affine::from_translation(random.point(6.0));
            crates.push(scene.add_instance(scene.root(), *box_mesh, at).unwrap());
        }
        _ => scene.set_mask(crates[0], frame).unwrap(),
    }
    if frame % 4 == 1 {
        scene.place(crates[1], Affine::from_scale([0.0; 3])).unwrap();
    }
}

fn probes(seed: u64, count: usize) -> Vec<Ray> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|_| {
            let (from, to) = (random.point(14.0), random.point(6.0));
            Ray::new(from, [0, 1, 2].map(|axis| to[axis] - from[axis]))
        })
        .collect()
}

fn look(view: &Snapshot, rays: &[Ray]) -> Vec<Option<Hit>> {
    rays.iter().map(|ray| view.closest_hit(ray)).collect()
}

#[test]
fn a_snapshot_held_through_every_kind_of_update_stays_what_it_was() {
    let rays = probes(1, 400);
    let mut stage = stage();
    let mut random = Random::new(2);
    let mut held: Vec<(Snapshot, Vec<Option<Hit>>)> = Vec::new();
    for frame in 0..40 {
        update(&mut stage, frame, &mut random);
        let view = stage.scene.commit();
        let seen = look(&view, &rays);
        for (ray, hit) in rays.iter().zip(&seen).take(60) {
            let looked = view.query().brute_force().closest_hit(ray);
            assert_eq!(*hit, looked, "frame {frame}, {ray:?}");
        }
        let hits = seen.iter().flatten().count();
        assert!(hits > rays.len() / 4, "frame {frame}: only {hits} rays hit anything");
        // Some are held for one frame, some for several, so that buffers are claimed in many orders.
        if frame % 3 != 0 {
            held.push((view, seen));
        }
        if frame % 7 == 6 {
            held.drain(..held.len() / 2);
        }
        for (view, seen) in &held {
            assert_eq!(&look(view, &rays), seen, "frame {frame}");
        }
    }
    let Stage { scene, .. } = stage;
    drop(scene);
    for (view, seen) in &held {
        assert_eq!(&look(view, &rays), seen, "after the scene was dropped");
        view.instances().for_each(|instance| assert_eq!(instance.bvh().validate(), Ok(())));
    }
}

#[test]
fn a_clone_is_traced_on_another_thread_while_the_scene_moves_on() {
    let rays = probes(3, 300);
    let mut stage = stage();
    let mut random = Random::new(4);
    update(&mut stage, 1, &mut random);
    let view = stage.scene.commit();
    let seen = look(&view, &rays);
    let (ended, begun) = (AtomicBool::new(false), AtomicBool::new(false));
    std::thread::scope(|scope| {
        let tracer = scope.spawn(|| {
            let clone = view.clone();
            let mut rounds = 0;
            while !ended.load(Ordering::Acquire) || rounds < 3 {
                assert_eq!(look(&clone, &rays), seen);
                begun.store(true, Ordering::Release);
                rounds += 1;
            }
            rounds
        });
        while !begun.load(Ordering::Acquire) {
            std::thread::yield_now();
        }
        for frame in 2..60 {
            update(&mut stage, frame, &mut random);
            drop(stage.scene.commit());
        }
        ended.store(true, Ordering::Release);
        assert!(tracer.join().unwrap() >= 3);
    });
}

#[test]
fn buffers_take_turns_instead_of_being_allocated() {
    let mut stage = stage();
    let mut sizes = Vec::new();
    for frame in 0..30 {
        let phase = frame as f32 * 0.1;
        let bent: Vec<_> =
            sphere(20, 30).positions().iter().map(|p| [p[0], p[1] + p[0] * phase.sin() * 0.1, p[2]]).collect();
        stage.scene.set_positions(stage.oak, &bent).unwrap();
        let view = stage.scene.commit();
        sizes.push((view.report().allocated, view.report().memory));
    }
    assert!(sizes[5..].iter().all(|(allocated, _)| *allocated == 0), "{sizes:?}");
    assert_eq!(sizes[10].1, sizes[29].1);
}

#[test]
fn a_held_snapshot_makes_the_commit_allocate_and_the_report_says_so() {
    let mut stage = stage();
    let mut held = Vec::new();
    for frame in 0..6 {
        stage.scene.pose(stage.flag, &Pose { weights: &[frame as f32 * 0.1], joints: &[] }).unwrap();
        held.push(stage.scene.commit());
    }
    // A frame, and the flag; before, everything once.
    let allocated: Vec<_> = held.iter().map(|view| view.report().allocated).collect();
    assert_eq!(allocated[1..], [2; 5]);
    drop(held);
    let after = (0..3).map(|frame| {
        stage.scene.pose(stage.flag, &Pose { weights: &[frame as f32], joints: &[] }).unwrap();
        stage.scene.commit().report().allocated
    });
    assert_eq!(after.collect::<Vec<_>>(), [0; 3], "buffers that no snapshot holds are used again");
}

#[test]
fn the_same_edits_give_the_same_trees_for_any_number_of_threads() {
    let views = [kinetree::Threads::one(), kinetree::Threads::default()].map(|threads| {
        let mut scene = Scene::with_threads(threads);
        let mut random = Random::new(8);
        let mesh = scene.add_mesh(random.soup(60_000, 9.0, 0.3), Motion::Deforming).unwrap();
        for _ in 0..700 {
            let place = random.placement(50.0);
            scene.add_instance(scene.root(), mesh, place).unwrap();
        }
        scene.commit();
        let moved: Vec<_> = (0..180_000).map(|_| random.point(9.0)).collect();
        scene.set_positions(mesh, &moved).unwrap();
        scene.commit()
    });
    let [one, many] = &views;
    let leaves = |view: &Snapshot| -> Vec<u32> {
        view.instance_at(0).bvh().blocks().iter().flat_map(|block| block.primitives()).copied().collect()
    };
    assert_eq!(one.top_level().tree().nodes(), many.top_level().tree().nodes());
    assert_eq!(one.instance_at(0).bvh().tree().nodes(), many.instance_at(0).bvh().tree().nodes());
    assert_eq!(leaves(one), leaves(many));
}
