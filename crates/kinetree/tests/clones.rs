//! What clones of a mesh share, and that normals change without trees.

mod common;

use common::{grid, sphere};
use kinetree::build::{BuildOptions, Quality};
use kinetree::{Action, Affine, Mesh, MeshBvh, MeshId, Motion, Pose, Precision, Ray, Reason, Scene, Skin, Snapshot};

const MOTIONS: [Motion; 4] = [Motion::Static, Motion::Rigid, Motion::Deforming, Motion::Dynamic];

fn shown(scene: &mut Scene, mesh: &Mesh, motion: Motion) -> MeshId {
    let id = scene.add_mesh(mesh.clone(), motion).unwrap();
    scene.add_instance(scene.root(), id, Affine::IDENTITY).unwrap();
    id
}

fn tree(view: &Snapshot, at: u32) -> &MeshBvh {
    view.instance_at(at).bvh()
}

#[test]
fn clones_share_the_tree_of_the_rest_pose_whatever_their_motion() {
    for motion in MOTIONS {
        let mesh = sphere(20, 30);
        let (mut one, mut other) = (Scene::new(), Scene::new());
        let clones = [(); 3].map(|()| shown(&mut one, &mesh, motion));
        shown(&mut other, &mesh, motion);
        let (view, elsewhere) = (one.commit(), other.commit());
        assert_eq!(view.report().count(Action::Built), 3);
        for at in 1..3 {
            assert!(std::ptr::eq(tree(&view, 0), tree(&view, at)), "{motion:?}");
        }
        assert!(std::ptr::eq(tree(&view, 0), tree(&elsewhere, 0)), "{motion:?}, in another scene");

        // One moves; the others, and the other scene, stay.
        let moved: Vec<_> = mesh.positions().iter().map(|p| [p[0] + 5.0, p[1], p[2]]).collect();
        for round in 0..3 {
            one.set_positions(clones[1], &moved).unwrap();
            let view = one.commit();
            assert!(std::ptr::eq(tree(&view, 0), tree(&view, 2)), "{motion:?}, {round}");
            assert!(std::ptr::eq(tree(&view, 0), tree(&elsewhere, 0)), "{motion:?}, {round}");
            assert_eq!(view.instance_at(1).positions(), moved);
            assert_eq!(view.instance_at(0).positions(), mesh.positions());
            view.instances().for_each(|instance| assert_eq!(instance.bvh().validate(), Ok(())));
        }
    }
}

#[test]
fn a_shared_tree_is_built_at_the_quality_and_precision_of_each_clone() {
    let mesh = sphere(20, 30);
    let mut scene = Scene::new();
    for motion in [Motion::Static, Motion::Rigid, Motion::Static, Motion::Rigid] {
        shown(&mut scene, &mesh, motion);
    }
    shown(&mut scene, &mesh.clone().with_precision(Precision::Fast), Motion::Static);
    let view = scene.commit();
    let same = |one: u32, other: u32| std::ptr::eq(tree(&view, one), tree(&view, other));
    assert!(same(0, 2) && same(1, 3) && !same(0, 1) && !same(0, 4));
    let mut alone = Scene::new();
    shown(&mut alone, &sphere(20, 30), Motion::Static);
    assert_eq!(tree(&alone.commit(), 0).tree().nodes(), tree(&view, 0).tree().nodes());
}

#[test]
fn clones_share_a_tree_that_was_baked() {
    let mut options = BuildOptions::default();
    options.quality = Quality::Best;
    let mesh = sphere(20, 30);
    let baked = mesh.clone().with_tree(&mesh.bake(&options)).unwrap();
    for motion in MOTIONS {
        let mut scene = Scene::new();
        for _ in 0..3 {
            shown(&mut scene, &baked, motion);
        }
        shown(&mut scene, &baked.clone().with_precision(Precision::Fast), motion);
        let view = scene.commit();
        assert_eq!(view.report().count(Action::Loaded), 4);
        assert!(std::ptr::eq(tree(&view, 0), tree(&view, 1)) && std::ptr::eq(tree(&view, 0), tree(&view, 2)));
        assert!(!std::ptr::eq(tree(&view, 0), tree(&view, 3)), "tested in another way");
    }
}

#[test]
fn what_clones_share_is_counted_once() {
    let memory = |clones: usize| {
        let mesh = sphere(40, 60).with_normals(sphere(40, 60).positions()).unwrap();
        let mut scene = Scene::new();
        for _ in 0..clones {
            shown(&mut scene, &mesh, Motion::Static);
        }
        let _kept = mesh;
        scene.commit().report().memory
    };
    assert!(memory(50) < 2 * memory(1), "{} and {}", memory(50), memory(1));
}

#[test]
fn normals_never_touch_a_tree() {
    for motion in MOTIONS {
        let mesh = grid(8, 4.0);
        let up = vec![[0.0, 1.0, 0.0]; mesh.positions().len()];
        let aside = vec![[1.0, 0.0, 0.0]; up.len()];
        let mut scene = Scene::new();
        let id = shown(&mut scene, &mesh.with_normals(&up).unwrap(), motion);
        let bent: Vec<_> = grid(8, 4.0).positions().iter().map(|p| [p[0], p[0] * 0.1, p[2]]).collect();
        scene.commit();
        scene.set_positions(id, &bent).unwrap();
        let before = scene.commit();
        scene.set_normals(id, &aside).unwrap();
        let after = scene.commit();
        let report = &after.report().meshes[0];
        assert_eq!((report.action, report.reason), (Action::Kept, Reason::NormalsChanged), "{motion:?}");
        assert_eq!(report.tree_time, None);
        assert!(std::ptr::eq(tree(&before, 0), tree(&after, 0)), "{motion:?}");
        assert_eq!(before.instance_at(0).normals(), Some(&up[..]));
        assert_eq!(after.instance_at(0).normals(), Some(&aside[..]));
        // They stay when the vertices move, and go with the triangles.
        scene.set_positions(id, grid(8, 4.0).positions()).unwrap();
        let moved = scene.commit();
        assert_eq!(moved.instance_at(0).normals(), Some(&aside[..]));
        scene.set_triangles(id, grid(2, 1.0).positions(), grid(2, 1.0).triangles()).unwrap();
        assert_eq!(scene.commit().instance_at(0).normals(), None);
        assert_eq!(moved.instance_at(0).normals(), Some(&aside[..]));
        scene.set_normals(id, &up[..9]).unwrap();
        assert_eq!(scene.commit().instance_at(0).normals(), Some(&up[..9]));
    }
}

#[test]
fn a_pose_that_is_not_finite_costs_neither_buffers_nor_other_edits() {
    let mesh = grid(8, 4.0);
    let count = mesh.positions().len();
    let skin = Skin { joints: vec![[0, 1, 0, 0]; count], weights: vec![[1.0, 1.0, 0.0, 0.0]; count] };
    let (up, aside) = (vec![[0.0, 1.0, 0.0]; count], vec![[1.0, 0.0, 0.0]; count]);
    let mesh = mesh.with_normals(&up).unwrap().with_skin(skin).unwrap();
    let at = |height: f32| [Affine::from_translation([0.0, height, 0.0]), Affine::from_scale([0.0; 3])];
    let beyond = [Affine::from_scale([3e38; 3]); 2];
    let mut scene = Scene::new();
    let id = shown(&mut scene, &mesh, Motion::Deforming);
    for frame in 0..4 {
        scene.pose(id, &Pose { weights: &[], joints: &at(frame as f32) }).unwrap();
        drop(scene.commit());
    }
    let before = scene.commit();
    let memory = before.report().memory;
    scene.pose(id, &Pose { weights: &[], joints: &beyond }).unwrap();
    scene.set_normals(id, &aside).unwrap();
    let view = scene.commit();
    let did = |view: &Snapshot| (view.report().meshes[0].action, view.report().meshes[0].reason);
    assert_eq!(did(&view), (Action::Kept, Reason::PoseNotFinite));
    assert!(std::ptr::eq(tree(&before, 0), tree(&view, 0)));
    assert_eq!(view.instance_at(0).positions(), before.instance_at(0).positions());
    assert_eq!(view.instance_at(0).normals(), Some(&aside[..]), "accepted in the same frame");
    drop((before, view));
    for frame in 0..4 {
        scene.pose(id, &Pose { weights: &[], joints: &beyond }).unwrap();
        assert_eq!(did(&scene.commit()), (Action::Kept, Reason::PoseNotFinite));
        scene.pose(id, &Pose { weights: &[], joints: &at(frame as f32) }).unwrap();
        let view = scene.commit();
        assert!(!view.report().meshes[0].allocated, "frame {frame}");
        let height = view.position(&view.closest_hit(&Ray::new([1.1, 50.0, 1.2], [0.0, -1.0, 0.0])).unwrap())[1];
        assert!((height - frame as f32).abs() < 1e-4, "{height}");
        assert!(view.report().memory <= memory + 2 * count * 12, "{} after {memory}", view.report().memory);
    }

    // A rebuild that was asked for is made all the same; and a first commit shows the rest pose.
    scene.pose(id, &Pose { weights: &[], joints: &beyond }).unwrap();
    scene.rebuild(id).unwrap();
    assert_eq!(did(&scene.commit()), (Action::Rebuilt, Reason::PoseNotFinite));
    let mut fresh = Scene::new();
    let id = shown(&mut fresh, &mesh, Motion::Deforming);
    fresh.pose(id, &Pose { weights: &[], joints: &beyond }).unwrap();
    fresh.set_normals(id, &aside).unwrap();
    let view = fresh.commit();
    assert_eq!(did(&view), (Action::Built, Reason::PoseNotFinite));
    assert_eq!(view.instance_at(0).positions(), mesh.positions());
    assert_eq!(view.instance_at(0).normals(), Some(&aside[..]));
}
