//! Runs the program in a temporary folder.

#![allow(dead_code, unreachable_pub, reason = "each test uses its part")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

/// A temporary folder that the program runs in.
pub struct Sandbox(TempDir);

impl Sandbox {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("there is room for a directory"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn run(&self, args: &str) -> Output {
        let args = args.split_whitespace();
        let program = env!("CARGO_BIN_EXE_kinetree");
        Command::new(program).args(args).current_dir(self.0.path()).output().expect("the program starts")
    }

    /// Runs a command that must succeed, and returns its standard output.
    pub fn succeed(&self, args: &str) -> String {
        let output = self.run(args);
        assert!(output.status.success(), "{args}: {}", errors_of(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    pub fn json(&self, args: &str) -> Value {
        serde_json::from_str(&self.succeed(args)).expect("standard output is one JSON object and nothing else")
    }

    /// Runs a command that must fail with this exit code and write no file, and returns its
    /// standard error.
    pub fn fail(&self, args: &str, code: i32) -> String {
        let before = self.files();
        let output = self.run(args);
        let errors = errors_of(&output);
        assert_eq!(output.status.code(), Some(code), "{args}: {errors}");
        assert!(output.stdout.is_empty(), "{args}");
        assert_eq!(self.files(), before, "{args}");
        assert!(!errors.contains("panicked"), "{args}: {errors}");
        errors
    }

    /// As [`Sandbox::fail`] with code 1; the error must be one line.
    pub fn fail_in_one_line(&self, args: &str) -> String {
        let errors = self.fail(args, 1);
        assert_eq!(errors.trim_end().lines().count(), 1, "{args}: {errors}");
        errors
    }

    pub fn files(&self) -> Vec<PathBuf> {
        fn all_in(directory: &Path, files: &mut Vec<PathBuf>) {
            for entry in fs::read_dir(directory).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    all_in(&path, files);
                } else {
                    files.push(path);
                }
            }
        }
        let mut files = Vec::new();
        all_in(self.0.path(), &mut files);
        files.sort();
        files
    }

    /// The pixels of a picture, which must have this size and more than one colour.
    pub fn picture(&self, name: &str, size: (u32, u32)) -> Vec<u8> {
        let picture = image::open(self.path(name)).expect("a whole PNG").to_rgb8();
        assert_eq!(picture.dimensions(), size, "{name}");
        let first = picture.get_pixel(0, 0);
        assert!(picture.pixels().any(|pixel| pixel != first), "{name} has one colour");
        picture.into_raw()
    }
}

pub fn errors_of(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A glTF file with one triangle, no camera and no light, without external buffers.
pub fn triangle(file: &Path) {
    // Three positions, little-endian: (0, 0, 0), (1, 0, 0), (0, 1, 0), in base 64.
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                            "min": [0, 0, 0], "max": [1, 1, 0]}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
            "buffers": [{{"byteLength": 36, "uri": "data:application/octet-stream;base64,{data}"}}]}}"#
    );
    fs::write(file, text).unwrap();
}
