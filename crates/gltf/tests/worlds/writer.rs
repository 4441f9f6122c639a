//! Writes small glTF files.

use std::io::Write;
use std::path::PathBuf;

use kinetree::Snapshot;
use kinetree_gltf::{LoadError, LoadedWorld, Options};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A file in the making: JSON that a test may edit, and one buffer.
pub(crate) struct Writer {
    pub(crate) json: Value,
    pub(crate) bytes: Vec<u8>,
}

impl Writer {
    pub(crate) fn new() -> Self {
        let json = json!({ "asset": { "version": "2.0" }, "bufferViews": [], "accessors": [] });
        Self { json, bytes: Vec::new() }
    }

    /// Takes top-level properties over from an object.
    pub(crate) fn with(mut self, properties: Value) -> Self {
        for (key, value) in properties.as_object().expect("an object") {
            self.json[key] = value.clone();
        }
        self
    }

    /// Appends to one of the top-level arrays; returns the index.
    pub(crate) fn push(&mut self, array: &str, value: Value) -> usize {
        if self.json[array].is_null() {
            self.json[array] = json!([]);
        }
        let array = self.json[array].as_array_mut().expect("an array");
        array.push(value);
        array.len() - 1
    }

    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        while self.bytes.len() % 4 != 0 {
            self.bytes.push(0);
        }
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, size: usize, shape: &str) -> usize {
        let view = self.view(bytes);
        let width = match shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            other => panic!("no shape {other}"),
        };
        let count = bytes.len() / (width * size);
        self.push("accessors", json!({ "bufferView": view, "componentType": component, "count": count, "type": shape }))
    }

    pub(crate) fn floats(&mut self, shape: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, 4, shape)
    }

    pub(crate) fn vec3(&mut self, values: &[[f32; 3]]) -> usize {
        self.floats("VEC3", values.as_flattened())
    }

    pub(crate) fn u8(&mut self, shape: &str, values: &[u8]) -> usize {
        self.accessor(values, 5121, 1, shape)
    }

    pub(crate) fn u16(&mut self, shape: &str, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(&bytes, 5123, 2, shape)
    }

    pub(crate) fn u32(&mut self, shape: &str, values: &[u32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(&bytes, 5125, 4, shape)
    }

    /// The right triangle at (0, 0, 0), (1, 0, 0), (0, 1, 0), as a mesh without indices.
    pub(crate) fn triangle(&mut self) -> usize {
        let positions = self.vec3(&TRIANGLE);
        self.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions } }] }))
    }

    /// A linear animation of one property of one node, as the next channel of the first animation.
    pub(crate) fn animate(&mut self, node: usize, path: &str, times: &[f32], values: &[f32], interpolation: &str) {
        let input = self.floats("SCALAR", times);
        let shape = match path {
            "rotation" => "VEC4",
            "weights" => "SCALAR",
            _ => "VEC3",
        };
        let output = self.floats(shape, values);
        if self.json["animations"].is_null() {
            self.json["animations"] = json!([{ "samplers": [], "channels": [] }]);
        }
        let animation = &mut self.json["animations"][0];
        let samplers = animation["samplers"].as_array_mut().expect("an array");
        samplers.push(json!({ "input": input, "output": output, "interpolation": interpolation }));
        let channel = json!({ "sampler": samplers.len() - 1, "target": { "node": node, "path": path } });
        animation["channels"].as_array_mut().expect("an array").push(channel);
    }

    fn text(&self, uri: Option<&str>) -> Vec<u8> {
        let mut json = self.json.clone();
        if !self.bytes.is_empty() && json["buffers"].is_null() {
            json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
            if let Some(uri) = uri {
                json["buffers"][0]["uri"] = json!(uri);
            }
        }
        serde_json::to_vec(&json).expect("JSON values can be written")
    }

    /// As a binary file.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.text(None);
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bytes = self.bytes.clone();
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        let mut file = Vec::new();
        file.extend_from_slice(b"glTF");
        file.extend_from_slice(&2u32.to_le_bytes());
        file.extend_from_slice(&(28 + json.len() as u32 + bytes.len() as u32).to_le_bytes());
        file.extend_from_slice(&(json.len() as u32).to_le_bytes());
        file.extend_from_slice(b"JSON");
        file.extend_from_slice(&json);
        file.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
        file.extend_from_slice(b"BIN\0");
        file.extend_from_slice(&bytes);
        file
    }

    /// As JSON that refers to its buffer by a URI.
    pub(crate) fn gltf(&self, uri: &str) -> Vec<u8> {
        self.text(Some(uri))
    }

    pub(crate) fn load(&self) -> Result<LoadedWorld, LoadError> {
        load_bytes(&self.glb())
    }

    pub(crate) fn load_with(&self, options: &Options) -> Result<LoadedWorld, LoadError> {
        let folder = TempFolder::new();
        kinetree_gltf::load_with(&folder.write("scene.glb", &self.glb()), options)
    }

    /// Loads the file, which is expected to be good.
    pub(crate) fn good(&self) -> LoadedWorld {
        self.load().unwrap_or_else(|error| panic!("{error}"))
    }

    /// Loads the file, which is expected to be bad, and returns the message without the name of the
    /// file.
    pub(crate) fn bad(&self) -> String {
        match self.load() {
            Ok(_) => panic!("the file was loaded: {}", self.json),
            Err(error) => {
                let text = error.to_string();
                assert!(!text.contains('\n') && text.contains("scene.glb: "), "{text}");
                text.split_once("scene.glb: ").expect("the name of the file").1.to_owned()
            }
        }
    }
}

pub(crate) const TRIANGLE: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

pub(crate) fn load_bytes(bytes: &[u8]) -> Result<LoadedWorld, LoadError> {
    let folder = TempFolder::new();
    kinetree_gltf::load(&folder.write("scene.glb", bytes))
}

/// A folder for the files of one test.
pub(crate) struct TempFolder(TempDir);

impl TempFolder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder can be made"))
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        let mut file = std::fs::File::create(&path).expect("the temporary folder can be written");
        file.write_all(bytes).expect("the temporary folder can be written");
        path
    }
}

/// The scene at a time; everything that is in it is sound.
pub(crate) fn frame(loaded: &mut LoadedWorld, seconds: f64) -> Snapshot {
    let frame = loaded.world.frame(seconds).unwrap_or_else(|error| panic!("at {seconds}: {error}"));
    for instance in frame.snapshot.instances() {
        instance.bvh().validate().unwrap_or_else(|violation| panic!("at {seconds}: {violation}"));
        assert!(frame.surface(instance.index()).is_some());
        assert_eq!(instance.user_id(), 0, "user ids are the caller's");
    }
    frame.snapshot
}

/// The world positions of the vertices of every instance, by instance.
pub(crate) fn places(view: &Snapshot) -> Vec<Vec<[f32; 3]>> {
    view.instances()
        .map(|instance| {
            let world_from_object = instance.world_from_object();
            instance.positions().iter().map(|&position| world_from_object.transform_point(position)).collect()
        })
        .collect()
}

pub(crate) fn assert_near(found: &[[f32; 3]], wanted: &[[f32; 3]], what: &str) {
    assert_eq!(found.len(), wanted.len(), "{what}");
    for (a, b) in found.iter().zip(wanted) {
        assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-5 * (1.0 + b[i].abs())), "{what}: {found:?} and {wanted:?}");
    }
}
