//! Bugs of the program that were repaired, with the right values.

mod common;

use std::fs;
use std::process::Command;

use common::{Sandbox, errors_of, triangle};

/// A mesh whose only instance is scaled to nothing.
fn hidden(sandbox: &Sandbox) {
    triangle(&sandbox.path("small.gltf"));
    let text = fs::read_to_string(sandbox.path("small.gltf")).unwrap();
    let changed = text.replace(r#""nodes": [{"mesh": 0}]"#, r#""nodes": [{"mesh": 0, "scale": [0, 0, 0]}]"#);
    assert_ne!(changed, text);
    fs::write(sandbox.path("hidden.gltf"), changed).unwrap();
}

#[test]
fn meshes_that_no_instance_shows_are_inspected_too() {
    let sandbox = Sandbox::new();
    hidden(&sandbox);
    let json = sandbox.json("inspect hidden.gltf --json");
    let mesh = &json["meshes"][0];
    assert_eq!((&mesh["triangles"], &mesh["instances"]), (&1.into(), &0.into()));
    assert_eq!((&mesh["seen"]["motion"], &mesh["seen"]["vertices"]), (&"static".into(), &3.into()));
    assert_eq!((&mesh["seen"]["tree"]["valid"], &mesh["seen"]["tree"]["nodes"]), (&true.into(), &1.into()));
    let of_static = &json["motions"].as_array().unwrap().iter().find(|motion| motion["motion"] == "static").unwrap();
    assert_eq!((&of_static["meshes"], &of_static["instances"]), (&1.into(), &0.into()));
    let text = sandbox.succeed("inspect hidden.gltf");
    assert!(text.lines().any(|line| line.contains("mesh 0") && line.contains("kept")), "{text}");
}

#[test]
fn a_level_that_is_none_ends_with_two_and_those_there_are() {
    let sandbox = Sandbox::new();
    triangle(&sandbox.path("small.gltf"));
    let run = |value: &str| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_kinetree"));
        program.args(["inspect", "small.gltf", "--quiet"]).current_dir(sandbox.path(".")).env("KINETREE_SIMD", value);
        program.output().expect("the program starts")
    };
    for wrong in ["nonsense", "AVX2", "avx1024"] {
        let output = run(wrong);
        assert_eq!(output.status.code(), Some(2), "{wrong}");
        let complaint = errors_of(&output);
        assert!(complaint.contains(wrong) && complaint.contains("scalar"), "{complaint}");
        assert_eq!(complaint.trim_end().lines().count(), 1, "{complaint}");
    }
    for right in ["", "scalar"] {
        let output = run(right);
        assert!(output.status.success() && output.stderr.is_empty(), "{right}: {}", errors_of(&output));
    }
}
