//! Deformed meshes: joints and morph targets.

use kinetree::Motion;
use serde_json::json;

use crate::writer::{TRIANGLE, Writer, assert_near, frame, places};

/// A bar along y from 0 to 2, of three pairs of vertices. Joint 0 is at the origin, joint 1 at (0,
/// 1, 0); the lower vertices follow the first, the upper ones the second, those between follow
/// both.
pub(crate) fn bar() -> Writer {
    let mut writer = Writer::new();
    let vertices: Vec<[f32; 3]> = [0.0, 1.0, 2.0].iter().flat_map(|&y| [[-0.1, y, 0.0], [0.1, y, 0.0]]).collect();
    let positions = writer.vec3(&vertices);
    let joints = writer.u8("VEC4", &[[0, 1, 0, 0]; 6].concat());
    let weights: Vec<f32> =
        [[1.0, 0.0], [0.5, 0.5], [0.0, 3.0]].iter().flat_map(|w| [[w[0], w[1], 0.0, 0.0]; 2]).flatten().collect();
    let weights = writer.floats("VEC4", &weights);
    let indices = writer.u8("SCALAR", &[0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4]);
    let lower = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
    let upper = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., -1., 0., 1.];
    let inverse = writer.floats("MAT4", &[lower, upper].concat());
    let attributes = json!({ "POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights });
    let mesh = writer.push("meshes", json!({ "primitives": [{ "attributes": attributes, "indices": indices }] }));
    writer.with(json!({
        "skins": [{ "joints": [2, 3], "inverseBindMatrices": inverse }],
        // The node of the mesh is somewhere else and has no size: neither counts.
        "nodes": [
            { "children": [1, 2], "translation": [5, 0, 0] },
            { "mesh": mesh, "skin": 0, "translation": [100, 0, 0], "scale": [0, 0, 0] },
            { "children": [3] },
            { "translation": [0, 1, 0] },
        ],
    }))
}

#[test]
fn a_skinned_bar_bends_at_its_joint() {
    let mut writer = bar();
    let half = 0.5f32.sqrt();
    writer.animate(3, "rotation", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half], "LINEAR");
    let mut loaded = writer.good();
    let view = frame(&mut loaded, 0.0);
    assert_eq!(view.instance_at(0).motion(), Motion::Deforming);
    let straight: Vec<[f32; 3]> = [0.0, 1.0, 2.0].iter().flat_map(|&y| [[4.9, y, 0.0], [5.1, y, 0.0]]).collect();
    assert_near(&places(&view)[0], &straight, "at rest");
    // Just before the end, by which it begins again: the upper half points to -x.
    let view = frame(&mut loaded, 1.0 - 1e-9);
    let deformed =
        [[4.9, 0.0, 0.0], [5.1, 0.0, 0.0], [4.95, 0.95, 0.0], [5.05, 1.05, 0.0], [4.0, 0.9, 0.0], [4.0, 1.1, 0.0]];
    assert_near(&places(&view)[0], &deformed, "deformed");
}

#[test]
fn a_skin_is_posed_without_any_animation() {
    let mut writer = bar();
    writer.json["nodes"][3]["translation"] = json!([0, 3, 0]);
    let view = frame(&mut writer.good(), 0.0);
    assert_near(&places(&view)[0][4..], &[[4.9, 4.0, 0.0], [5.1, 4.0, 0.0]], "the second joint is higher");
}

#[test]
fn joints_may_lie_outside_of_the_scene() {
    let writer = bar().with(json!({ "scenes": [{ "nodes": [1] }] }));
    let view = frame(&mut writer.good(), 0.0);
    assert_near(&places(&view)[0][..1], &[[4.9, 0.0, 0.0]], "in the place of its joints");
}

#[test]
fn nodes_with_the_same_skin_share_their_mesh() {
    let mut writer = bar();
    writer.push("nodes", json!({ "mesh": 0, "skin": 0 }));
    writer.push("nodes", json!({ "mesh": 0 }));
    let view = frame(&mut writer.good(), 0.0);
    let found: Vec<_> = view.instances().map(|instance| (instance.mesh_id(), instance.motion())).collect();
    assert_eq!(found.len(), 3);
    let deformed: Vec<_> = found.iter().filter(|(_, motion)| *motion == Motion::Deforming).collect();
    assert_eq!(deformed.len(), 2);
    assert_eq!(deformed[0].0, deformed[1].0);
}

#[test]
fn of_many_influences_the_four_largest_count() {
    let mut writer = bar();
    // The second set names both joints again: with weights that outweigh all others for the first
    // joint.
    let joints = writer.u8("VEC4", &[[0, 1, 0, 1]; 6].concat());
    let weights = writer.floats("VEC4", &[[30.0, 0.001, 30.0, 0.002]; 6].concat());
    let attributes = &mut writer.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_1"] = json!(joints);
    attributes["WEIGHTS_1"] = json!(weights);
    writer.json["nodes"][3]["translation"] = json!([0, 2, 0]);
    let mut loaded = writer.good();
    let view = frame(&mut loaded, 0.0);
    // 30 + 30 of the first, 3 + 0.002 of the second, which stands one higher than in its bind pose.
    let lift = 3.002 / 63.002;
    assert_near(&places(&view)[0][4..5], &[[4.9, 2.0 + lift, 0.0]], "the upper end");
    assert!(loaded.notes.iter().any(|note| note.contains("of more than 4 joints")), "{:?}", loaded.notes);
}

#[test]
fn a_vertex_without_weights_follows_the_first_joint() {
    let mut writer = bar();
    let none = writer.floats("VEC4", &[0.0; 24]);
    writer.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(none);
    let mut loaded = writer.good();
    assert_near(&places(&frame(&mut loaded, 0.0))[0][4..5], &[[4.9, 2.0, 0.0]], "in its place");
    assert_eq!(loaded.notes.len(), 1, "{:?}", loaded.notes);
}

#[test]
fn weights_that_are_negative_or_not_finite_are_called_so_and_count_as_zero() {
    for (bad, note) in [
        (-0.25, "mesh 0: 6 joint weights that are negative count as zero"),
        (f32::NEG_INFINITY, "mesh 0: 6 joint weights that are negative count as zero"),
        (f32::NAN, "mesh 0: 6 joint weights that are not finite count as zero"),
        (f32::INFINITY, "mesh 0: 6 joint weights that are not finite count as zero"),
    ] {
        let mut writer = bar();
        let weights = writer.floats("VEC4", &[[1.0, bad, 0.0, 0.0]; 6].concat());
        writer.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
        writer.json["nodes"][3]["translation"] = json!([0, 9, 0]);
        let mut loaded = writer.good();
        assert_eq!(loaded.notes, [note]);
        assert_near(&places(&frame(&mut loaded, 0.0))[0][4..5], &[[4.9, 2.0, 0.0]], "all follow the first joint");
    }
}

#[test]
fn joints_without_weights_are_noted() {
    for attribute in ["JOINTS_0", "WEIGHTS_0"] {
        let mut writer = bar();
        let attributes = &mut writer.json["meshes"][0]["primitives"][0]["attributes"];
        attributes.as_object_mut().expect("an object").remove(attribute);
        let wanted = [
            "node 1 has a skin, but its mesh has no joints",
            "one of joints and weights without the other is ignored at mesh 0: nothing moves these vertices",
        ];
        assert_eq!(writer.good().notes, wanted);
    }
}

#[test]
fn broken_skins_are_errors() {
    let change = |change: &dyn Fn(&mut Writer)| {
        let mut writer = bar();
        change(&mut writer);
        writer.bad()
    };
    let one_joint = change(&|w| w.json["skins"][0]["joints"] = json!([2]));
    assert!(one_joint.contains("mesh 0 follows joint 1 of a skin with 1 joints"), "{one_joint}");
    let no_node = change(&|w| w.json["skins"][0]["joints"] = json!([2, 77]));
    assert!(no_node.contains("skin 0 refers to node 77, but there are 4"), "{no_node}");
    let no_skin = change(&|w| w.json["nodes"][1]["skin"] = json!(5));
    assert!(no_skin.contains("node 1 refers to skin 5, but there are 1"), "{no_skin}");
    let few = change(&|w| w.json["accessors"][4]["count"] = json!(1));
    assert!(few.contains("skin 0 has fewer inverse bind matrices"), "{few}");
    let wrong_shape = change(&|w| w.json["skins"][0]["inverseBindMatrices"] = json!(0));
    assert!(wrong_shape.contains("accessor 0 is Vec3, where Mat4 is needed"), "{wrong_shape}");
}

/// A triangle that can be lifted along z, and pushed along x.
pub(crate) fn lifted() -> Writer {
    let mut writer = Writer::new();
    let positions = writer.vec3(&TRIANGLE);
    let normals = writer.vec3(&[[0.0, 0.0, 1.0]; 3]);
    let [up, aside] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]].map(|shift| writer.vec3(&[shift; 3]));
    let tilted = writer.vec3(&[[1.0, 0.0, -1.0]; 3]);
    let attributes = json!({ "POSITION": positions, "NORMAL": normals });
    let targets = json!([{ "POSITION": up }, { "POSITION": aside, "NORMAL": tilted }]);
    writer.push("meshes", json!({ "primitives": [{ "attributes": attributes, "targets": targets }] }));
    writer
}

#[test]
fn two_nodes_morph_the_same_mesh_differently() {
    let mut writer = lifted();
    writer.json["meshes"][0]["weights"] = json!([0.5, 0]);
    writer.push("nodes", json!({ "mesh": 0 }));
    writer.push("nodes", json!({ "mesh": 0, "weights": [0, 1] }));
    writer.push("nodes", json!({ "mesh": 0, "weights": [0, 0] }));
    writer.push("nodes", json!({ "mesh": 0, "weights": [0, 1], "translation": [0, 10, 0] }));
    let view = frame(&mut writer.good(), 0.0);
    let places = places(&view);
    assert_eq!(places.len(), 4);
    assert_near(&places[0][..1], &[[0.0, 0.0, 0.5]], "the weights of the mesh");
    assert_near(&places[1][..1], &[[1.0, 0.0, 0.0]], "the weights of the node");
    assert_near(&places[2][..1], &[[0.0; 3]], "no weights");
    assert_near(&places[3][..1], &[[1.0, 10.0, 0.0]], "the weights of the node, elsewhere");
    let normal = |i: u32| view.instance_at(i).normals().expect("normals")[0];
    assert_near(&[normal(0), normal(1)], &[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]], "normals morph too");
    let mesh = |i: u32| view.instance_at(i).mesh_id();
    assert!(mesh(0) != mesh(1) && mesh(1) != mesh(2) && mesh(1) == mesh(3), "equal shapes are shared");
    assert_eq!(view.instance_at(2).motion(), Motion::Static);
}

#[test]
fn morph_weights_are_animated_by_node() {
    let mut writer = lifted();
    writer.push("nodes", json!({ "mesh": 0 }));
    writer.push("nodes", json!({ "mesh": 0 }));
    writer.animate(0, "weights", &[0.0, 1.0], &[0.0, 0.0, 2.0, 4.0], "LINEAR");
    writer.animate(1, "weights", &[0.0, 1.0], &[1.0, 0.0, 1.0, 0.0], "STEP");
    let mut loaded = writer.good();
    for (seconds, first) in [(0.0, [0.0; 3]), (0.5, [2.0, 0.0, 1.0]), (0.25, [1.0, 0.0, 0.5])] {
        let view = frame(&mut loaded, seconds);
        assert_near(&places(&view)[0][..1], &[first], &format!("the first at {seconds}"));
        assert_near(&places(&view)[1][..1], &[[0.0, 0.0, 1.0]], &format!("the second at {seconds}"));
    }
}

#[test]
fn a_skinned_mesh_can_morph_as_well() {
    let mut writer = bar();
    let lift = writer.vec3(&[[0.0, 0.0, 1.0]; 6]);
    writer.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": lift }]);
    writer.json["nodes"][1]["weights"] = json!([2]);
    writer.json["nodes"][3]["translation"] = json!([0, 3, 0]);
    let view = frame(&mut writer.good(), 0.0);
    assert_near(&places(&view)[0][4..], &[[4.9, 4.0, 2.0], [5.1, 4.0, 2.0]], "morphed, then skinned");
}
