//! Motion, quality and precision of a mesh that is already in the scene: the next commit acts on
//! them.

mod common;

use common::{grid, sphere};
use kinetree::{Action, Affine, EditError, MeshId, Motion, Precision, Quality, Ray, Reason, Scene, Snapshot};

fn with(motion: Motion) -> (Scene, MeshId) {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(sphere(24, 32), motion).unwrap();
    scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
    (scene, mesh)
}

fn done(view: &Snapshot) -> (Action, Reason) {
    let report = &view.report().meshes[0];
    (report.action, report.reason)
}

fn tree_of(mesh: kinetree::Mesh, motion: Motion, quality: Quality) -> Vec<u8> {
    let mut scene = Scene::new();
    let id = scene.add_mesh(mesh.with_quality(quality), motion).unwrap();
    bytes(&scene.commit(), id)
}

/// The tree of a mesh, to be compared with another one.
fn bytes(view: &Snapshot, mesh: MeshId) -> Vec<u8> {
    let mesh = view.mesh(mesh).unwrap();
    let triangles = kinetree::geometry::Triangles::new(mesh.positions().to_vec(), mesh.triangles().into());
    mesh.bvh().to_bytes(&triangles.unwrap())
}

fn squeezed(view: &Snapshot, by: f32) -> Vec<[f32; 3]> {
    view.instance_at(0).positions().iter().map(|&[x, y, z]| [x, y * by, z]).collect()
}

#[test]
fn a_better_quality_is_built_by_the_next_commit_and_a_lower_one_leaves_the_tree() {
    let (mut scene, mesh) = with(Motion::Dynamic);
    let view = scene.commit();
    assert_eq!(bytes(&view, mesh), tree_of(sphere(24, 32), Motion::Dynamic, Quality::Fastest));
    for quality in [Quality::Fast, Quality::Balanced, Quality::Best] {
        scene.set_quality(mesh, quality).unwrap();
        assert_eq!(scene.quality(mesh), Ok(quality));
        let view = scene.commit();
        assert_eq!(done(&view), (Action::Rebuilt, Reason::QualityRaised), "{quality:?}");
        assert_eq!(bytes(&view, mesh), tree_of(sphere(24, 32), Motion::Dynamic, quality), "{quality:?}");
        assert_eq!(done(&scene.commit()), (Action::Kept, Reason::NothingChanged), "{quality:?}");
    }
    scene.set_quality(mesh, None).unwrap();
    assert_eq!(scene.quality(mesh), Ok(Quality::Fastest));
    let view = scene.commit();
    assert_eq!(done(&view), (Action::Kept, Reason::NothingChanged));
    assert_eq!(bytes(&view, mesh), tree_of(sphere(24, 32), Motion::Dynamic, Quality::Best));
    scene.rebuild(mesh).unwrap();
    assert_eq!(bytes(&scene.commit(), mesh), tree_of(sphere(24, 32), Motion::Dynamic, Quality::Fastest));
}

#[test]
fn quality_and_precision_outlive_other_triangles() {
    let (mut scene, mesh) = with(Motion::Dynamic);
    scene.set_quality(mesh, Quality::Balanced).unwrap();
    scene.set_precision(mesh, Precision::Fast).unwrap();
    scene.commit();
    let other = grid(9, 4.0);
    scene.set_triangles(mesh, other.positions(), other.triangles()).unwrap();
    let view = scene.commit();
    assert_eq!(done(&view), (Action::Rebuilt, Reason::TrianglesChanged));
    assert_eq!(view.mesh(mesh).unwrap().precision(), Precision::Fast);
    assert_eq!(bytes(&view, mesh), tree_of(other, Motion::Dynamic, Quality::Balanced));
}

#[test]
fn another_motion_changes_what_moving_does() {
    let (mut scene, mesh) = with(Motion::Rigid);
    let view = scene.commit();
    scene.set_positions(mesh, &squeezed(&view, 0.9)).unwrap();
    assert_eq!(done(&scene.commit()), (Action::Rebuilt, Reason::NotMadeForRefit));

    scene.set_motion(mesh, Motion::Deforming).unwrap();
    assert_eq!(scene.motion(mesh), Ok(Motion::Deforming));
    let view = scene.commit();
    assert_eq!(done(&view), (Action::Kept, Reason::NothingChanged), "both are built alike");
    assert_eq!(view.instance_at(0).motion(), Motion::Deforming);
    scene.set_positions(mesh, &squeezed(&view, 0.99)).unwrap();
    let view = scene.commit();
    assert_eq!(done(&view), (Action::Refitted, Reason::PositionsMoved));
    // Drift is measured from the tree that was there when the motion was announced.
    assert!((view.report().meshes[0].drift - 1.0).abs() < 0.1);
    assert_eq!(view.instance_at(0).bvh().validate(), Ok(()));

    scene.set_motion(mesh, Motion::Static).unwrap();
    let view = scene.commit();
    assert_eq!(done(&view), (Action::Rebuilt, Reason::QualityRaised), "scenery has better trees");
    scene.set_motion(mesh, Motion::Deforming).unwrap();
    scene.set_positions(mesh, &squeezed(&view, 0.98)).unwrap();
    assert_eq!(done(&scene.commit()).0, Action::Refitted, "a better tree is kept");
    scene.set_motion(mesh, Motion::Dynamic).unwrap();
    scene.set_positions(mesh, &squeezed(&view, 0.97)).unwrap();
    assert_eq!(done(&scene.commit()), (Action::Rebuilt, Reason::NotMadeForRefit));
}

#[test]
fn precision_changes_without_the_tree() {
    let (mut scene, mesh) = with(Motion::Rigid);
    let before = scene.commit();
    scene.set_precision(mesh, Precision::Fast).unwrap();
    assert_eq!(scene.precision(mesh), Ok(Precision::Fast));
    let after = scene.commit();
    assert_eq!(done(&after), (Action::Kept, Reason::PrecisionChanged));
    assert_eq!(before.mesh(mesh).unwrap().precision(), Precision::Watertight, "snapshots never change");
    assert_eq!(after.mesh(mesh).unwrap().precision(), Precision::Fast);
    assert_eq!(bytes(&before, mesh), bytes(&after, mesh));
    let ray = Ray::new([0.1, 0.2, 9.0], [0.0, 0.0, -1.0]);
    let [t, fast] = [&before, &after].map(|view| view.closest_hit(&ray).unwrap().t);
    assert!((t - fast).abs() < 1e-4);
    assert_eq!(done(&scene.commit()), (Action::Kept, Reason::NothingChanged));
    scene.set_precision(mesh, Precision::Watertight).unwrap();
    assert_eq!(scene.commit().closest_hit(&ray).map(|hit| hit.t), Some(t));
}

#[test]
fn clones_and_baked_trees_take_the_precision_of_their_scene() {
    let ball = sphere(24, 32);
    let baked = ball.clone().with_tree(&ball.bake(&kinetree::BuildOptions::new())).unwrap();
    let mut scene = Scene::new();
    let [plain, fast] = [(); 2].map(|()| scene.add_mesh(ball.clone(), Motion::Rigid).unwrap());
    let given = scene.add_mesh(baked, Motion::Static).unwrap();
    scene.set_precision(fast, Precision::Fast).unwrap();
    scene.set_precision(given, Precision::Fast).unwrap();
    let view = scene.commit();
    let precisions = [plain, fast, given].map(|mesh| view.mesh(mesh).unwrap().precision());
    assert_eq!(precisions, [Precision::Watertight, Precision::Fast, Precision::Fast]);
    assert_eq!(view.report().meshes[2].action, Action::Loaded);
    assert_eq!(bytes(&view, plain), bytes(&view, fast));
    // A baked tree counts as the best there is.
    assert_eq!(scene.set_quality(given, Quality::Best), Ok(()));
    assert_eq!(scene.commit().report().meshes[2].action, Action::Kept);
}

#[test]
fn normals_of_replaced_triangles_are_gone_even_if_the_new_ones_are_posed() {
    let (mut scene, mesh) = with(Motion::Dynamic);
    scene.set_normals(mesh, &vec![[0.0, 0.0, 1.0]; sphere(24, 32).positions().len()]).unwrap();
    assert!(scene.commit().mesh(mesh).unwrap().normals().is_some());
    scene.set_triangles(mesh, &[[0.0; 3]; 3], &[[0, 1, 2]]).unwrap();
    scene.pose(mesh, &kinetree::Pose::default()).unwrap();
    assert!(scene.commit().mesh(mesh).unwrap().normals().is_none());
}

#[test]
fn settings_of_a_removed_mesh_are_refused() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(grid(2, 1.0), Motion::Static).unwrap();
    scene.remove_mesh(mesh).unwrap();
    let stale = Err(EditError::StaleHandle);
    assert_eq!(scene.set_motion(mesh, Motion::Rigid), stale);
    assert_eq!(scene.set_quality(mesh, Quality::Fast), stale);
    assert_eq!(scene.set_precision(mesh, Precision::Fast), stale);
    assert_eq!(scene.quality(mesh), Err(EditError::StaleHandle));
    assert_eq!(scene.precision(mesh), Err(EditError::StaleHandle));
}
