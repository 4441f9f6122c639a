//! Malicious and damaged files: an error or a world, never a panic, and never for long.

use kinetree::Scene;
use kinetree_gltf::{Clip, Options, read};
use serde_json::{Value, json};

use crate::writer::{TRIANGLE, Writer, frame, load_bytes};

/// A small file that uses every feature.
fn everything() -> Writer {
    let mut writer = Writer::new();
    let positions = writer.vec3(&TRIANGLE);
    let normals = writer.vec3(&[[0.0, 0.0, 1.0]; 3]);
    let uvs = writer.floats("VEC2", &[0.0; 6]);
    let colors = writer.u8("VEC4", &[200; 12]);
    let joints = writer.u8("VEC4", &[0; 12]);
    let weights = writer.floats("VEC4", &[[1.0, 0.0, 0.0, 0.0]; 3].concat());
    let displaced = writer.vec3(&TRIANGLE);
    let indices = writer.u16("SCALAR", &[0, 1, 2]);
    let identity: Vec<f32> = (0..16).map(|i| if i % 5 == 0 { 1.0 } else { 0.0 }).collect();
    let inverse = writer.floats("MAT4", &identity);
    let mut pixels = std::io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_pixel(3, 2, image::Rgba([9, 8, 7, 6]));
    image.write_to(&mut pixels, image::ImageFormat::Png).expect("a small image can be written");
    let image = writer.view(pixels.get_ref());
    let places = writer.view(&[1]);
    let values = writer.view(&[0; 12]);
    let sparse = writer.push(
        "accessors",
        json!({ "componentType": 5126, "count": 3, "type": "VEC3", "sparse": { "count": 1,
            "indices": { "bufferView": places, "componentType": 5121 }, "values": { "bufferView": values } } }),
    );
    let mut writer = writer.with(json!({
        "images": [{ "bufferView": image, "mimeType": "image/png" }],
        "samplers": [{ "magFilter": 9728, "wrapS": 33071 }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } }, "alphaMode": "MASK",
            "emissiveFactor": [1, 1, 1] }],
        "meshes": [
            { "primitives": [{ "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs,
                "COLOR_0": colors, "JOINTS_0": joints, "WEIGHTS_0": weights }, "indices": indices, "material": 0,
                "targets": [{ "POSITION": displaced }, { "POSITION": sparse }] }] },
            { "primitives": [{ "attributes": { "POSITION": positions }, "mode": 5 }] },
        ],
        "skins": [{ "joints": [1], "inverseBindMatrices": inverse }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "spot", "spot": {} }] } },
        "nodes": [
            { "children": [1, 2], "camera": 0 },
            { "mesh": 0, "skin": 0, "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "mesh": 1, "scale": [1, 2, 3], "extensions": { "EXT_mesh_gpu_instancing": {
                "attributes": { "TRANSLATION": positions, "SCALE": normals } } } },
        ],
        "scenes": [{ "nodes": [0] }],
    }));
    writer.animate(1, "weights", &[0.0, 1.0], &[0.0, 0.0, 1.0, 1.0], "LINEAR");
    writer.animate(0, "rotation", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0], "LINEAR");
    let first = writer.json["animations"][0]["samplers"][1].clone();
    let target = json!({ "node": 2, "path": "rotation" });
    writer.push("animations", json!({ "samplers": [first], "channels": [{ "sampler": 0, "target": target }] }));
    writer
}

/// Loads what may be broken; what loads can be shown, or its animation says what is wrong. In a
/// scene of the caller's, it leaves no trace.
fn survive(bytes: &[u8]) -> bool {
    insert_and_remove(bytes);
    match load_bytes(bytes) {
        Ok(mut loaded) => {
            for seconds in [0.0, 0.4] {
                if let Ok(frame) = loaded.world.frame(seconds) {
                    frame.snapshot.instances().for_each(|instance| instance.bvh().validate().expect("a sound tree"));
                }
            }
            true
        }
        Err(error) => {
            assert!(!error.to_string().contains('\n'), "{error}");
            false
        }
    }
}

/// Inserts the file, plays each of its animations, and removes it.
fn insert_and_remove(bytes: &[u8]) {
    let Ok(asset) = read(bytes, &Options::new()) else { return };
    let mut scene = Scene::new();
    let root = scene.root();
    let before = format!("{scene:?}");
    if let Ok(mut loaded) = asset.load_into(&mut scene, root) {
        scene.commit();
        for clip in (0..loaded.clips().len()).map(Clip::Index).chain([Clip::Together]) {
            // Joints may overflow in some moments only.
            let _ = loaded.player.go_to(&mut scene, &clip, 0.4);
            scene.commit().instances().for_each(|instance| instance.bvh().validate().expect("a sound tree"));
        }
        loaded.remove(&mut scene).expect("it is in the scene");
    }
    assert_eq!(format!("{scene:?}"), before);
    assert_eq!(scene.commit().instances().len(), 0);
}

#[test]
fn a_file_that_was_cut_off_is_an_error_at_every_length() {
    let file = everything().glb();
    assert!(survive(&file));
    for length in 0..file.len() {
        assert!(!survive(&file[..length]), "{length} of {} bytes were taken for a file", file.len());
    }
    // With the length of the cut file in the header, so that what is missing is noticed later.
    for length in (12..file.len()).step_by(3) {
        let mut cut = file[..length].to_vec();
        cut[8..12].copy_from_slice(&(length as u32).to_le_bytes());
        assert!(!survive(&cut), "{length} of {} bytes, as its header says, were taken for a file", file.len());
    }
}

/// xorshift64*, Vigna 2016.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % bound
    }
}

#[test]
fn flipped_bytes_never_panic() {
    let file = everything().glb();
    let json_end = 20 + u32::from_le_bytes(file[12..16].try_into().expect("four bytes")) as usize;
    let mut loaded = 0;
    for seed in 1..=4000u64 {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut broken = file.clone();
        for _ in 0..=random.below(4) {
            // Half of them in the JSON, where digits become other digits.
            if random.below(2) == 0 {
                let at = 20 + random.below(json_end - 20);
                broken[at] = if broken[at].is_ascii_digit() { b'0' + random.below(10) as u8 } else { broken[at] };
            } else {
                let at = random.below(broken.len());
                broken[at] ^= 1 << random.below(8);
            }
        }
        let result = std::panic::catch_unwind(|| survive(&broken));
        loaded += usize::from(result.unwrap_or_else(|_| panic!("seed {seed} broke the loader")));
    }
    assert!((100..3900).contains(&loaded), "{loaded} of 4000 loaded: the damage is too light or too heavy");
}

#[test]
fn every_number_of_the_json_may_be_anything() {
    let good = everything();
    let mut paths = Vec::new();
    numbers(&good.json, "", &mut paths);
    assert!(paths.len() > 100);
    for path in paths {
        for value in
            [json!(0), json!(1), json!(255), json!(4294967295u64), json!(u64::MAX), json!(-1), json!(1e38), json!(0.5)]
        {
            let mut writer = Writer { json: good.json.clone(), bytes: good.bytes.clone() };
            *writer.json.pointer_mut(&path).expect("the path leads somewhere") = value.clone();
            let bytes = writer.glb();
            let result = std::panic::catch_unwind(|| survive(&bytes));
            assert!(result.is_ok(), "{path:?} = {value} broke the loader");
        }
    }
}

/// JSON pointers to all numbers.
fn numbers(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(path.to_owned()),
        Value::Array(values) => values.iter().enumerate().for_each(|(i, v)| numbers(v, &format!("{path}/{i}"), found)),
        Value::Object(values) => values.iter().for_each(|(key, v)| numbers(v, &format!("{path}/{key}"), found)),
        _ => {}
    }
}

fn changed(pointer: &str, value: Value) -> String {
    let mut writer = everything();
    *writer.json.pointer_mut(pointer).unwrap_or_else(|| panic!("nothing at {pointer}")) = value;
    writer.bad()
}

#[test]
fn accessors_stay_within_their_views_and_views_within_their_buffers() {
    for (pointer, value, reason) in [
        ("/accessors/0/count", json!(4), "accessor 0 lies beyond its buffer view"),
        ("/accessors/0/count", json!(1u64 << 40), "asks for more data"),
        ("/accessors/0/count", json!(u64::MAX), "asks for more data"),
        ("/accessors/9/count", json!(1 << 22), "morph target of another size"),
        ("/accessors/9/count", json!(1u64 << 32), "asks for more data"),
        ("/accessors/9/sparse/count", json!(4), "accessor 9 replaces more elements than it has"),
        ("/accessors/9/sparse/count", json!(2), "accessor 9 lies beyond its buffer view"),
        ("/bufferViews/0/byteLength", json!(1 << 20), "buffer view 0 lies beyond its buffer"),
        ("/bufferViews/0/byteLength", json!(u64::MAX), "buffer view 0 lies beyond its buffer"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), "buffer view 0 lies beyond its buffer"),
        ("/bufferViews/0/buffer", json!(1), "buffer view 0 refers to buffer 1, but there are 1"),
        ("/accessors/0/bufferView", json!(99), "accessor 0 refers to buffer view 99, but there are"),
        ("/accessors/0/type", json!("VEC4"), "accessor 0 is Vec4, where Vec3 is needed by mesh 0"),
        ("/accessors/0/componentType", json!(7), "accessor 0 has an unknown component type"),
        ("/accessors/7/componentType", json!(5126), "lies beyond its buffer view|holds no unsigned integers"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(50), "mesh 0 refers to accessor 50, but there are"),
        ("/meshes/0/primitives/0/attributes/NORMAL", json!(10), "accessor 10 is Scalar|3 positions and 2 normals"),
        ("/meshes/1/primitives/0/mode", json!(9), "mesh 1 has an unknown mode in primitive 0"),
        ("/meshes/0/primitives/0/material", json!(4), "mesh 0 refers to material 4, but there are 1"),
        ("/nodes/1/mesh", json!(2), "node 1 refers to mesh 2, but there are 2"),
        ("/nodes/0/camera", json!(2), "node 0 refers to camera 2, but there are 1"),
        ("/scenes/0/nodes/0", json!(8), "scene 0 refers to node 8, but there are 3"),
    ] {
        let text = changed(pointer, value.clone());
        assert!(reason.split('|').any(|reason| text.contains(reason)), "{pointer} = {value}: {text}");
    }
}

#[test]
fn strides_that_overlap_elements_are_refused() {
    for stride in [0, 1, 11] {
        let mut writer = everything();
        writer.json["bufferViews"][0]["byteStride"] = json!(stride);
        assert!(writer.bad().contains(&format!("12 bytes that are only {stride} bytes apart")), "{}", writer.bad());
    }
}

#[test]
fn sparse_indices_stay_within_their_accessor() {
    let mut writer = everything();
    let offset = writer.json["bufferViews"][10]["byteOffset"].as_u64().expect("an offset") as usize;
    assert_eq!(writer.bytes[offset], 1);
    writer.bytes[offset] = 3;
    assert!(writer.bad().contains("accessor 9 replaces element 3 of 3"), "{}", writer.bad());
}

#[test]
fn triangles_and_positions_are_checked() {
    let mut writer = everything();
    let wild = writer.u16("SCALAR", &[0, 1, 3]);
    writer.json["meshes"][0]["primitives"][0]["indices"] = json!(wild);
    writer.json["meshes"][0]["name"] = json!("cube");
    assert_eq!(writer.bad(), "mesh 0 \"cube\" has a triangle at vertex 3, but 3 vertices");
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut writer = everything();
        let positions = writer.vec3(&[[0.0; 3], [0.0, bad, 0.0], [1.0; 3]]);
        writer.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
        assert_eq!(writer.bad(), "mesh 0 has a vertex, 1, whose position is not finite");
    }
}

#[test]
fn the_hierarchy_is_a_forest() {
    let with_nodes =
        |nodes: Value| everything().with(json!({ "nodes": nodes, "scenes": [], "skins": [], "animations": [] }));
    let itself = with_nodes(json!([{ "children": [0] }])).bad();
    assert!(itself.contains("node 0 is in a cycle of nodes"), "{itself}");
    let cycle = with_nodes(json!([{}, { "children": [2] }, { "children": [3] }, { "children": [1] }])).bad();
    assert!(cycle.contains("is in a cycle of nodes"), "{cycle}");
    let twice = with_nodes(json!([{ "children": [2] }, { "children": [2] }, {}])).bad();
    assert!(twice.contains("node 2 is a child of both node 0 and node 1"), "{twice}");
    let same = with_nodes(json!([{ "children": [1, 1] }, {}])).bad();
    assert!(same.contains("node 1 is a child of both node 0 and node 0"), "{same}");
    let nowhere = with_nodes(json!([{ "children": [7] }])).bad();
    assert!(nowhere.contains("node 0 refers to node 7, but there are 1"), "{nowhere}");
    let unbounded = with_nodes(json!([{ "translation": [1e39, 0, 0] }])).bad();
    assert!(unbounded.contains("node 0 has a transform that is not finite"), "{unbounded}");
}

#[test]
fn a_hundred_thousand_nodes_may_be_nested() {
    const DEPTH: usize = 100_000;
    let mut writer = Writer::new();
    let mesh = writer.triangle();
    let mut nodes: Vec<Value> = (1..DEPTH).map(|i| json!({ "children": [i], "translation": [0, 0.5, 0] })).collect();
    nodes.push(json!({ "mesh": mesh }));
    let mut writer = writer.with(json!({ "nodes": nodes }));
    writer.animate(0, "translation", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], "LINEAR");
    let view = frame(&mut writer.good(), 0.5);
    let place = view.instance_at(0).world_from_object().translation;
    assert_eq!(place, [0.5, 0.5 * (DEPTH - 2) as f32, 0.0]);
}

#[test]
fn data_counts_against_the_budget_each_time_it_is_used() {
    // A thousand primitives of one megabyte each, all with the same bytes but with accessors of
    // their own.
    let mut writer = Writer::new();
    let positions = writer.floats("VEC3", &vec![0.0; 3 << 17]);
    let accessor = writer.json["accessors"][positions].clone();
    let mut primitives = Vec::new();
    for _ in 0..1000 {
        let accessor = writer.push("accessors", accessor.clone());
        primitives.push(json!({ "attributes": { "POSITION": accessor } }));
    }
    let mesh = writer.push("meshes", json!({ "primitives": primitives }));
    writer.push("nodes", json!({ "mesh": mesh }));
    assert!(writer.bad().contains("asks for more data than a file of its size can hold"), "{}", writer.bad());
}

#[test]
fn empty_morph_targets_count_against_the_budget() {
    let mut writer = Writer::new();
    let positions = writer.floats("VEC3", &vec![0.0; 3 << 12]);
    let targets = vec![json!({}); 1 << 14];
    let primitive = json!({ "attributes": { "POSITION": positions }, "targets": targets });
    let mesh = writer.push("meshes", json!({ "primitives": [primitive], "weights": [1] }));
    writer.push("nodes", json!({ "mesh": mesh }));
    assert!(writer.bad().contains("asks for more data than a file of its size can hold"), "{}", writer.bad());

    let mut writer = Writer::new();
    let mesh = writer.triangle();
    writer.json["meshes"][mesh]["primitives"][0]["targets"] = json!(vec![json!({}); 1 << 13]);
    writer.json["meshes"][mesh]["weights"] = json!(vec![1; 1 << 13]);
    let writer = writer.with(json!({ "nodes": vec![json!({ "mesh": mesh }); 1 << 13] }));
    assert!(writer.bad().contains("asks for more data than a file of its size can hold"), "{}", writer.bad());
}

#[test]
fn an_image_with_a_huge_size_is_left_out() {
    let mut writer = everything();
    // The header of a PNG of 60000 x 60000 pixels, and nothing more.
    let mut header = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\xea\x60\0\0\xea\x60\x08\x06\0\0\0".to_vec();
    header.extend_from_slice(&crc(&header[12..]).to_be_bytes());
    header.extend_from_slice(b"\0\0\0\0IDAT\x35\xaf\x06\x1e");
    let view = writer.view(&header);
    writer.json["images"][0]["bufferView"] = json!(view);
    let loaded = writer.good();
    assert!(
        loaded.notes.contains(&"image 0 has a size of 60000 x 60000; the texture is left out".to_owned()),
        "{:?}",
        loaded.notes
    );
    assert!(loaded.world.material_set.textures.is_empty());
}

/// CRC-32, as in PNG.
fn crc(bytes: &[u8]) -> u32 {
    let fold = |crc: u32, &byte: &u8| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    };
    !bytes.iter().fold(u32::MAX, fold)
}
