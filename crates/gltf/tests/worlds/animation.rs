//! Nodes that move.

use kinetree::{Motion, Scene};
use kinetree_gltf::LoadedWorld;
use serde_json::json;

use crate::writer::{TRIANGLE, Writer, assert_near, frame, places};

/// Where the origin of the first instance is.
fn origin(loaded: &mut LoadedWorld, seconds: f64) -> [f32; 3] {
    frame(loaded, seconds).instance_at(0).world_from_object().translation
}

fn moving(times: &[f32], values: &[[f32; 3]], interpolation: &str) -> Writer {
    let mut writer = Writer::new();
    let mesh = writer.triangle();
    writer.push("nodes", json!({ "mesh": mesh }));
    writer.animate(0, "translation", times, values.as_flattened(), interpolation);
    writer
}

#[test]
fn a_node_follows_its_keys_and_begins_again() {
    let values = [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 4.0, 0.0]];
    let mut linear = moving(&[0.0, 1.0, 2.0], &values, "LINEAR").good();
    assert_eq!(linear.world.animation.duration(), 2.0);
    for (seconds, wanted) in [
        (0.5, [1.0, 0.0, 0.0]),
        (1.75, [2.0, 3.0, 0.0]),
        (0.0, [0.0; 3]),
        (2.0, [2.0, 4.0, 0.0]),
        (2.5, [1.0, 0.0, 0.0]),
        (-0.5, [2.0, 2.0, 0.0]),
        (2e9 + 0.5, [1.0, 0.0, 0.0]),
        (f64::NAN, [0.0; 3]),
        (f64::INFINITY, [0.0; 3]),
    ] {
        assert_near(&[origin(&mut linear, seconds)], &[wanted], &format!("at {seconds}"));
    }
    let mut step = moving(&[0.0, 1.0, 2.0], &values, "STEP").good();
    assert_near(&[origin(&mut step, 0.9)], &[[0.0; 3]], "before the step");
    assert_near(&[origin(&mut step, 1.9)], &[[2.0, 0.0, 0.0]], "after the step");
}

#[test]
fn a_spline_is_hermites() {
    // From 0 to 1 within two seconds, leaving with a slope of 3 and arriving with one of -1.
    let rows = [[0.0; 3], [0.0; 3], [3.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]];
    let mut loaded = moving(&[0.0, 2.0], &rows, "CUBICSPLINE").good();
    for i in 0..20 {
        let t = f64::from(i) / 10.0;
        let s = t / 2.0;
        let x = 2.0 * 3.0 * (s * s * s - 2.0 * s * s + s) + (3.0 * s * s - 2.0 * s * s * s) - 2.0 * (s * s * s - s * s);
        assert_near(&[origin(&mut loaded, t)], &[[x as f32, 0.0, 0.0]], &format!("at {t}"));
    }
}

#[test]
fn channels_of_different_lengths_wait_at_their_ends() {
    let mut writer = moving(&[0.5, 1.0], &[[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]], "LINEAR");
    let half = 0.5f32.sqrt();
    writer.animate(0, "rotation", &[0.0, 4.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half], "LINEAR");
    writer.animate(0, "scale", &[0.0], &[2.0, 2.0, 2.0], "LINEAR");
    let mut loaded = writer.good();
    assert_eq!(loaded.world.animation.duration(), 4.0);
    assert_near(&[origin(&mut loaded, 0.25)], &[[1.0, 0.0, 0.0]], "before its first key");
    assert_near(&[origin(&mut loaded, 3.0)], &[[3.0, 0.0, 0.0]], "after its last key");
    let view = frame(&mut loaded, 2.0);
    let eighth = std::f32::consts::FRAC_PI_4;
    let (s, c) = (2.0 * eighth.sin(), 2.0 * eighth.cos());
    assert_near(&places(&view)[0], &[[3.0, 0.0, 0.0], [3.0 + c, s, 0.0], [3.0 - s, c, 0.0]], "halfway turned");
    assert_eq!(view.instance_at(0).motion(), Motion::Rigid);
}

#[test]
fn meshes_below_an_animated_node_are_rigid_and_the_others_static() {
    let mut writer = Writer::new();
    let [shared, alone] = [writer.triangle(), writer.triangle()];
    for node in
        [json!({ "children": [1] }), json!({ "mesh": shared }), json!({ "mesh": shared }), json!({ "mesh": alone })]
    {
        writer.push("nodes", node);
    }
    writer.animate(0, "translation", &[0.0, 1.0], &[0.0, 0.0, 0.0, 0.0, 0.0, 5.0], "LINEAR");
    let mut loaded = writer.good();
    let view = frame(&mut loaded, 0.5);
    let motions: Vec<_> = view.instances().map(|instance| (instance.positions().len(), instance.motion())).collect();
    assert_eq!(motions.len(), 3);
    assert_eq!(motions.iter().filter(|(_, motion)| *motion == Motion::Rigid).count(), 2);
    assert!(places(&view).iter().any(|place| place[0] == [0.0, 0.0, 2.5]));
}

#[test]
fn a_matrix_can_be_animated_by_its_parts() {
    let mut writer = Writer::new();
    let mesh = writer.triangle();
    writer.push("nodes", json!({ "mesh": mesh, "matrix": [0, 2, 0, 0, -3, 0, 0, 0, 0, 0, -1, 0, 7, 8, 9, 1] }));
    writer.animate(0, "translation", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], "LINEAR");
    let view = frame(&mut writer.good(), 0.0);
    assert_near(&places(&view)[0], &[[0.0; 3], [0.0, 2.0, 0.0], [-3.0, 0.0, 0.0]], "turned, scaled and mirrored");
    let mirrored = view.instance_at(0).world_from_object().transform_vector([0.0, 0.0, 1.0]);
    assert_near(&[mirrored], &[[0.0, 0.0, -1.0]], "mirrored");
}

#[test]
fn odd_channels_are_noted_and_broken_ones_are_errors() {
    let good = || moving(&[0.0, 1.0], &[[0.0; 3], [1.0; 3]], "LINEAR");
    let mut without_node = good();
    let target = without_node.json["animations"][0]["channels"][0]["target"].as_object_mut().expect("a target");
    target.remove("node");
    assert_eq!(without_node.good().notes.len(), 1);
    let mut unknown = good();
    unknown.json["animations"][0]["channels"][0]["target"]["path"] = json!("colour");
    assert_eq!(unknown.good().notes.len(), 1);
    let mut no_targets = good();
    no_targets.json["animations"][0]["channels"][0]["target"]["path"] = json!("weights");
    assert_eq!(no_targets.good().notes.len(), 1);
    let empty = moving(&[], &[], "LINEAR");
    assert_eq!(empty.good().notes.len(), 1);

    for (times, values) in [
        (vec![1.0, 0.0], vec![[0.0; 3]; 2]),
        (vec![0.0, f32::NAN], vec![[0.0; 3]; 2]),
        (vec![0.0, 1.0], vec![[0.0; 3]; 3]),
        (vec![0.0, 1.0], vec![[0.0; 3], [f32::NAN, 0.0, 0.0]]),
    ] {
        assert!(moving(&times, &values, "LINEAR").bad().starts_with("animation 0 has"), "{times:?} {values:?}");
    }
    assert!(moving(&[0.0, 1.0], &[[0.0; 3]; 2], "CUBICSPLINE").bad().contains("too few values"));
    let mut missing = good();
    missing.json["animations"][0]["channels"][0]["sampler"] = json!(3);
    assert!(missing.bad().contains("animation 0 refers to sampler 3, but there are 1"), "{}", missing.bad());
    let mut nowhere = good();
    nowhere.json["animations"][0]["channels"][0]["target"]["node"] = json!(3);
    assert!(nowhere.bad().contains("animation 0 refers to node 3, but there are 1"), "{}", nowhere.bad());
}

#[test]
fn an_animation_does_not_touch_what_stands_still() {
    let mut writer = moving(&[0.0, 1.0, 2.0], &[[0.0; 3], [1.0; 3], [1.0; 3]], "LINEAR");
    let displaced = writer.vec3(&[[0.0, 0.0, 1.0]; 3]);
    writer.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": displaced }]);
    writer.animate(0, "weights", &[0.0, 1.0, 2.0], &[0.0, 1.0, 1.0], "LINEAR");
    let mut loaded = writer.good();
    frame(&mut loaded, 1.25);
    // Another scene would refuse the handles of this one: between equal moments, nothing is edited
    // at all.
    assert!(loaded.world.animation.go_to(&mut Scene::new(), 1.5).is_ok());
    assert!(loaded.world.animation.go_to(&mut Scene::new(), 0.5).is_err());
}

#[test]
fn equal_times_give_equal_places_in_any_order() {
    let mut loaded = moving(&[0.0, 1.0, 3.0], &[[0.0; 3], [0.3, 7.0, 1.0], TRIANGLE[1]], "LINEAR").good();
    let first: Vec<_> = (0..30).map(|i| origin(&mut loaded, f64::from(i) * 0.1)).collect();
    let second: Vec<_> = (0..30).rev().map(|i| origin(&mut loaded, f64::from(i) * 0.1)).collect();
    assert!(first.iter().eq(second.iter().rev()));
}
