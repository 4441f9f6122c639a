//! Where bytes come from.

use kinetree_gltf::{Clip, Options};
use serde_json::json;

use crate::writer::{TempFolder, Writer, frame, load_bytes};

fn triangle() -> Writer {
    let mut writer = Writer::new();
    let mesh = writer.triangle();
    writer.push("nodes", json!({ "mesh": mesh }));
    writer
}

#[test]
fn buffers_come_from_the_binary_chunk_from_files_and_from_data() {
    let writer = triangle();
    assert_eq!(frame(&mut writer.good(), 0.0).instances().len(), 1);

    let folder = TempFolder::new();
    folder.write("a b.bin", &writer.bytes);
    let path = folder.write("scene.gltf", &writer.gltf("a%20b.bin"));
    let mut loaded = kinetree_gltf::load(&path).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(frame(&mut loaded, 0.0).instances().len(), 1);

    let data: String = writer.bytes.iter().map(|byte| format!("%{byte:02x}")).collect();
    let with_mark = [b"\xef\xbb\xbf".to_vec(), writer.gltf(&format!("data:,{data}"))].concat();
    assert_eq!(frame(&mut load_bytes(&with_mark).unwrap_or_else(|error| panic!("{error}")), 0.0).instances().len(), 1);
}

#[test]
fn what_is_not_there_is_named() {
    let folder = TempFolder::new();
    let text = |path: &std::path::Path| match kinetree_gltf::load(path) {
        Ok(_) => panic!("{} was loaded", path.display()),
        Err(error) => error.to_string(),
    };
    let missing = text(&folder.write("scene.gltf", &triangle().gltf("gone.bin")));
    assert!(missing.contains("scene.gltf: refers to \"gone.bin\", which cannot be read"), "{missing}");
    let absent = text(std::path::Path::new("nowhere/at/all.glb"));
    assert!(absent.starts_with("nowhere/at/all.glb: cannot be read"), "{absent}");
    let network = text(&folder.write("scene.gltf", &triangle().gltf("https://example.org/a.bin")));
    assert!(network.contains("neither a relative path nor a data URI"), "{network}");
    folder.write("short.bin", &[0; 5]);
    let short = text(&folder.write("scene.gltf", &triangle().gltf("short.bin")));
    assert!(short.contains("buffer 0 says that it has 36 bytes, but has 5"), "{short}");
    let folder_itself = text(folder.write("x", b"").parent().expect("a parent"));
    assert!(folder_itself.contains("it is not a file"), "{folder_itself}");
}

#[test]
fn other_formats_and_versions_are_refused() {
    for (bytes, reason) in [
        (&b""[..], "has JSON that is not glTF 2.0"),
        (b"solid cube", "has JSON that is not glTF 2.0"),
        (b"{}", "has JSON that is not glTF 2.0"),
        (b"{\"asset\":{\"version\":\"1.0\"}}", "its version is"),
        (b"glTF\x01\0\0\0\x0c\0\0\0", "its version is not 2"),
        (b"glTF\x02\0\0\0\0\0\0\0", "ends within the header of a chunk"),
        (b"glTF\x02\0\0\0\xff\xff\xff\xff", "shorter than its header says"),
    ] {
        let error = load_bytes(bytes).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains(reason), "{error:?} for {bytes:?}");
    }
    let nested = "[".repeat(100_000);
    assert!(load_bytes(nested.as_bytes()).is_err());
}

#[test]
fn an_extension_that_hides_the_geometry_is_refused_and_a_harmless_one_is_noted() {
    let draco = triangle().with(json!({ "extensionsRequired": ["KHR_draco_mesh_compression"] }));
    assert!(draco.bad().contains("requires the extension \"KHR_draco_mesh_compression\""));
    let quantized = triangle().with(json!({ "extensionsRequired": ["KHR_mesh_quantization"] }));
    assert!(quantized.good().notes.is_empty());
    let coated = triangle().with(json!({ "extensionsRequired": ["KHR_materials_clearcoat"] }));
    assert_eq!(coated.good().notes.len(), 1);
}

#[test]
fn a_clip_is_chosen_by_index_or_by_name() {
    let mut writer = triangle();
    let [short, long] = [[0.0, 1.0], [0.0, 2.0]].map(|times| writer.floats("SCALAR", &times));
    let output = writer.vec3(&[[0.0; 3], [1.0; 3]]);
    let clip = |name: &str, input: usize| {
        json!({ "name": name, "samplers": [{ "input": input, "output": output }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }] })
    };
    let writer = writer.with(json!({ "animations": [clip("walk", short), clip("run", long)] }));
    let duration = |clip| writer.load_with(&Options::new().clip(clip)).map(|loaded| loaded.world.animation.duration());
    assert_eq!(duration(Clip::default()).ok(), Some(1.0));
    assert_eq!(duration(Clip::Index(1)).ok(), Some(2.0));
    assert_eq!(duration(Clip::Name("run".into())).ok(), Some(2.0));
    for missing in [Clip::Index(2), Clip::Name("fly".into())] {
        let text = duration(missing).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(text.contains("has no animation") && text.ends_with("it has 2: 0 \"walk\", 1 \"run\""), "{text}");
    }
    assert!(triangle().load_with(&Options::new().clip(1)).is_err());
    assert_eq!(triangle().good().world.animation.duration(), 0.0);
}
