//! Trees that were built before: scenes take them instead of building, say so, and go on as usual.

mod common;

use common::{Random, World, cube, grid, rays, sphere};
use kinetree::build::{BuildOptions, Quality};
use kinetree::wide::TreeFileError;
use kinetree::{Action, Affine, EditError, Mesh, MorphTarget, Motion, Pose, Reason, Scene, Snapshot};

const QUALITIES: [Quality; 4] = [Quality::Fastest, Quality::Fast, Quality::Balanced, Quality::Best];

fn options(quality: Quality) -> BuildOptions {
    let mut options = BuildOptions::default();
    options.quality = quality;
    options
}

fn did(view: &Snapshot) -> Vec<(Action, Reason)> {
    view.report().meshes.iter().map(|mesh| (mesh.action, mesh.reason)).collect()
}

fn assert_same_trees(one: &Snapshot, other: &Snapshot) {
    assert_eq!(one.instances().len(), other.instances().len());
    for (one, other) in one.instances().zip(other.instances()) {
        assert_eq!(one.bvh().tree().nodes(), other.bvh().tree().nodes());
        assert_eq!(format!("{:?}", one.bvh().blocks()), format!("{:?}", other.bvh().blocks()));
    }
}

#[test]
fn a_loaded_tree_is_the_one_that_would_have_been_built() {
    let soup = Random::new(3).soup(900, 2.0, 0.9);
    for quality in QUALITIES {
        for motion in [Motion::Static, Motion::Rigid, Motion::Deforming, Motion::Dynamic] {
            let view_of = |mesh: Mesh| {
                let mut scene = Scene::new();
                let mesh = scene.add_mesh(mesh, motion).unwrap();
                scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
                scene.commit()
            };
            let built = view_of(soup.clone().with_quality(quality));
            let loaded = view_of(soup.clone().with_tree(&soup.bake(&options(quality))).unwrap());
            assert_eq!(did(&built), [(Action::Built, Reason::New)]);
            assert_eq!(did(&loaded), [(Action::Loaded, Reason::New)]);
            assert!(loaded.report().to_string().contains("0 built, 1 loaded"), "{}", loaded.report());
            assert_same_trees(&built, &loaded);
            let world = World { name: format!("{quality:?}"), view: built.clone(), size: 2.0 };
            for ray in rays(&world, 500, &mut Random::new(4)) {
                assert_eq!(loaded.query().all_hits(&ray), built.query().all_hits(&ray), "{ray:?}");
                assert_eq!(loaded.closest_hit(&ray), built.closest_hit(&ray), "{ray:?}");
            }
        }
    }
}

#[test]
fn a_scene_goes_on_from_a_loaded_tree_as_from_a_built_one() {
    let ball = sphere(20, 30);
    let scenes = [false, true].map(|loads| {
        let mut scene = Scene::new();
        for motion in [Motion::Static, Motion::Rigid, Motion::Deforming, Motion::Dynamic] {
            let mesh = scene.add_mesh(ball.clone().with_quality(Quality::Fast), motion).unwrap();
            scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
            if loads {
                scene.set_tree(mesh, &ball.bake(&options(Quality::Fast))).unwrap();
            }
        }
        scene
    });
    let [mut built, mut loaded] = scenes;
    assert_eq!(did(&built.commit()), [(Action::Built, Reason::New); 4]);
    assert_eq!(did(&loaded.commit()), [(Action::Loaded, Reason::New); 4]);
    let bent: Vec<_> = ball.positions().iter().map(|p| [p[0] + 0.2 * p[1], p[1], p[2]]).collect();
    let torn: Vec<_> = {
        let mut random = Random::new(1);
        bent.iter().map(|_| random.point(1.0)).collect()
    };
    for positions in [&bent, &torn] {
        let views = [&mut built, &mut loaded].map(|scene| {
            let meshes: Vec<_> = scene.meshes().collect();
            meshes.iter().for_each(|&mesh| scene.set_positions(mesh, positions).unwrap());
            scene.commit()
        });
        assert_eq!(did(&views[0]), did(&views[1]));
        assert!(!did(&views[1]).iter().any(|(action, _)| *action == Action::Loaded));
        assert_same_trees(&views[0], &views[1]);
    }
}

#[test]
fn other_triangles_may_bring_their_tree() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(cube(), Motion::Static).unwrap();
    scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
    scene.commit();
    assert_eq!(scene.set_tree(mesh, &cube().bake(&options(Quality::Best))), Err(EditError::HasTree));
    let ball = sphere(8, 9);
    scene.set_triangles(mesh, ball.positions(), ball.triangles()).unwrap();
    scene.set_tree(mesh, &ball.bake(&options(Quality::Best))).unwrap();
    let view = scene.commit();
    assert_eq!(did(&view), [(Action::Loaded, Reason::TrianglesChanged)]);
    assert_eq!(view.instance_at(0).bvh().validate(), Ok(()));
    assert_eq!(did(&scene.commit()), [(Action::Kept, Reason::NothingChanged)]);
}

#[test]
fn what_moved_before_the_first_commit_does_not_keep_boxes_of_the_rest_pose() {
    let ball = sphere(10, 12);
    let moved: Vec<_> = ball.positions().iter().map(|p| [p[0] + 3.0, p[1] * 2.0, p[2]]).collect();
    let expected = [Motion::Static, Motion::Deforming]
        .map(|motion| if motion == Motion::Static { Action::Built } else { Action::Loaded });
    for (motion, expected) in [Motion::Static, Motion::Deforming].into_iter().zip(expected) {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(ball.clone(), motion).unwrap();
        scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
        scene.set_tree(mesh, &ball.bake(&options(Quality::Best))).unwrap();
        scene.set_positions(mesh, &moved).unwrap();
        let view = scene.commit();
        assert_eq!(did(&view)[0].0, expected);
        assert_eq!(view.instance_at(0).bvh().validate(), Ok(()));
        let world = World { name: "moved".into(), view, size: 3.0 };
        for ray in rays(&world, 1000, &mut Random::new(5)) {
            let (query, twin) = (world.view.query(), world.view.query().brute_force());
            assert_eq!(query.all_hits(&ray), twin.all_hits(&ray), "{motion:?}, {ray:?}");
        }
    }
}

#[test]
fn clones_that_bend_share_a_tree_that_was_handed_over() {
    let cloth = grid(12, 3.0);
    let lift = MorphTarget { positions: vec![[0.0, 1.0, 0.0]; cloth.positions().len()], normals: vec![] };
    let tree = cloth.bake(&options(Quality::Fast));
    let cloth = cloth.with_morph_targets(vec![lift]).unwrap().with_tree(&tree).unwrap();
    let mut scene = Scene::new();
    for i in 0..3 {
        let mesh = scene.add_mesh(cloth.clone(), Motion::Deforming).unwrap();
        scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
        scene.pose(mesh, &Pose { weights: &[i as f32], joints: &[] }).unwrap();
    }
    let view = scene.commit();
    assert_eq!(did(&view), [(Action::Loaded, Reason::New); 3]);
    for (instance, height) in view.instances().zip(0..) {
        assert_eq!(instance.bvh().validate(), Ok(()));
        assert!(instance.positions().iter().all(|p| p[1] == height as f32));
    }
}

#[test]
fn a_tree_that_does_not_fit_is_refused_and_leaves_the_scene_as_it_was() {
    let bytes = cube().bake(&options(Quality::Best));
    assert_eq!(sphere(4, 5).with_tree(&bytes).err(), Some(TreeFileError::OtherMesh));
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(sphere(4, 5), Motion::Static).unwrap();
    scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
    let error = scene.set_tree(mesh, &bytes).unwrap_err();
    assert_eq!(error, EditError::Tree(TreeFileError::OtherMesh));
    assert!(error.to_string().contains("bake it again"), "{error}");
    let mut damaged = sphere(4, 5).bake(&options(Quality::Best));
    damaged[100] ^= 4;
    assert_eq!(scene.set_tree(mesh, &damaged), Err(EditError::Tree(TreeFileError::Damaged)));
    assert_eq!(did(&scene.commit()), [(Action::Built, Reason::New)]);
}

#[test]
fn the_fingerprint_is_one_of_positions_and_triangles_alone() {
    let mesh = cube();
    let count = mesh.positions().len();
    let dressed = mesh.clone().with_normals(&vec![[0.0, 1.0, 0.0]; count]).unwrap().with_quality(Quality::Best);
    assert_eq!(dressed.fingerprint(), mesh.fingerprint());
    assert_ne!(mesh.fingerprint(), sphere(4, 5).fingerprint());
    assert_ne!(mesh.fingerprint(), Mesh::empty().fingerprint());
    let empty = Mesh::empty().with_tree(&Mesh::empty().bake(&options(Quality::Best))).unwrap();
    assert_eq!(did(&common::alone(empty)), [(Action::Loaded, Reason::New)]);
}
