//! Handles as bits: the same handle comes back, and any other bits are stale or foreign.

mod common;

use common::{Random, cube};
use kinetree::{Affine, EditError, InstanceId, MeshId, Motion, NodeId, Ray, Scene};

/// A scene in which slots have been used more than once.
fn scene() -> (Scene, [NodeId; 2], [InstanceId; 2], [MeshId; 2]) {
    let mut scene = Scene::new();
    let root = scene.root();
    let removed = scene.add_node(root, Affine::IDENTITY).unwrap();
    scene.remove_node(removed).unwrap();
    let node = scene.add_node(root, Affine::IDENTITY).unwrap();
    let meshes = [(); 2].map(|()| scene.add_mesh(cube(), Motion::Rigid).unwrap());
    let instances = meshes.map(|mesh| scene.add_instance(node, mesh, Affine::IDENTITY).unwrap());
    scene.remove_instance(instances[1]).unwrap();
    let again = scene.add_instance(node, meshes[1], Affine::IDENTITY).unwrap();
    (scene, [root, node], [instances[0], again], meshes)
}

#[test]
fn bits_give_the_same_handle_back() {
    let (mut scene, nodes, instances, meshes) = scene();
    for node in nodes {
        let back = NodeId::from_bits(node.to_bits());
        assert_eq!(back, node);
        assert!(scene.world_from_node(back).is_ok());
    }
    for instance in instances {
        let back = InstanceId::from_bits(instance.to_bits());
        assert_eq!(back, instance);
        assert_eq!(scene.set_mask(back, u32::MAX), Ok(()));
    }
    for mesh in meshes {
        let back = MeshId::from_bits(mesh.to_bits());
        assert_eq!(back, mesh);
        assert_eq!(scene.rebuild(back), Ok(()));
    }
}

#[test]
fn bits_of_one_kind_are_no_handle_of_another() {
    let (mut scene, nodes, instances, meshes) = scene();
    let foreign = Err(EditError::OtherScene);
    for mesh in meshes {
        assert_eq!(scene.set_mask(NodeId::from_bits(mesh.to_bits()), 1), foreign);
        assert_eq!(scene.set_mask(InstanceId::from_bits(mesh.to_bits()), 1), foreign);
    }
    assert_eq!(scene.rebuild(MeshId::from_bits(nodes[1].to_bits())), foreign);
    assert_eq!(scene.rebuild(MeshId::from_bits(instances[1].to_bits())), foreign);
}

/// All bits at random; bits of a handle with some of them flipped; and those that nearly are one.
fn spoilt(random: &mut Random, good: u128, used: &[u128]) -> u128 {
    let mut word = || u128::from(random.bits());
    let bits = match word() % 4 {
        0 => word() << 64 | word(),
        1 => good ^ 1 << (word() % 128),
        2 => good ^ (word() << 64 | word()) & (word() << 64 | word()) & (word() << 64 | word()),
        _ => good & !0xffff_ffff | (word() % 5),
    };
    if used.contains(&bits) { !bits } else { bits }
}

#[test]
fn any_other_bits_are_stale_or_of_another_scene() {
    let (mut scene, nodes, instances, meshes) = scene();
    let view = scene.commit();
    let mut used: Vec<u128> = nodes.iter().map(|node| node.to_bits()).collect();
    used.extend(instances.iter().map(|instance| instance.to_bits()));
    used.extend(meshes.iter().map(|mesh| mesh.to_bits()));
    let ray = Ray::new([0.1, 0.2, 50.0], [0.0, 0.0, -1.0]);
    let hit = view.closest_hit(&ray).unwrap();
    let seed = 0x0b17_5eed;
    let mut random = Random::new(seed);
    for round in 0..20_000 {
        let good = used[round % used.len()];
        let bits = spoilt(&mut random, good, &used);
        let (node, instance, mesh) = (NodeId::from_bits(bits), InstanceId::from_bits(bits), MeshId::from_bits(bits));
        let answers = [
            scene.place(node, Affine::IDENTITY),
            scene.add_node(node, Affine::IDENTITY).map(drop),
            scene.add_instance(node, meshes[0], Affine::IDENTITY).map(drop),
            scene.add_instance(nodes[1], mesh, Affine::IDENTITY).map(drop),
            scene.world_from_node(node).map(drop),
            scene.remove_node(node),
            scene.place(instance, Affine::IDENTITY),
            scene.set_mask(instance, 1),
            scene.set_opaque(instance, true),
            scene.remove_instance(instance),
            scene.set_positions(mesh, &[[0.0; 3]]),
            scene.rebuild(mesh),
            scene.remove_mesh(mesh),
        ];
        for answer in answers {
            let is_refused = matches!(answer, Err(EditError::StaleHandle | EditError::OtherScene));
            assert!(is_refused, "{answer:?} for {bits:#x}, seed {seed:#x}");
        }
        // What is not in the frame leaves out nothing.
        assert_eq!(view.query().without(node).closest_hit(&ray), Some(hit));
        assert_eq!(view.query().without(instance).closest_hit(&ray), Some(hit));
    }
    let after = scene.commit();
    assert_eq!(after.instances().len(), 2);
}
