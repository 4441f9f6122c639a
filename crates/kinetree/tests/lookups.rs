//! What scenes and snapshots say about what is in them.

mod common;

use common::{cube, grid, sphere};
use kinetree::{Affine, EditError, Mesh, Motion, Precision, Ray, Scene};

#[test]
fn a_scene_tells_what_edits_made_of_it() {
    let mut scene = Scene::new();
    let root = scene.root();
    let wheel_from_hub = Affine::from_translation([0.0, 2.0, 0.0]);
    let body = scene.add_mesh(cube(), Motion::Rigid).unwrap();
    let cloth = scene.add_mesh(grid(2, 1.0), Motion::Deforming).unwrap();
    let car = scene.add_node(root, Affine::IDENTITY).unwrap();
    let wheel = scene.add_node(car, Affine::IDENTITY).unwrap();
    let shown = scene.add_instance(wheel, body, Affine::IDENTITY).unwrap();
    let flag = scene.add_instance(car, cloth, Affine::IDENTITY).unwrap();
    scene.place(car, Affine::from_translation([5.0, 0.0, 0.0])).unwrap();
    scene.place(wheel, wheel_from_hub).unwrap();
    scene.place(shown, Affine::from_scale([2.0; 3])).unwrap();
    scene.set_mask(car, 6).unwrap();
    scene.set_user_id(shown, 9).unwrap();
    scene.set_opaque(flag, true).unwrap();

    assert_eq!(scene.nodes().collect::<Vec<_>>(), [root, car, wheel]);
    assert_eq!(scene.instances().collect::<Vec<_>>(), [shown, flag]);
    assert_eq!(scene.meshes().collect::<Vec<_>>(), [body, cloth]);
    assert_eq!(scene.mesh(cloth).map(|mesh| mesh.triangles().len()), Ok(8));
    assert_eq!((scene.motion(body), scene.motion(cloth)), (Ok(Motion::Rigid), Ok(Motion::Deforming)));
    assert_eq!((scene.mesh_of(shown), scene.mesh_of(flag)), (Ok(body), Ok(cloth)));
    assert_eq!(scene.transform(wheel), Ok(wheel_from_hub));
    assert_eq!(scene.transform(shown), Ok(Affine::from_scale([2.0; 3])));
    assert_eq!((scene.mask(car), scene.mask(flag)), (Ok(6), Ok(u32::MAX)));
    assert_eq!((scene.user_id(shown), scene.user_id(car)), (Ok(Some(9)), Ok(None)));
    assert_eq!((scene.is_opaque(shown), scene.is_opaque(flag)), (Ok(false), Ok(true)));
    assert_eq!((scene.parent(root), scene.parent(car)), (Ok(None), Ok(Some(root))));
    assert_eq!((scene.parent(wheel), scene.parent(shown)), (Ok(Some(car)), Ok(Some(wheel))));
    assert_eq!(scene.children(car).unwrap().collect::<Vec<_>>(), [wheel]);
    assert_eq!(scene.instances_of(car).unwrap().collect::<Vec<_>>(), [flag]);
    assert_eq!(scene.children(wheel).unwrap().len() + scene.instances_of(root).unwrap().len(), 0);

    let view = scene.commit();
    let placed = view.find(shown).unwrap();
    assert_eq!(scene.world_from_instance(shown), Ok(*placed.world_from_object()));
    assert_eq!(placed.world_from_object().translation, [5.0, 2.0, 0.0]);

    scene.remove_node(wheel).unwrap();
    assert_eq!(scene.children(car).unwrap().len(), 0);
    assert_eq!(scene.instances().collect::<Vec<_>>(), [flag]);
    let stale = EditError::StaleHandle;
    assert_eq!((scene.transform(shown), scene.parent(wheel)), (Err(stale), Err(stale)));
    assert_eq!((scene.mesh_of(shown), scene.mask(wheel)), (Err(stale), Err(stale)));
    assert_eq!(scene.children(wheel).map(|children| children.len()), Err(stale));
    let other = Scene::new();
    assert_eq!(other.transform(flag), Err(EditError::OtherScene));
    assert_eq!(other.motion(body), Err(EditError::OtherScene));
}

#[test]
fn a_snapshot_finds_its_instances_and_meshes_by_handle() {
    let mut scene = Scene::new();
    let hidden = scene.add_mesh(sphere(4, 6).with_precision(Precision::Fast), Motion::Static).unwrap();
    let shown = scene.add_mesh(cube(), Motion::Rigid).unwrap();
    let [gone, flat, fine] = [[1.0; 3], [0.0; 3], [2.0, 1.0, 1.0]]
        .map(|scale| scene.add_instance(scene.root(), shown, Affine::from_scale(scale)).unwrap());
    scene.remove_instance(gone).unwrap();
    let before = scene.commit();
    let late = scene.add_instance(scene.root(), shown, Affine::from_translation([9.0, 0.0, 0.0])).unwrap();
    let late_mesh = scene.add_mesh(Mesh::empty(), Motion::Dynamic).unwrap();
    let after = scene.commit();

    for (view, found) in [(&before, vec![fine]), (&after, vec![late, fine])] {
        assert_eq!(view.instances().map(|instance| instance.id()).collect::<Vec<_>>(), found);
        for instance in [gone, flat, fine, late] {
            let id = view.find(instance).map(|instance| instance.id());
            assert_eq!(id, found.contains(&instance).then_some(instance));
        }
    }
    let view = after.mesh(hidden).unwrap();
    assert_eq!((view.id(), view.motion(), view.precision()), (hidden, Motion::Static, Precision::Fast));
    assert_eq!(view.positions(), scene.mesh(hidden).unwrap().positions());
    assert_eq!(view.report().mesh, hidden);
    assert_eq!(view.bvh().validate(), Ok(()));
    assert_eq!(after.find(fine).map(|instance| instance.mesh().id()), Some(shown));
    assert_eq!(after.find(fine).map(|instance| instance.motion()), Some(Motion::Rigid));
    assert!(before.mesh(late_mesh).is_none());
    assert!(after.mesh(late_mesh).is_some_and(|mesh| mesh.triangles().is_empty()));
    scene.remove_mesh(hidden).unwrap();
    assert!(scene.commit().mesh(hidden).is_none() && after.mesh(hidden).is_some());
    let other = Scene::new().commit();
    assert!(other.mesh(shown).is_none() && other.find(fine).is_none());
}

#[test]
fn bounds_contain_the_instance_and_hardly_more() {
    let placement = Affine::from_translation([100.0, 0.0, -3.0]) * Affine::from_scale([2.0, 1.0, 0.5]);
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(sphere(12, 16), Motion::Rigid).unwrap();
    let ball = scene.add_instance(scene.root(), mesh, placement).unwrap();
    let empty = scene.add_mesh(Mesh::empty(), Motion::Dynamic).unwrap();
    let nothing = scene.add_instance(scene.root(), empty, placement).unwrap();
    let view = scene.commit();
    let instance = view.find(ball).unwrap();
    let tight = instance.positions().iter().map(|&position| placement.transform_point(position));
    let tight = kinetree::Aabb::from_points(tight);
    assert!(instance.bounds().contains(&tight));
    let grown = instance.bounds().extent();
    assert!((0..3).all(|axis| grown[axis] < tight.extent()[axis] + 1e-3), "{grown:?}");
    assert!(view.find(nothing).unwrap().bounds().is_empty());
}

#[test]
fn values_per_vertex_are_interpolated_at_hits() {
    let mesh = sphere(12, 16);
    let mut scene = Scene::new();
    let id = scene.add_mesh(mesh, Motion::Rigid).unwrap();
    scene.add_instance(scene.root(), id, Affine::from_translation([3.0, 0.0, 0.0])).unwrap();
    let view = scene.commit();
    let hit = view.closest_hit(&Ray::new([3.1, 0.2, 9.0], [0.0, 0.0, -1.0])).unwrap();
    let instance = view.instance(&hit);
    let local = instance.interpolate(&hit, instance.positions()).unwrap();
    let position = view.position(&hit);
    assert!((local[0] + 3.0 - position[0]).abs() < 1e-5 && (local[2] - position[2]).abs() < 1e-5);
    let heights: Vec<f32> = instance.positions().iter().map(|position| position[1]).collect();
    assert_eq!(instance.interpolate(&hit, &heights), Some(local[1]));
    assert_eq!(instance.mesh().interpolate(&hit, &heights), Some(local[1]));
    assert_eq!(instance.interpolate(&hit, &heights[1..]), None);
    let mut other = hit;
    other.primitive = u32::MAX;
    assert_eq!(instance.interpolate(&other, &heights), None);
}
