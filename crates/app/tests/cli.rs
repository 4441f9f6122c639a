//! The program as its users see it: files, figures, exit codes.

mod common;

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use common::{Sandbox, errors_of, triangle};
use serde_json::Value;

#[test]
fn the_race_becomes_a_picture_and_a_summary() {
    let sandbox = Sandbox::new();
    let text = sandbox.succeed("render --size 64x36 --spp 2 --time 1 --out race.png");
    sandbox.picture("race.png", (64, 36));
    for figure in ["camera", "kernel", "FPS", "samples per pixel", "time       1.000 s", "memory", "Mrays/s", "frame"] {
        assert!(text.contains(figure), "no {figure:?} in\n{text}");
    }
    assert_eq!(sandbox.files().len(), 1);
}

#[test]
fn the_summary_as_json_has_the_figures() {
    let sandbox = Sandbox::new();
    let json = sandbox.json("render --size 48x27 --spp 3 --seed 5 --json --out a.png");
    assert_eq!((&json["width"], &json["height"], &json["samples_per_pixel"]), (&48.into(), &27.into(), &3.into()));
    assert_eq!((&json["seed"], &json["integrator"]), (&5.into(), &"path".into()));
    let positive = |value: &Value| assert!(value.as_f64().is_some_and(|number| number > 0.0), "{value} in {json:#}");
    for name in ["kernel_ms", "frame_ms", "fps", "rays", "mrays_per_s"] {
        positive(&json["total"][name]);
        positive(&json["frames"][0][name]);
    }
    positive(&json["load_ms"]);
    positive(&json["first_commit"]["total_ms"]);
    positive(&json["memory"]["scene"]);
    positive(&json["scene"]["triangles"]);
    // Every sample of this picture is one camera ray at least.
    assert!(json["total"]["rays"].as_u64().unwrap() >= 48 * 27 * 3);
    assert!(json["scene"]["instanced_triangles"].as_u64() > json["scene"]["triangles"].as_u64());
    let frames = json["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 1);
    assert_eq!((&frames[0]["file"], &frames[0]["lost_samples"]), (&"a.png".into(), &0.into()));
    assert!(frames[0]["camera"]["position"].as_array().unwrap().iter().all(Value::is_number));
    assert!(frames[0]["exposure_ev"].is_number());
}

#[test]
fn a_sequence_gives_numbered_pictures_of_a_moving_scene_with_one_exposure() {
    let sandbox = Sandbox::new();
    let json =
        sandbox.json("render --frames 3..6 --fps 4 --size 80x45 --spp 1 --camera chase --json --out lap/%04d.png");
    let frames = json["frames"].as_array().unwrap();
    let times: Vec<f64> = frames.iter().map(|frame| frame["time_s"].as_f64().unwrap()).collect();
    assert_eq!(times, [0.75, 1.0, 1.25]);
    assert!(frames.iter().all(|frame| frame["exposure_ev"] == frames[0]["exposure_ev"]));
    assert_ne!(frames[0]["camera"]["position"], frames[2]["camera"]["position"], "the camera rides with the car");
    let pictures = ["lap/0003.png", "lap/0004.png", "lap/0005.png"].map(|name| sandbox.picture(name, (80, 45)));
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2]);
    assert_eq!(sandbox.files().len(), 3);
}

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads_but_on_the_seed() {
    let sandbox = Sandbox::new();
    sandbox.succeed("render --size 64x36 --spp 2 --threads 1 --out one.png");
    sandbox.succeed("render --size 64x36 --spp 2 --threads 2 --out two.png");
    sandbox.succeed("render --size 64x36 --spp 2 --seed 1 --out other.png");
    let [one, two, other] = ["one.png", "two.png", "other.png"].map(|name| fs::read(sandbox.path(name)).unwrap());
    assert!(one == two);
    assert!(one != other);
}

#[test]
fn every_integrator_makes_a_picture() {
    let sandbox = Sandbox::new();
    let kinds = ["path", "simple", "ambient", "heatmap", "normals", "ids", "motion"];
    let pictures = kinds.map(|kind| {
        sandbox.succeed(&format!("render --size 40x30 --spp 1 --time 2 --integrator {kind} --out {kind}.png"));
        sandbox.picture(&format!("{kind}.png"), (40, 30))
    });
    for (i, picture) in pictures.iter().enumerate() {
        assert!(!pictures[..i].contains(picture), "{} shows what another shows", kinds[i]);
    }
}

#[test]
fn a_file_without_camera_and_light_is_framed_and_lit_and_names_the_picture() {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("small.gltf"));
    let text = sandbox.succeed("render small.gltf --size 40x30 --spp 4");
    assert!(
        text.starts_with("small.png\n") && text.contains("1 triangle in 1 mesh, 1 triangle in 1 instance"),
        "{text}"
    );
    sandbox.picture("small.png", (40, 30));
    let json = sandbox.json("inspect small.gltf --json");
    assert_eq!(json["scene"]["has_default_lighting"], true);
    assert_eq!(json["meshes"][0]["triangles"], 1);
}

#[test]
fn a_placed_camera_stands_where_it_was_put_and_exposure_is_as_asked() {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("small.gltf"));
    let camera = "--camera -1,2.5,3:0.5,0.5,0:40";
    let json = sandbox.json(&format!("render small.gltf --size 20x20 --spp 1 --json {camera} --exposure -1.5"));
    let frame = &json["frames"][0];
    assert_eq!(frame["camera"]["position"], serde_json::json!([-1.0, 2.5, 3.0]));
    assert!((frame["camera"]["fov_degrees"].as_f64().unwrap() - 40.0).abs() < 1e-3);
    assert!((frame["exposure_ev"].as_f64().unwrap() + 1.5).abs() < 1e-5);
}

#[test]
fn quiet_says_nothing() {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("small.gltf"));
    for args in ["render small.gltf --size 8x8 --spp 1 --quiet", "inspect small.gltf --quiet"] {
        let output = sandbox.run(args);
        assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty(), "{args}");
    }
}

#[test]
fn files_that_are_no_scenes_are_named_in_one_line_and_leave_nothing() {
    let sandbox = Sandbox::new();
    fs::write(sandbox.path("short.glb"), b"glTF\x02\0\0\0\xff\xff\0\0\x10\0\0\0JSON{}").unwrap();
    fs::write(sandbox.path("empty.glb"), b"").unwrap();
    fs::write(sandbox.path("noise.gltf"), b"\x80\xff{ no JSON").unwrap();
    fs::write(sandbox.path("car.obj"), b"v 0 0 0").unwrap();
    fs::create_dir(sandbox.path("folder.glb")).unwrap();
    let files = ["missing.glb", "short.glb", "empty.glb", "noise.gltf", "car.obj", "bare", "car.fbx", "folder.glb"];
    for file in files {
        let complaint = sandbox.fail_in_one_line(&format!("render {file} --out never.png"));
        assert!(complaint.contains(file), "{complaint}");
        assert!(sandbox.fail_in_one_line(&format!("inspect {file} --json")).contains(file));
    }
    let obj = sandbox.fail_in_one_line("render car.obj --out never.png");
    assert!(obj.contains(".glb and .gltf"), "{obj}");
}

#[test]
fn a_whole_file_cut_short_anywhere_is_an_error_or_a_scene_but_never_a_panic() {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("whole.gltf"));
    let whole = fs::read(sandbox.path("whole.gltf")).unwrap();
    for length in (0..whole.len()).step_by(whole.len() / 12) {
        fs::write(sandbox.path("cut.gltf"), &whole[..length]).unwrap();
        sandbox.fail_in_one_line("render cut.gltf --size 8x8 --out never.png");
    }
}

#[test]
fn places_that_cannot_be_written_are_named() {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("small.gltf"));
    fs::create_dir(sandbox.path("taken.png")).unwrap();
    for out in ["taken.png", "small.gltf/a.png"] {
        let complaint = sandbox.fail_in_one_line(&format!("render small.gltf --size 8x8 --spp 1 --out {out}"));
        assert!(complaint.contains(out), "{complaint}");
    }
}

#[test]
fn a_rendering_that_is_broken_off_leaves_no_file() {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("small.gltf"));
    let before = sandbox.files();
    let mut endless = Command::new(env!("CARGO_BIN_EXE_kinetree"))
        .args(["render", "small.gltf", "--size", "64x64", "--spp", "4000000", "--quiet", "--out", "never.png"])
        .current_dir(sandbox.path("."))
        .spawn()
        .expect("the program starts");
    std::thread::sleep(std::time::Duration::from_millis(500));
    assert!(endless.try_wait().unwrap().is_none(), "it is still at work");
    endless.kill().unwrap();
    endless.wait().unwrap();
    assert_eq!(sandbox.files(), before);
}

#[test]
fn wrong_arguments_end_with_two() {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("small.gltf"));
    let wrong = [
        "paint",
        "render --size 0x5",
        "render --size 960",
        "render --size 65536x65536",
        "render --spp 0",
        "render --spp -1",
        "render --seed x",
        "render --time nan",
        "render --frames 5..5 --out %d.png",
        "render --frames 0..2 --out one.png",
        "render --frames 0..2 --time 1 --out %d.png",
        "render --frames 0..2 --fps 0 --out %d.png",
        "render --fps 12",
        "render --out a.exr",
        "render --out a.jpg",
        "render --out a",
        "render --out %d-%d.png",
        "render --integrator magic",
        "render --exposure bright",
        "render --threads 0",
        "render small.gltf --camera 1,2:3,4,5",
        "render small.gltf --camera 1,1,1:1,1,1",
        "render small.gltf --camera south",
        "inspect --time soon",
    ];
    for args in wrong {
        sandbox.fail(args, 2);
    }
}

#[test]
fn an_unknown_camera_is_answered_with_those_there_are() {
    let sandbox = Sandbox::new();
    let complaint = sandbox.fail("render --camera south --out never.png", 2);
    assert!(
        complaint.contains("south") && complaint.contains("\"track\"") && complaint.contains("\"chase\""),
        "{complaint}"
    );
}

#[test]
fn what_is_wrong_with_the_output_is_said_before_any_work() {
    let sandbox = Sandbox::new();
    let exr = sandbox.fail("render missing.glb --out a.exr", 2);
    assert!(exr.contains("a.exr") && exr.contains("EXR"), "{exr}");
}

/// Every tree in an inspection keeps its promises, and none was left out of the check.
fn check_inspection(json: &Value) {
    assert_eq!(json["top_level"]["valid"], true, "{:#}", json["top_level"]);
    let meshes = json["meshes"].as_array().unwrap();
    assert_eq!(meshes.len() as u64, json["scene"]["meshes"].as_u64().unwrap());
    for mesh in meshes {
        assert_eq!(mesh["seen"]["tree"]["valid"], true, "{mesh:#}");
        // Exactly the meshes without triangles have no nodes, whether or not they have instances.
        let [triangles, nodes] =
            [&mesh["triangles"], &mesh["seen"]["tree"]["nodes"]].map(|count| count.as_u64().unwrap());
        assert_eq!(triangles > 0, nodes > 0, "{mesh:#}");
    }
    assert!(meshes.iter().any(|mesh| mesh["seen"]["tree"]["nodes"].as_u64() > Some(0)));
}

#[test]
fn the_race_is_inspected_and_every_tree_keeps_its_promises() {
    let sandbox = Sandbox::new();
    let json = sandbox.json("inspect --time 3.5 --json");
    check_inspection(&json);
    for motion in json["motions"].as_array().unwrap() {
        assert!(motion["meshes"].as_u64() > Some(0), "the race has every kind of motion: {motion:#}");
    }
    let text = sandbox.succeed("inspect --time 3.5");
    assert!(text.contains("more (--all lists them)"), "{text}");
    assert!(sandbox.succeed("inspect --time 3.5 --all").lines().count() > text.lines().count());
}

#[test]
fn help_and_version_are_there() {
    let sandbox = Sandbox::new();
    assert!(sandbox.succeed("--version").contains(env!("CARGO_PKG_VERSION")));
    for args in ["--help", "render --help", "inspect --help", "bake --help"] {
        assert!(sandbox.succeed(args).contains("Examples:"), "{args}");
    }
    assert!(sandbox.succeed("render --help").contains("[default: 1280x720]"));
}

#[test]
fn every_shared_scene_has_valid_trees() {
    let Some(folder) = std::env::var_os("KINETREE_SCENES") else {
        println!("SKIPPED: KINETREE_SCENES names no folder of scenes");
        return;
    };
    let mut scenes: Vec<PathBuf> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    scenes.retain(|path| path.extension().is_some_and(|extension| extension == "glb"));
    scenes.sort();
    assert!(!scenes.is_empty(), "there are no scenes in {}", folder.display());
    for scene in scenes {
        let program = Command::new(env!("CARGO_BIN_EXE_kinetree"))
            .args(["inspect", "--json", "--time", "1.7"])
            .arg(fs::canonicalize(&scene).unwrap())
            .output()
            .expect("the program starts");
        assert!(program.status.success(), "{}: {}", scene.display(), errors_of(&program));
        check_inspection(&serde_json::from_slice(&program.stdout).unwrap());
    }
}

/// A triangle with two animations: "go" of 1 s moves it aside, "rise" of 2 s moves it up.
fn two_clips(file: &std::path::Path) {
    let floats: Vec<f32> = [vec![0.0; 9], vec![0.0, 1.0], vec![0.0, 2.0], vec![0.0, 0.0, 0.0, 3.0, 0.0, 0.0]].concat();
    let data: String = floats.iter().flat_map(|x| x.to_le_bytes()).map(|byte| format!("%{byte:02x}")).collect();
    let (mut views, mut accessors) = (Vec::new(), Vec::new());
    for (start, count, shape, width) in
        [(0, 3, "VEC3", 3), (9, 2, "SCALAR", 1), (11, 2, "SCALAR", 1), (13, 2, "VEC3", 3)]
    {
        views.push(serde_json::json!({ "buffer": 0, "byteOffset": 4 * start, "byteLength": 4 * count * width }));
        let view = views.len() - 1;
        accessors.push(serde_json::json!({ "bufferView": view, "componentType": 5126, "count": count, "type": shape }));
    }
    let clip = |name: &str, input: usize, path: &str| {
        serde_json::json!({ "name": name, "samplers": [{ "input": input, "output": 3 }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": path } }] })
    };
    let text = serde_json::json!({
        "asset": { "version": "2.0" }, "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "buffers": [{ "byteLength": 4 * floats.len(), "uri": format!("data:,{data}") }],
        "bufferViews": views, "accessors": accessors,
        "animations": [clip("go", 1, "translation"), clip("rise", 2, "translation")],
    });
    fs::write(file, text.to_string()).unwrap();
}

#[test]
fn clips_are_listed_and_chosen() {
    let sandbox = Sandbox::new();
    two_clips(&sandbox.path("clips.gltf"));
    let text = sandbox.succeed("inspect clips.gltf");
    assert!(text.contains("  clips      0 \"go\", 1 \"rise\" (not played)\n"), "{text}");
    for (choice, played, duration) in
        [("", [true, false], 1.0), ("--clip rise", [false, true], 2.0), ("--clip 1", [false, true], 2.0)]
    {
        let json = sandbox.json(&format!("inspect clips.gltf --json {choice}"));
        let found: Vec<bool> = json["clips"].as_array().unwrap().iter().map(|c| c["is_played"] == true).collect();
        assert_eq!((found, json["scene"]["duration_s"].as_f64()), (played.to_vec(), Some(duration)), "{choice}");
    }
    for command in ["inspect clips.gltf", "render clips.gltf", "bake clips.gltf"] {
        let error = sandbox.fail_in_one_line(&format!("{command} --clip fly"));
        assert!(error.contains("has no animation \"fly\": it has 2: 0 \"go\", 1 \"rise\""), "{error}");
    }
    sandbox.fail("inspect --clip go", 2);
}
