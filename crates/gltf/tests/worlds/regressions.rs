//! Files that once went wrong.

use std::ops::ControlFlow;

use kinetree::{Cull, Ray, Snapshot};
use kinetree_gltf::{Clip, LoadedWorld, Options};
use kinetree_render::{Settings, render};
use kinetree_world::{Camera, Light};
use serde_json::{Value, json};

use crate::writer::{TRIANGLE, Writer, assert_near, frame, places};

/// A mesh of a triangle with one morph target, up, and of another primitive with two; the weights
/// of both targets go from 0 to (1, 1) within a second.
fn with_targets_of_its_own(other: impl FnOnce(&mut Writer, usize) -> Value) -> Writer {
    let mut writer = Writer::new();
    let positions = writer.vec3(&TRIANGLE);
    let up = writer.vec3(&[[0.0, 0.0, 1.0]; 3]);
    let mut other = other(&mut writer, positions);
    other["targets"] = json!([{ "POSITION": up }, { "POSITION": up }]);
    let first = json!({ "attributes": { "POSITION": positions }, "targets": [{ "POSITION": up }] });
    let mesh = writer.push("meshes", json!({ "primitives": [first, other] }));
    writer.push("nodes", json!({ "mesh": mesh }));
    writer.animate(0, "weights", &[0.0, 1.0], &[0.0, 0.0, 1.0, 1.0], "LINEAR");
    writer
}

#[test]
fn morph_targets_are_counted_once_for_targets_weights_and_keys() {
    let points = with_targets_of_its_own(|_, positions| json!({ "attributes": { "POSITION": positions }, "mode": 0 }));
    let nowhere = with_targets_of_its_own(|_, _| json!({ "attributes": {} }));
    let mut no_triangles = with_targets_of_its_own(|writer, positions| {
        let two = writer.u16("SCALAR", &[0, 1]);
        json!({ "attributes": { "POSITION": positions }, "indices": two })
    });
    // Vertices without normals are dropped when they have no triangles and others have normals.
    let normals = no_triangles.vec3(&[[0.0, 0.0, 1.0]; 3]);
    no_triangles.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    for (what, writer) in [("points", points), ("no positions", nowhere), ("no triangles", no_triangles)] {
        let mut loaded = writer.good();
        for seconds in [0.0, 0.5, 0.25] {
            let view = frame(&mut loaded, seconds);
            let triangle = TRIANGLE.map(|[x, y, _]| [x, y, seconds as f32]);
            assert_near(&places(&view)[0], &triangle, what);
        }
        let mut weighted = writer;
        weighted.json["animations"] = json!([]);
        weighted.json["nodes"][0]["weights"] = json!([0.5, 1]);
        let mut loaded = weighted.good();
        assert_near(&places(&frame(&mut loaded, 0.0))[0][..1], &[[0.0, 0.0, 0.5]], what);
        assert!(!loaded.notes.iter().any(|note| note.contains("weights for")), "{what}: {:?}", loaded.notes);
    }
}

/// A square of two units around the origin of the plane z = 0 that looks to +z, skinned to a joint
/// that does not move it. Nodes: 0 the joint, 1 the mesh, 2 the parent of both.
fn skinned_square() -> Writer {
    let mut writer = Writer::new();
    let positions = writer.vec3(&[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
    let joints = writer.u8("VEC4", &[0; 16]);
    let weights = writer.floats("VEC4", &[[1.0, 0.0, 0.0, 0.0]; 4].concat());
    let indices = writer.u16("SCALAR", &[0, 1, 2, 0, 2, 3]);
    let attributes = json!({ "POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights });
    let mesh = writer.push("meshes", json!({ "primitives": [{ "attributes": attributes, "indices": indices }] }));
    writer.with(json!({
        "skins": [{ "joints": [0] }],
        "nodes": [{}, { "mesh": mesh, "skin": 0 }, { "children": [0, 1] }],
    }))
}

/// From which sides of z = 0 rays along z meet the front of something at (x, 0.25).
fn fronts(view: &Snapshot, x: f32) -> [bool; 2] {
    [1.0, -1.0].map(|z| {
        let ray = Ray::new([x, 0.25, z], [0.0, 0.0, -z]);
        view.closest_hit(&ray).expect("something is there");
        view.query().cull(Cull::Back).closest_hit(&ray).is_some()
    })
}

#[test]
fn the_front_of_a_skinned_mesh_follows_the_determinant_of_its_node() {
    let (above, below) = ([true, false], [false, true]);
    for (joint, mesh, parent, wanted) in [
        ([1, 1, 1], [1, 1, 1], [1, 1, 1], above),
        // Joint and mesh are mirrored alike: the front stays where it is.
        ([1, 1, 1], [1, 1, 1], [-1, 1, 1], above),
        ([1, 1, 1], [1, 1, 1], [-1, -1, 1], above),
        ([1, 1, 1], [1, 1, 1], [1, 1, -1], below),
        // The winding stays, but for a node that mirrors, the front is where it is clockwise.
        ([1, 1, 1], [-1, 1, 1], [1, 1, 1], below),
        ([1, 1, 1], [-1, -1, -1], [1, 1, 1], below),
        // The joint reverses the winding, and the node of the mesh does not.
        ([-1, 1, 1], [1, 1, 1], [1, 1, 1], below),
        // A node without a size mirrors nothing.
        ([1, 1, 1], [0, 0, 0], [1, 1, 1], above),
    ] {
        let mut writer = skinned_square();
        for (node, scale) in [joint, mesh, parent].into_iter().enumerate() {
            writer.json["nodes"][node]["scale"] = json!(scale);
        }
        let view = frame(&mut writer.good(), 0.0);
        assert_eq!(fronts(&view, 0.5), wanted, "{joint:?} {mesh:?} {parent:?}");
    }
}

#[test]
fn nodes_that_mirror_and_nodes_that_do_not_show_their_own_front_of_one_skinned_mesh() {
    let mut writer = skinned_square();
    writer.push("nodes", json!({ "mesh": 0, "skin": 0, "scale": [1, -1, 1] }));
    writer.push("nodes", json!({ "mesh": 0, "skin": 0 }));
    let view = frame(&mut writer.good(), 0.0);
    // Three squares in one place: each side is the front of one at least.
    assert_eq!(fronts(&view, 0.5), [true, true]);
    let mut meshes: Vec<_> = view.instances().map(|instance| instance.mesh_id()).collect();
    meshes.sort_unstable();
    meshes.dedup();
    assert_eq!((view.instances().len(), meshes.len()), (3, 2));
}

#[test]
fn a_node_that_turns_into_its_mirror_image_turns_the_front_of_its_skinned_mesh() {
    let mut writer = skinned_square();
    writer.animate(1, "scale", &[0.0, 1.0, 2.0], &[1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0], "STEP");
    let mut loaded = writer.good();
    for (seconds, wanted) in [(0.5, [true, false]), (1.5, [false, true]), (2.0, [true, false]), (1.0, [false, true])] {
        let view = frame(&mut loaded, seconds);
        assert_eq!(fronts(&view, 0.5), wanted, "at {seconds}");
        assert_near(&places(&view)[0][..1], &[[-1.0, -1.0, 0.0]], "it stays where it is");
    }
}

/// The mean radiance of a white place under a sun that shines along -z with an irradiance of pi.
fn radiance(loaded: &mut LoadedWorld, seconds: f64, at: [f32; 3]) -> f32 {
    let sun = Light::Sun { direction: [0.0, 0.0, -1.0], irradiance: [std::f32::consts::PI; 3], angle: 0.0 };
    let mut frame = loaded.world.frame(seconds).expect("a frame");
    frame.lights = vec![sun];
    let camera = Camera::look_at([at[0] - 0.1, at[1], at[2] + 5.0], at, 0.01);
    let settings = Settings { width: 2, height: 2, spp: 4, max_depth: 1, ..Settings::default() };
    let picture = render(&frame, &camera, &settings, &|_| ControlFlow::Continue(())).expect("a picture");
    picture.film.mean()[0]
}

/// Two squares: from x = -4 to -2 with normals along z, from x = 2 to 4 without. The morph target
/// lifts the far side of the second by 2 tan 60 degrees.
fn slope() -> Writer {
    let mut writer = Writer::new();
    let square = |x: f32| [[x, -1.0, 0.0], [x + 2.0, -1.0, 0.0], [x + 2.0, 1.0, 0.0], [x, 1.0, 0.0]];
    let [left, right] = [-4.0, 2.0].map(|x| writer.vec3(&square(x)));
    let normals = writer.vec3(&[[0.0, 0.0, 1.0]; 4]);
    let indices = writer.u16("SCALAR", &[0, 1, 2, 0, 2, 3]);
    let still = writer.vec3(&[[0.0; 3]; 4]);
    let rise = 2.0 * 3f32.sqrt();
    let lifted = writer.vec3(&[[0.0; 3], [0.0; 3], [0.0, 0.0, rise], [0.0, 0.0, rise]]);
    let primitives = json!([
        { "attributes": { "POSITION": left, "NORMAL": normals }, "indices": indices, "targets": [{ "POSITION": still }] },
        { "attributes": { "POSITION": right }, "indices": indices, "targets": [{ "POSITION": lifted }] },
    ]);
    let mesh = writer.push("meshes", json!({ "primitives": primitives }));
    writer.push("nodes", json!({ "mesh": mesh }));
    writer
}

#[test]
fn triangles_without_normals_are_flat_in_every_pose() {
    let mut writer = slope();
    writer.animate(0, "weights", &[0.0, 1.0], &[0.0, 1.0], "LINEAR");
    let mut loaded = writer.good();
    for weight in [0.0_f32, 0.5, 1.0] {
        // A white surface under an irradiance of pi has the radiance of the cosine.
        let wanted = 1.0 / (1.0 + 3.0 * weight * weight).sqrt();
        let middle = [3.0, 0.0, weight * 3f32.sqrt()];
        let found = radiance(&mut loaded, f64::from(weight), middle);
        assert!((found - wanted).abs() < 1e-4, "{found} instead of {wanted} at {weight}");
        let beside = radiance(&mut loaded, f64::from(weight), [-3.0, 0.0, 0.0]);
        assert!((beside - 1.0).abs() < 1e-4, "{beside} at {weight}");
    }
}

#[test]
fn triangles_without_normals_are_flat_between_joints_too() {
    let mut writer = slope();
    // The lower edge follows one joint, the upper another, which rises.
    let joints = writer.u8("VEC4", &[[0, 0, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]].concat());
    let weights = writer.floats("VEC4", &[[1.0, 0.0, 0.0, 0.0]; 4].concat());
    for primitive in 0..2 {
        let primitive = &mut writer.json["meshes"][0]["primitives"][primitive];
        primitive.as_object_mut().expect("an object").remove("targets");
        primitive["attributes"]["JOINTS_0"] = json!(joints);
        primitive["attributes"]["WEIGHTS_0"] = json!(weights);
    }
    writer.json["nodes"][0]["skin"] = json!(0);
    writer.push("nodes", json!({}));
    writer.push("nodes", json!({ "translation": [0, 0, 2.0 * 3f32.sqrt()] }));
    let found =
        radiance(&mut writer.with(json!({ "skins": [{ "joints": [1, 2] }] })).good(), 0.0, [3.0, 0.0, 3f32.sqrt()]);
    assert!((found - 0.5).abs() < 1e-4, "{found}");
}

/// A triangle that goes from the origin to x = 10 within a second.
fn going() -> Writer {
    let mut writer = Writer::new();
    let mesh = writer.triangle();
    writer.push("nodes", json!({ "mesh": mesh }));
    writer.animate(0, "translation", &[0.0, 1.0], &[0.0, 0.0, 0.0, 10.0, 0.0, 0.0], "LINEAR");
    writer
}

#[test]
fn a_clip_ends_with_its_last_pose() {
    let mut loaded = going().good();
    for frame_number in 0..25 {
        let seconds = f64::from(frame_number) / 24.0;
        let x = places(&frame(&mut loaded, seconds))[0][0][0];
        assert!((f64::from(x) - 10.0 * seconds).abs() < 1e-4, "{x} at {seconds}");
    }
    // As many programs write it: the last of 23 frames, at 24 a second, rounded to single
    // precision.
    let last = 23.0_f64 / 24.0;
    let mut writer = going();
    let times = writer.floats("SCALAR", &[0.0, last as f32]);
    writer.json["animations"][0]["samplers"][0]["input"] = json!(times);
    assert_near(&places(&frame(&mut writer.good(), last))[0][..1], &[[10.0, 0.0, 0.0]], "the last frame");
}

/// Two triangles; one animation lifts the first, one the second, and one pushes the first aside.
fn actions() -> Writer {
    let mut writer = Writer::new();
    let mesh = writer.triangle();
    for x in [-5.0, 5.0] {
        writer.push("nodes", json!({ "mesh": mesh, "translation": [x, 0, 0] }));
    }
    let times = [[0.0, 2.0], [0.0, 1.0], [0.0, 4.0]].map(|times| writer.floats("SCALAR", &times));
    let moves = [[[-5.0, 0.0, 0.0], [-5.0, 8.0, 0.0]], [[5.0, 0.0, 0.0], [5.0, 8.0, 0.0]], [[0.0; 3], [9.0, 0.0, 0.0]]];
    for (i, (name, node)) in [("leftAction", 0), ("rightAction", 1), ("push", 0)].into_iter().enumerate() {
        let output = writer.vec3(&moves[i]);
        writer.push(
            "animations",
            json!({ "name": name, "samplers": [{ "input": times[i], "output": output }],
                "channels": [{ "sampler": 0, "target": { "node": node, "path": "translation" } }] }),
        );
    }
    writer
}

#[test]
fn animations_of_different_things_play_together_and_are_named() {
    let at = |options: &Options, seconds: f64| {
        let mut loaded = actions().load_with(options).unwrap_or_else(|error| panic!("{error}"));
        let places = places(&frame(&mut loaded, seconds));
        let played: Vec<bool> = loaded.clips.iter().map(|clip| clip.is_played).collect();
        ([places[0][0], places[1][0]], played, loaded)
    };
    let (places, played, loaded) = at(&Options::default(), 0.5);
    assert_near(&places, &[[-5.0, 2.0, 0.0], [5.0, 4.0, 0.0]], "both move");
    assert_eq!(played, [true, true, false]);
    assert_eq!(loaded.world.animation.duration(), 2.0);
    let names: Vec<_> = loaded.clips.iter().map(|clip| clip.name.as_deref()).collect();
    assert_eq!(names, [Some("leftAction"), Some("rightAction"), Some("push")]);
    let note =
        "of 3 animations, 0 \"leftAction\", 1 \"rightAction\" are played together; the others move what these move";
    assert_eq!(loaded.notes, [note]);
    assert_near(&at(&Options::default(), 1.5).0[1..], &[[5.0, 8.0, 0.0]], "the shorter waits at its end");

    for (clip, places, chosen) in [
        (Clip::Index(0), [[-5.0, 2.0, 0.0], [5.0, 0.0, 0.0]], 0),
        (Clip::Name("rightAction".into()), [[-5.0, 0.0, 0.0], [5.0, 4.0, 0.0]], 1),
        (Clip::Name("push".into()), [[1.125, 0.0, 0.0], [5.0, 0.0, 0.0]], 2),
    ] {
        let (found, played, loaded) = at(&Options::new().clip(clip), 0.5);
        assert_near(&found, &places, "one alone");
        assert!((0..3).all(|i| played[i] == (i == chosen)), "{played:?}");
        assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
    }
}

#[test]
fn instances_of_a_node_stand_where_their_attributes_say() {
    for required in [false, true] {
        let mut writer = Writer::new();
        let mesh = writer.triangle();
        let translations = writer.vec3(&[[-4.0, 0.0, 0.0], [0.0; 3], [4.0, 0.0, 0.0]]);
        let half = 0.5f32.sqrt();
        let rotations = writer.floats("VEC4", &[[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, half, half], [0.0; 4]].concat());
        let scales = writer.vec3(&[[1.0; 3], [2.0, 3.0, 1.0], [1.0; 3]]);
        let attributes = json!({ "TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales, "_ID": 99 });
        let extensions = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
        writer.push("nodes", json!({ "mesh": mesh, "translation": [0, 1, 0], "extensions": extensions }));
        writer.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
        if required {
            writer.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
        }
        let mut loaded = writer.good();
        let places = places(&frame(&mut loaded, 0.0));
        assert_eq!((places.len(), loaded.notes.len()), (3, 0), "{:?}", loaded.notes);
        assert_near(&places[0], &[[-4.0, 1.0, 0.0], [-3.0, 1.0, 0.0], [-4.0, 2.0, 0.0]], "moved");
        assert_near(&places[1], &[[0.0, 1.0, 0.0], [0.0, 3.0, 0.0], [-3.0, 1.0, 0.0]], "scaled, then turned");
        assert_near(&places[2], &[[4.0, 1.0, 0.0], [5.0, 1.0, 0.0], [4.0, 2.0, 0.0]], "no rotation at all");
    }
    let mut uneven = Writer::new();
    let mesh = uneven.triangle();
    let [three, two] = [3, 2].map(|count| uneven.vec3(&vec![[1.0; 3]; count]));
    let extension = |attributes: Value| json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    uneven
        .push("nodes", json!({ "mesh": mesh, "extensions": extension(json!({ "TRANSLATION": three, "SCALE": two })) }));
    assert_eq!(uneven.bad(), "node 0 has instances with more of one attribute than of another");
    let unbounded = uneven.vec3(&[[0.0; 3], [f32::NAN; 3]]);
    uneven.json["nodes"][0]["extensions"] = extension(json!({ "TRANSLATION": unbounded }));
    assert_eq!(uneven.bad(), "node 0 has an instance, 1, whose placement is not finite");
    // A hundred bytes that ask for millions of instances.
    let zeros = uneven.push("accessors", json!({ "componentType": 5126, "count": 4_000_000, "type": "VEC3" }));
    uneven.json["nodes"][0]["extensions"] = extension(json!({ "TRANSLATION": zeros }));
    assert!(uneven.bad().starts_with("asks for more data"), "{}", uneven.bad());
}

#[test]
fn instances_of_an_animated_or_deformed_node_move_and_deform_with_it() {
    let mut writer = slope();
    let aside = writer.vec3(&[[0.0; 3], [10.0, 0.0, 0.0]]);
    writer.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": aside } } });
    writer.animate(0, "weights", &[0.0, 1.0], &[0.0, 1.0], "LINEAR");
    writer.animate(0, "translation", &[0.0, 1.0], &[0.0, 0.0, 0.0, 0.0, 0.0, 7.0], "LINEAR");
    let places = places(&frame(&mut writer.good(), 1.0));
    assert_eq!(places.len(), 2);
    let shifted: Vec<_> = places[0].iter().map(|&[x, y, z]| [x + 10.0, y, z]).collect();
    assert_near(&places[1], &shifted, "the same pose, elsewhere");
    let highest = places[0].iter().map(|place| place[2]).fold(0.0, f32::max);
    assert!((highest - 7.0 - 2.0 * 3f32.sqrt()).abs() < 1e-4, "{highest}");
}

#[test]
fn a_scale_of_zero_along_one_axis_shows_a_flat_shape() {
    let mut writer = Writer::new();
    let positions = writer.vec3(&[[0.0, 0.0, 1.0], [1.0, 0.0, -2.0], [0.0, 1.0, 3.0]]);
    let mesh = writer.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions } }] }));
    writer.push("nodes", json!({ "mesh": mesh, "scale": [1, 1, 0], "translation": [0, 0, 5] }));
    let mut loaded = writer.good();
    let view = frame(&mut loaded, 0.0);
    assert!(view.report().left_out.is_empty() && loaded.notes.is_empty(), "{:?}", loaded.notes);
    for side in [1.0, -1.0] {
        let hit = view.closest_hit(&Ray::new([0.25, 0.25, 5.0 + side], [0.0, 0.0, -side])).expect("a hit");
        assert!((hit.t - 1.0).abs() < 1e-5, "{}", hit.t);
    }
}
