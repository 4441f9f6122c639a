//! What edits do, what they refuse, and that a refused edit leaves the scene as it was.

mod common;

use common::{Random, cube, grid, sphere};
use kinetree::{
    Action, Affine, EditError, Mesh, MeshError, MorphTarget, Motion, Pose, Positions, Ray, Reason, Scene, Skin,
    Snapshot, TopLevelMethod,
};

const DOWN: [f32; 3] = [0.0, -1.0, 0.0];

fn height(view: &Snapshot, x: f32, z: f32) -> Option<f32> {
    view.closest_hit(&Ray::new([x, 100.0, z], DOWN)).map(|hit| view.position(&hit)[1])
}

#[test]
fn bad_meshes_are_refused_by_name() {
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let refused = |mesh: Result<Mesh, MeshError>| mesh.unwrap_err();
    assert_eq!(
        refused(Mesh::new(&points, &[0_u32, 1, 2, 0, 3, 1])),
        MeshError::IndexOutOfRange { triangle: 1, index: 3, vertices: 3 }
    );
    assert_eq!(refused(Mesh::new(&points, &[0_u16, 1])), MeshError::NotWholeTriangles { count: 2 });
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let spoilt = [[0.0; 3], [1.0, bad, 0.0]];
        assert_eq!(refused(Mesh::new(&spoilt, &[[0, 1, 1]])), MeshError::NonFinite { at: 1 });
    }
    let mesh = Mesh::new(&points, &[0_u16, 1, 2]).unwrap();
    assert!(matches!(refused(mesh.clone().with_normals(&points[..2])), MeshError::CountDiffers { .. }));
    let skin = Skin { joints: vec![[0; 4]; 3], weights: vec![[-1.0, 0.0, 0.0, 0.0]; 3] };
    assert_eq!(refused(mesh.with_skin(skin)), MeshError::NegativeWeight { at: 0 });
}

#[test]
fn strides_are_read_and_checked() {
    let mut bytes = vec![7_u8; 5];
    for vertex in [[0.0_f32, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]] {
        vertex.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend([0; 6]);
    }
    let strided = |offset, stride, count| Positions::Strided { bytes: &bytes, offset, stride, count };
    let mesh = Mesh::new(strided(5, 18, 3), &[0_u32, 1, 2]).unwrap();
    assert_eq!(mesh.positions(), [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]]);
    for (offset, stride, count) in
        [(6, 25, 3), (5, usize::MAX, 3), (usize::MAX, 18, 1), (5, 18, usize::MAX), (50, 18, 1)]
    {
        assert!(matches!(
            Mesh::new(strided(offset, stride, count), &[] as &[u32]),
            Err(MeshError::StrideOutOfRange { .. })
        ));
    }
    assert!(Mesh::new(strided(usize::MAX, usize::MAX, 0), &[] as &[u32]).is_ok());
}

#[test]
fn bad_edits_are_refused_and_change_nothing() {
    let mut scene = Scene::new();
    let root = scene.root();
    let mesh = scene.add_mesh(grid(2, 4.0), Motion::Deforming).unwrap();
    let node = scene.add_node(root, Affine::from_translation([0.0, 1.0, 0.0])).unwrap();
    let instance = scene.add_instance(node, mesh, Affine::IDENTITY).unwrap();
    let nan = Affine::from_translation([f32::NAN, 0.0, 0.0]);

    assert_eq!(scene.place(node, nan), Err(EditError::NonFinite { at: 0 }));
    assert_eq!(scene.place(instance, nan), Err(EditError::NonFinite { at: 0 }));
    assert_eq!(scene.place(root, Affine::IDENTITY), Err(EditError::Root));
    assert_eq!(scene.remove_node(root), Err(EditError::Root));
    assert!(scene.add_node(root, nan).is_err() && scene.add_instance(root, mesh, nan).is_err());
    assert_eq!(scene.set_positions(mesh, &[[0.0; 3]]), Err(EditError::PositionCountChanged { expected: 9, found: 1 }));
    assert_eq!(
        scene.set_positions(mesh, &[[f32::INFINITY; 3]; 9]),
        Err(EditError::Mesh(MeshError::NonFinite { at: 0 }))
    );
    assert!(scene.set_triangles(mesh, &[[0.0; 3]], &[[0, 0, 1]]).is_err());
    assert!(scene.pose(mesh, &Pose { weights: &[1.0], joints: &[] }).is_err());
    assert_eq!(scene.remove_mesh(mesh), Err(EditError::MeshInUse { instances: 1 }));

    let mut other = Scene::new();
    let foreign = other.add_mesh(Mesh::empty(), Motion::Static).unwrap();
    assert_eq!(scene.add_instance(root, foreign, Affine::IDENTITY), Err(EditError::OtherScene));
    assert_eq!(scene.set_positions(foreign, &[[0.0; 3]]), Err(EditError::OtherScene));
    assert_eq!(scene.add_node(other.root(), Affine::IDENTITY), Err(EditError::OtherScene));

    let view = scene.commit();
    assert_eq!(height(&view, 1.0, 1.0), Some(1.0));
    assert_eq!(view.instances().len(), 1);

    scene.remove_node(node).unwrap();
    for error in [
        scene.place(node, Affine::IDENTITY),
        scene.place(instance, Affine::IDENTITY),
        scene.set_mask(instance, 1),
        scene.set_opaque(instance, true),
        scene.remove_instance(instance),
        scene.remove_node(node),
        scene.world_from_node(node).map(drop),
    ] {
        assert_eq!(error, Err(EditError::StaleHandle));
    }
    assert_eq!(scene.remove_mesh(mesh), Ok(()));
    assert_eq!(scene.remove_mesh(mesh), Err(EditError::StaleHandle));
    assert_eq!(scene.commit().instances().len(), 0);
}

#[test]
fn children_follow_their_parents_and_go_with_them() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(grid(1, 1.0), Motion::Rigid).unwrap();
    let car = scene.add_node(scene.root(), Affine::from_translation([10.0, 0.0, 0.0])).unwrap();
    let wheel = scene.add_node(car, Affine::from_translation([0.0, 2.0, 0.0])).unwrap();
    scene.add_instance(wheel, mesh, Affine::from_translation([0.0, 0.5, 0.0])).unwrap();
    assert_eq!(height(&scene.commit(), 10.3, 0.3), Some(2.5));
    scene.place(car, Affine::from_translation([-10.0, 1.0, 0.0])).unwrap();
    assert_eq!(scene.world_from_node(wheel).unwrap().translation, [-10.0, 3.0, 0.0]);
    let view = scene.commit();
    assert_eq!((height(&view, 10.3, 0.3), height(&view, -9.7, 0.3)), (None, Some(3.5)));
    scene.remove_node(car).unwrap();
    assert_eq!(scene.commit().instances().len(), 0);
}

#[test]
fn a_chain_of_a_hundred_thousand_nodes_is_no_problem() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(grid(1, 1.0), Motion::Rigid).unwrap();
    let first = scene.add_node(scene.root(), Affine::IDENTITY).unwrap();
    let mut last = first;
    for _ in 0..100_000 {
        last = scene.add_node(last, Affine::from_translation([0.0, 0.125, 0.0])).unwrap();
    }
    scene.add_instance(last, mesh, Affine::IDENTITY).unwrap();
    assert_eq!(height(&scene.commit(), 0.3, 0.3), None, "it stands 12.5 km up, above the probe");
    scene.place(first, Affine::from_translation([0.0, -12_490.0, 0.0])).unwrap();
    assert_eq!(height(&scene.commit(), 0.3, 0.3), Some(10.0));
    scene.remove_node(first).unwrap();
    assert_eq!(scene.commit().instances().len(), 0);
}

#[test]
fn placements_that_are_lines_or_overflow_are_left_out_and_listed() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(cube(), Motion::Rigid).unwrap();
    let flat = scene.add_instance(scene.root(), mesh, Affine::from_scale([1.0, 0.0, 1.0])).unwrap();
    let line = scene.add_instance(scene.root(), mesh, Affine::from_scale([0.0, 0.0, 1.0])).unwrap();
    let big = scene.add_node(scene.root(), Affine::from_scale([1e30; 3])).unwrap();
    let overflowing = scene.add_instance(big, mesh, Affine::from_scale([1e30; 3])).unwrap();
    let fine = scene.add_instance(scene.root(), mesh, Affine::from_translation([3.0, 0.0, 0.0])).unwrap();
    let view = scene.commit();
    assert_eq!(view.report().left_out, [line, overflowing]);
    assert_eq!(view.instances().map(|instance| instance.id()).collect::<Vec<_>>(), [flat, fine]);
    assert_eq!(height(&view, 0.1, 0.2), Some(0.0));
    scene.place(line, Affine::from_translation([0.0, 5.0, 0.0])).unwrap();
    let view = scene.commit();
    assert_eq!(view.report().left_out, [overflowing]);
    assert_eq!(height(&view, 0.1, 0.2), Some(6.0));
}

#[test]
fn mirrored_and_stretched_placements_keep_their_sides_and_normals() {
    for scale in [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [2.0, -0.5, 3.0], [-1.0, -2.0, -0.3]] {
        let view = common::placed(
            sphere(16, 24),
            &[Affine::from_axis_angle([1.0, 1.0, 0.0], 0.7) * Affine::from_scale(scale)],
        );
        let mut random = Random::new(3);
        for _ in 0..300 {
            let outwards = random.direction();
            let hit = view.closest_hit(&Ray::new(outwards.map(|x| x * 9.0), outwards.map(|x| -x))).unwrap();
            assert!(!hit.is_back_face(), "outside stays outside under {scale:?}");
            let (normal, place) = (view.normal(&hit), view.position(&hit));
            assert!((0..3).map(|axis| normal[axis] * place[axis]).sum::<f32>() > 0.0, "normals look outwards");
            assert!((normal.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5);
            let inside = view.closest_hit(&Ray::new([0.0; 3], outwards)).unwrap();
            assert!(inside.is_back_face());
        }
    }
}

#[test]
fn masks_numbers_and_handles_come_back_with_hits() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(grid(1, 1.0), Motion::Static).unwrap();
    let node = scene.add_node(scene.root(), Affine::IDENTITY).unwrap();
    let low = scene.add_instance(node, mesh, Affine::IDENTITY).unwrap();
    let high = scene.add_instance(node, mesh, Affine::from_translation([0.0, 1.0, 0.0])).unwrap();
    scene.set_user_id(node, 7).unwrap();
    scene.set_user_id(high, 9).unwrap();
    scene.set_mask(high, 0b10).unwrap();
    scene.set_mask(low, 0b11).unwrap();
    let view = scene.commit();
    let ray = Ray::new([0.3, 5.0, 0.3], DOWN);
    let top = view.closest_hit(&ray).unwrap();
    assert_eq!((view.instance_id(&top), view.user_id(&top), view.mesh_id(&top)), (high, 9, mesh));
    let below = view.query().mask(0b01).closest_hit(&ray).unwrap();
    assert_eq!((view.instance_id(&below), view.user_id(&below)), (low, 7));
    scene.set_mask(node, 0b10).unwrap();
    assert!(!scene.commit().query().mask(0b01).occluded(&ray));
}

#[test]
fn filters_are_not_asked_about_opaque_instances() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(grid(1, 1.0), Motion::Static).unwrap();
    let solid = scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
    scene.set_opaque(solid, true).unwrap();
    scene.add_instance(scene.root(), mesh, Affine::from_translation([0.0, 1.0, 0.0])).unwrap();
    let view = scene.commit();
    let hit = view.query().filter(&|_| false).closest_hit(&Ray::new([0.3, 5.0, 0.3], DOWN)).unwrap();
    assert_eq!(view.instance_id(&hit), solid);
}

#[test]
fn commit_keeps_refits_or_rebuilds_and_says_why() {
    let mut scene = Scene::new();
    let meshes = [Motion::Static, Motion::Rigid, Motion::Deforming, Motion::Dynamic].map(|motion| {
        let mesh = scene.add_mesh(sphere(20, 30), motion).unwrap();
        scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
        mesh
    });
    let did = |view: &Snapshot| -> Vec<(Action, Reason)> {
        view.report().meshes.iter().map(|mesh| (mesh.action, mesh.reason)).collect()
    };
    assert_eq!(did(&scene.commit()), [(Action::Built, Reason::New); 4]);
    let view = scene.commit();
    assert_eq!(did(&view), [(Action::Kept, Reason::NothingChanged); 4]);
    assert_eq!(view.report().top_level.method, TopLevelMethod::Kept);
    let bent: Vec<_> = sphere(20, 30).positions().iter().map(|p| [p[0] + 0.2 * p[1], p[1], p[2]]).collect();
    meshes.iter().for_each(|&mesh| scene.set_positions(mesh, &bent).unwrap());
    let view = scene.commit();
    let made = (Action::Rebuilt, Reason::NotMadeForRefit);
    assert_eq!(did(&view), [made, made, (Action::Refitted, Reason::PositionsMoved), made]);
    assert_eq!(view.report().top_level.method, TopLevelMethod::Clustered);
    let mut random = Random::new(1);
    let torn: Vec<_> = bent.iter().map(|_| random.point(1.0)).collect();
    scene.set_positions(meshes[2], &torn).unwrap();
    let view = scene.commit();
    assert_eq!(did(&view)[2], (Action::Rebuilt, Reason::Drifted));
    scene.set_triangles(meshes[3], &[] as &[[f32; 3]], &[] as &[u32]).unwrap();
    let view = scene.commit();
    assert_eq!(did(&view)[3], (Action::Rebuilt, Reason::TrianglesChanged));
    assert_eq!(view.report().triangles(), 3 * sphere(20, 30).triangles().len());
    assert!(view.report().to_string().contains("1 rebuilt"));
}

#[test]
fn morph_targets_and_skins_bend_positions_and_normals() {
    // An upright strip; the upper end follows joint 1.
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 2.0, 0.0]];
    let target = MorphTarget { positions: vec![[0.0, 0.0, 1.0]; 4], normals: vec![] };
    let skin = Skin {
        joints: vec![[0, 1, 0, 0]; 4],
        weights: vec![[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0]],
    };
    let mesh = Mesh::new(&positions, &[0_u32, 1, 2, 1, 3, 2]).unwrap();
    let mesh = mesh.with_normals(&[[0.0, 0.0, 1.0]; 4]).unwrap();
    let mesh = mesh.with_morph_targets(vec![target]).unwrap().with_skin(skin).unwrap();
    let mut scene = Scene::new();
    let [one, other] = [(); 2].map(|()| {
        let id = scene.add_mesh(mesh.clone(), Motion::Deforming).unwrap();
        scene.add_instance(scene.root(), id, Affine::IDENTITY).unwrap();
        id
    });
    let turn = Affine::from_axis_angle([0.0, 1.0, 0.0], std::f32::consts::FRAC_PI_2);
    scene.pose(one, &Pose { weights: &[0.5], joints: &[Affine::IDENTITY, turn] }).unwrap();
    scene.pose(other, &Pose { weights: &[2.0], joints: &[] }).unwrap();
    let view = scene.commit();
    let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|axis| (a[axis] - b[axis]).abs() < 1e-6);
    let bent = view.instance_at(0);
    assert!(near(bent.positions()[0], [0.0, 0.0, 0.5]));
    assert!(near(bent.positions()[2], [0.5, 2.0, 0.0]), "a quarter turn takes z to x");
    assert!(near(bent.normals().unwrap()[2], [1.0, 0.0, 0.0]));
    assert!(near(bent.positions()[3], [0.75, 2.0, -0.25]), "half way between both joints");
    assert!(near(view.instance_at(1).positions()[3], [1.0, 2.0, 2.0]));
    assert_eq!(bent.bvh().validate(), Ok(()));

    assert!(matches!(
        scene.pose(one, &Pose { weights: &[], joints: &[turn] }),
        Err(EditError::PoseDiffers { what: "joints", expected: 2, found: 1 })
    ));
    let bad = Affine::from_translation([f32::NAN; 3]);
    assert_eq!(scene.pose(one, &Pose { weights: &[], joints: &[turn, bad] }), Err(EditError::NonFinite { at: 1 }));
    // Finite joints can still throw vertices beyond all numbers.
    let far = Affine::from_scale([3e38; 3]);
    scene.pose(one, &Pose { weights: &[9.0], joints: &[far, far] }).unwrap();
    let after = scene.commit();
    assert_eq!(after.report().meshes[0].reason, Reason::PoseNotFinite);
    assert_eq!(after.instance_at(0).positions(), bent.positions());
}

#[test]
fn clones_that_bend_share_their_first_build() {
    let ball = sphere(30, 40);
    // Enough that a tree of its own would be another one, and so little that it would not be a
    // better one.
    let bend: Vec<_> = ball.positions().iter().map(|p| [p[1] * p[1] * 0.01, 0.01 * p[0], 0.0]).collect();
    let bent: Vec<_> =
        ball.positions().iter().zip(&bend).map(|(p, by)| [0, 1, 2].map(|axis| p[axis] + 2.0 * by[axis])).collect();
    let alone = Mesh::new(&bent, ball.triangles()).unwrap();
    let mesh = ball.with_morph_targets(vec![MorphTarget { positions: bend, normals: vec![] }]).unwrap();
    let mut scene = Scene::new();
    for i in 0..3 {
        let id = scene.add_mesh(mesh.clone(), Motion::Deforming).unwrap();
        scene.add_instance(scene.root(), id, Affine::IDENTITY).unwrap();
        scene.pose(id, &Pose { weights: &[i as f32], joints: &[] }).unwrap();
    }
    let id = scene.add_mesh(alone, Motion::Deforming).unwrap();
    scene.add_instance(scene.root(), id, Affine::IDENTITY).unwrap();
    let view = scene.commit();
    let links =
        |i: u32| view.instance_at(i).bvh().tree().nodes().iter().flat_map(|node| node.lanes()).collect::<Vec<_>>();
    assert!(links(0) == links(1) && links(0) == links(2), "the first build is shared");
    assert_ne!(view.instance_at(0).positions(), view.instance_at(2).positions());
    assert!(links(2) != links(3), "a tree of its own is another one");
    assert!(view.instances().all(|instance| instance.bvh().validate() == Ok(())));
}

#[test]
fn many_instances_are_binned_and_few_are_clustered() {
    for (count, method) in [(512, TopLevelMethod::Clustered), (513, TopLevelMethod::Binned)] {
        let mut random = Random::new(count);
        let placements: Vec<_> = (0..count).map(|_| random.placement(40.0)).collect();
        let view = common::placed(cube(), &placements);
        assert_eq!(view.report().top_level.method, method);
        assert_eq!(view.top_level().instance_count(), count as usize);
        assert_eq!(view.top_level().validate(), Ok(()));
    }
}

#[test]
fn positions_and_indices_come_in_many_forms() {
    let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], [2.0, 0.0, 2.0]];
    let mesh = Mesh::new(&points, &[[0_u32, 1, 2], [1, 3, 2]]).unwrap();
    let triangles = [[0_u16, 1, 2], [1, 3, 2]];
    let padded = points.map(|[x, y, z]| [x, y, z, f32::NAN]).to_vec();
    for same in [
        Mesh::new(&points, &triangles[..]).unwrap(),
        Mesh::new(&points, &triangles.to_vec()).unwrap(),
        Mesh::new(&points, &triangles[..]).unwrap(),
        Mesh::new(&padded, &[0_u16, 1, 2, 1, 3, 2]).unwrap(),
        Mesh::new(&padded[..], &[0_u32, 1, 2, 1, 3, 2]).unwrap(),
        Mesh::new(Positions::in_vertices(&points, 0), &triangles[..]).unwrap(),
    ] {
        assert_eq!((same.positions(), same.triangles()), (mesh.positions(), mesh.triangles()));
    }
    let out_of_range = Err(MeshError::IndexOutOfRange { triangle: 1, index: 9, vertices: 4 });
    assert_eq!(Mesh::new(&points, &[[0_u16, 1, 2], [1, 9, 2]][..]).map(drop), out_of_range);
    // The last vertex does not hold three floats from here.
    let beyond = Mesh::new(Positions::in_vertices(&points, 4), &triangles[..]).map(drop);
    assert_eq!(beyond, Err(MeshError::StrideOutOfRange { stride: 12, offset: 4, count: 4, bytes: 48 }));
    assert!(Mesh::new(Positions::in_vertices(&points, usize::MAX), &triangles[..]).is_err());
    let nothing: [[f32; 4]; 0] = [];
    assert!(Mesh::new(&nothing[..], &[] as &[[u16; 3]]).is_ok());
}
