//! `kinetree bake` and `--trees`: baked trees give the same results as built ones, or are refused
//! by name.

mod common;

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use common::{Sandbox, errors_of, triangle};
use serde_json::Value;

const SMALL: &str = "--size 64x36 --spp 2 --time 1";

#[test]
fn the_picture_with_baked_trees_is_the_one_with_built_trees() {
    let sandbox = Sandbox::new();
    sandbox.succeed("bake --out race.trees");
    sandbox.succeed(&format!("render {SMALL} --out built.png"));
    let text = sandbox.succeed(&format!("render {SMALL} --trees race.trees --out loaded.png"));
    assert!(text.contains("trees from a file"), "{text}");
    let [built, loaded] = ["built.png", "loaded.png"].map(|name| fs::read(sandbox.path(name)).unwrap());
    assert!(built == loaded);
    sandbox.picture("loaded.png", (64, 36));
}

#[test]
fn every_static_and_rigid_mesh_has_a_tree_in_the_file_and_takes_it() {
    let sandbox = Sandbox::new();
    let baked = sandbox.json("bake --out deep/race.trees --json");
    assert_eq!((&baked["file"], &baked["quality"]), (&"deep/race.trees".into(), &"best".into()));
    assert_eq!(sandbox.files(), [sandbox.path("deep/race.trees")], "one file, whole, and nothing beside it");
    assert_eq!(fs::metadata(sandbox.path("deep/race.trees")).unwrap().len(), baked["bytes"].as_u64().unwrap());

    let plain = sandbox.json("inspect --json");
    let json = sandbox.json("inspect --trees deep/race.trees --json");
    let meshes = json["meshes"].as_array().unwrap();
    let mut served: Vec<u64> = Vec::new();
    for tree in baked["trees"].as_array().unwrap() {
        for mesh in tree["meshes"].as_array().unwrap() {
            let number = mesh.as_u64().unwrap();
            served.push(number);
            let seen = &meshes[number as usize];
            assert_eq!(seen["seen"]["motion"], tree["motion"], "mesh {number}");
            assert_eq!(seen["triangles"], tree["triangles"], "mesh {number}");
            assert_eq!(seen["seen"]["tree"]["nodes"], tree["nodes"], "mesh {number}");
            assert_eq!(seen["seen"]["tree"]["cost"], tree["cost"], "mesh {number}");
            assert_eq!(seen["seen"]["tree"]["valid"], true, "mesh {number}");
        }
    }
    served.sort_unstable();
    let expected: Vec<u64> = (0..meshes.len() as u64)
        .filter(|&number| ["static", "rigid"].contains(&meshes[number as usize]["seen"]["motion"].as_str().unwrap()))
        .collect();
    assert_eq!(served, expected);
    assert_eq!(json["first_commit"]["loaded"].as_u64(), Some(expected.len() as u64));
    assert_eq!(plain["first_commit"]["loaded"], 0);
    let built = |json: &Value| json["first_commit"]["built"].as_u64().unwrap();
    assert_eq!(built(&json) + expected.len() as u64, built(&plain));
    assert_eq!(baked["left_out"].as_u64(), Some(meshes.len() as u64 - expected.len() as u64));
}

#[test]
fn the_same_scene_gives_the_same_file_for_any_threads() {
    let sandbox = Sandbox::new();
    sandbox.succeed("bake --threads 1 --out one.trees");
    sandbox.succeed("bake --threads 2 --out two.trees");
    let [one, two] = ["one.trees", "two.trees"].map(|name| fs::read(sandbox.path(name)).unwrap());
    assert!(one == two);
}

#[test]
fn a_file_is_named_after_its_scene_and_quiet_says_nothing() {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("small.gltf"));
    assert!(sandbox.succeed("bake small.gltf").starts_with("small.trees\n"));
    assert!(sandbox.path("small.trees").is_file());
    let output = sandbox.run("bake small.gltf --quiet --out again.trees");
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
    sandbox.succeed("render small.gltf --trees again.trees --size 20x20 --spp 1");
    sandbox.picture("small.png", (20, 20));
}

#[test]
fn trees_of_another_scene_are_refused_with_the_way_out() {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("small.gltf"));
    sandbox.succeed("bake small.gltf --out small.trees");
    // The same scene with another vertex: the third position ends with (0, 2, 0).
    let text = fs::read_to_string(sandbox.path("small.gltf")).unwrap();
    let moved = text.replace("AAAAgD8AAAAA", "AAAAAEAAAAAA");
    assert_ne!(moved, text);
    fs::write(sandbox.path("moved.gltf"), moved).unwrap();
    for command in ["render moved.gltf --out never.png", "inspect moved.gltf"] {
        let complaint = sandbox.fail_in_one_line(&format!("{command} --trees small.trees"));
        for part in ["small.trees", "mesh 0 of moved.gltf", "kinetree bake moved.gltf --out small.trees"] {
            assert!(complaint.contains(part), "no {part:?} in {complaint}");
        }
    }
    let complaint = sandbox.fail_in_one_line("inspect --trees small.trees");
    assert!(
        complaint.contains("mesh 0 of the built-in race") && complaint.contains("kinetree bake --out"),
        "{complaint}"
    );
}

#[test]
fn files_that_are_no_trees_are_named_in_one_line_and_leave_nothing() {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("small.gltf"));
    sandbox.succeed("bake small.gltf --out whole.trees");
    let whole = fs::read(sandbox.path("whole.trees")).unwrap();
    fs::write(sandbox.path("cut.trees"), &whole[..whole.len() / 2]).unwrap();
    fs::write(sandbox.path("longer.trees"), [&whole[..], b"!"].concat()).unwrap();
    fs::write(sandbox.path("empty.trees"), b"").unwrap();
    fs::create_dir(sandbox.path("folder.trees")).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() * 2 / 3] ^= 0x10;
    fs::write(sandbox.path("flipped.trees"), flipped).unwrap();
    let mut later = whole;
    later[8] = 9;
    fs::write(sandbox.path("later.trees"), later).unwrap();
    let files = ["missing", "cut", "longer", "empty", "folder", "flipped", "later"].map(|name| format!("{name}.trees"));
    for file in files.iter().map(String::as_str).chain(["small.gltf"]) {
        let complaint = sandbox.fail_in_one_line(&format!("render small.gltf --trees {file} --out never.png"));
        assert!(complaint.contains(file), "{complaint}");
        assert!(sandbox.fail_in_one_line(&format!("inspect small.gltf --trees {file} --json")).contains(file));
    }
}

#[test]
fn a_bake_that_fails_leaves_no_file() {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("small.gltf"));
    fs::create_dir(sandbox.path("taken.trees")).unwrap();
    for args in ["bake missing.glb", "bake small.gltf --out taken.trees", "bake small.gltf --out small.gltf/a.trees"] {
        sandbox.fail_in_one_line(args);
    }
    sandbox.fail("bake --quality best", 2);
    sandbox.fail("render --trees", 2);
}

#[test]
fn shared_scenes_show_the_same_with_baked_trees() {
    let Some(folder) = std::env::var_os("KINETREE_SCENES") else {
        println!("SKIPPED: KINETREE_SCENES names no folder of scenes");
        return;
    };
    let sandbox = Sandbox::new();
    for name in ["stanford_bunny.glb", "thin_diagonals_a.glb", "teapot_in_stadium_a.glb", "skinned_karts_a.glb"] {
        let scene = PathBuf::from(&folder).join(name);
        if !scene.is_file() {
            println!("SKIPPED: {name} is not among the scenes");
            continue;
        }
        let scene = fs::canonicalize(scene).unwrap();
        let run = |command: &str, options: &str| {
            let mut program = Command::new(env!("CARGO_BIN_EXE_kinetree"));
            program.current_dir(sandbox.path(".")).arg(command).arg(&scene).args(options.split_whitespace());
            let output = program.output().expect("the program starts");
            assert!(output.status.success(), "{command} {name}: {}", errors_of(&output));
            output.stdout
        };
        run("bake", "--out a.trees");
        run("render", "--size 160x120 --spp 2 --integrator ids --out built.png");
        run("render", "--size 160x120 --spp 2 --integrator ids --trees a.trees --out loaded.png");
        let [built, loaded] = ["built.png", "loaded.png"].map(|name| fs::read(sandbox.path(name)).unwrap());
        assert!(built == loaded, "{name}");
        let json: Value = serde_json::from_slice(&run("inspect", "--trees a.trees --json")).unwrap();
        for mesh in json["meshes"].as_array().unwrap() {
            assert_eq!(mesh["seen"]["tree"]["valid"], true, "{name}: {mesh:#}");
        }
    }
}
