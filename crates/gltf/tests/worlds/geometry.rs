//! Triangles, attributes and the hierarchy.

use kinetree::Motion;
use serde_json::json;

use crate::writer::{TRIANGLE, Writer, assert_near, frame, places};

const SQUARE: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

/// Writes indices in one width.
type WriteIndices = fn(&mut Writer, &[u8]) -> usize;

fn one_node(mut writer: Writer, mesh: usize) -> Writer {
    writer.push("nodes", json!({ "mesh": mesh }));
    writer
}

#[test]
fn indices_of_every_width_and_none_give_the_same_triangles() {
    let corners = [0u8, 1, 2, 0, 2, 3];
    let variants: [(&str, WriteIndices); 3] = [
        ("u8", |w, i| w.u8("SCALAR", i)),
        ("u16", |w, i| w.u16("SCALAR", &i.iter().map(|&i| u16::from(i)).collect::<Vec<_>>())),
        ("u32", |w, i| w.u32("SCALAR", &i.iter().map(|&i| u32::from(i)).collect::<Vec<_>>())),
    ];
    for (name, write) in variants {
        let mut writer = Writer::new();
        let positions = writer.vec3(&SQUARE);
        let indices = write(&mut writer, &corners);
        let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
        let mesh = writer.push("meshes", json!({ "primitives": [primitive] }));
        let view = frame(&mut one_node(writer, mesh).good(), 0.0);
        let instance = view.instance_at(0);
        assert_eq!(instance.triangles(), [[0, 1, 2], [0, 2, 3]], "{name}");
        assert_eq!(instance.positions(), SQUARE, "{name}");
        assert_eq!(instance.normals(), None, "{name}");
        assert_eq!(instance.motion(), Motion::Static, "{name}");
    }
    let mut writer = Writer::new();
    let mesh = writer.triangle();
    let view = frame(&mut one_node(writer, mesh).good(), 0.0);
    assert_eq!(view.instance_at(0).triangles(), [[0, 1, 2]]);
}

#[test]
fn primitives_of_one_mesh_are_joined_and_lines_are_noted() {
    let mut writer = Writer::new();
    let square = writer.vec3(&SQUARE);
    let strip = writer.u8("SCALAR", &[0, 1, 3, 2]);
    let materials = json!([{ "name": "a" }, { "name": "b" }]);
    let attributes = json!({ "POSITION": square });
    let mesh = writer.push(
        "meshes",
        json!({ "primitives": [
            { "attributes": attributes, "mode": 6, "material": 1 },
            { "attributes": attributes, "mode": 1 },
            { "attributes": attributes, "mode": 0 },
            { "attributes": attributes, "indices": strip, "mode": 5, "material": 0 },
            { "attributes": attributes, "indices": strip, "mode": 5, "material": 0 },
        ]}),
    );
    let mut loaded = one_node(writer.with(json!({ "materials": materials })), mesh).good();
    let view = frame(&mut loaded, 0.0);
    assert_eq!(view.instances().len(), 1);
    // The primitives have the same attributes, so that they share four vertices.
    assert_eq!(view.instance_at(0).positions().len(), 4);
    assert_eq!(view.instance_at(0).triangles()[..4], [[1, 2, 0], [2, 3, 0], [0, 1, 3], [1, 2, 3]]);
    let surface = &loaded.world.material_set.surfaces[0];
    let parts: Vec<_> = surface.parts.iter().map(|part| (part.first_triangle, part.material)).collect();
    assert_eq!(parts, [(0, 0), (2, 1)]);
    assert_eq!(loaded.notes.len(), 2, "{:?}", loaded.notes);
}

#[test]
fn a_mesh_of_points_alone_is_no_instance() {
    let mut writer = Writer::new();
    let positions = writer.vec3(&SQUARE);
    let mesh = writer.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions }, "mode": 0 }] }));
    assert_eq!(frame(&mut one_node(writer, mesh).good(), 0.0).instances().len(), 0);
}

#[test]
fn a_primitive_without_normals_among_others_gets_those_of_its_faces() {
    let mut writer = Writer::new();
    let positions = writer.vec3(&SQUARE);
    let folded = writer.vec3(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let normals = writer.vec3(&[[0.6, 0.0, 0.8]; 4]);
    let indices = writer.u8("SCALAR", &[0, 1, 2, 0, 1, 3]);
    let mesh = writer.push(
        "meshes",
        json!({ "primitives": [
            { "attributes": { "POSITION": folded }, "indices": indices },
            { "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices },
        ]}),
    );
    let view = frame(&mut one_node(writer, mesh).good(), 0.0);
    let instance = view.instance_at(0);
    let normals = instance.normals().expect("normals for all");
    assert_eq!(instance.triangles().len(), 4);
    for (triangle, wanted) in [(0, [0.0, 0.0, 1.0]), (1, [0.0, -1.0, 0.0]), (2, [0.6, 0.0, 0.8]), (3, [0.6, 0.0, 0.8])]
    {
        for corner in instance.triangles()[triangle] {
            assert_near(&[normals[corner as usize]], &[wanted], &format!("triangle {triangle}"));
        }
    }
    assert_eq!(instance.positions().len(), 6 + 4);
}

#[test]
fn sparse_accessors_replace_some_elements_of_others_or_of_zeros() {
    for based in [true, false] {
        let mut writer = Writer::new();
        let positions = writer.vec3(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0; 3]]);
        let indices = writer.view(&[1, 0, 3, 0]);
        let values: Vec<u8> = [5.0f32, 6.0, 7.0, 8.0, 9.0, 10.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let values = writer.view(&values);
        let accessor = &mut writer.json["accessors"][positions];
        accessor["sparse"] = json!({
            "count": 2,
            "indices": { "bufferView": indices, "componentType": 5123 },
            "values": { "bufferView": values },
        });
        if !based {
            accessor.as_object_mut().expect("an object").remove("bufferView");
        }
        let triangle = writer.u8("SCALAR", &[1, 2, 3]);
        let primitive = json!({ "attributes": { "POSITION": positions }, "indices": triangle });
        let mesh = writer.push("meshes", json!({ "primitives": [primitive] }));
        let view = frame(&mut one_node(writer, mesh).good(), 0.0);
        let third = if based { [0.0, 1.0, 0.0] } else { [0.0; 3] };
        assert_eq!(view.instance_at(0).positions(), [[0.0; 3], [5.0, 6.0, 7.0], third, [8.0, 9.0, 10.0]]);
    }
}

#[test]
fn interleaved_and_quantized_positions_are_read() {
    let mut writer = Writer::new();
    // Three signed bytes and one of padding, then three normalised ones.
    let view = writer.view(&[0, 0, 0, 0, 127, 0, 0, 0, 0, 129, 0, 0]);
    writer.json["bufferViews"][view]["byteStride"] = json!(4);
    let accessor = json!({ "bufferView": view, "componentType": 5120, "count": 3, "type": "VEC3" });
    let plain = writer.push("accessors", accessor.clone());
    let normalized = writer.push("accessors", accessor);
    writer.json["accessors"][normalized]["normalized"] = json!(true);
    for (accessor, size) in [(plain, 127.0), (normalized, 1.0)] {
        let mesh = json!({ "primitives": [{ "attributes": { "POSITION": accessor } }] });
        let mesh = writer.push("meshes", mesh);
        writer.push("nodes", json!({ "mesh": mesh }));
        let view = frame(&mut writer.good(), 0.0);
        let instance = view.instances().last().expect("an instance");
        assert_eq!(instance.positions(), [[0.0; 3], [size, 0.0, 0.0], [0.0, -size, 0.0]]);
    }
}

#[test]
fn nodes_share_meshes_and_nest() {
    let mut writer = Writer::new();
    let mesh = writer.triangle();
    let half = 0.5f32.sqrt();
    let writer = writer.with(json!({
        "scenes": [{ "nodes": [4] }, { "nodes": [0] }],
        "scene": 1,
        "nodes": [
            { "children": [1, 2], "translation": [10, 0, 0] },
            { "mesh": mesh, "scale": [2, 3, 1], "rotation": [0, 0, half, half] },
            { "mesh": mesh, "children": [3], "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1] },
            { "mesh": mesh, "translation": [0, 0, 1] },
            { "mesh": mesh },
        ],
    }));
    let view = frame(&mut writer.good(), 0.0);
    let places = places(&view);
    assert_eq!(places.len(), 3);
    assert_near(&places[0], &[[10.0, 0.0, 0.0], [10.0, 2.0, 0.0], [7.0, 0.0, 0.0]], "turned");
    assert_near(&places[1], &[[15.0, 0.0, 0.0], [14.0, 0.0, 0.0], [15.0, 1.0, 0.0]], "mirrored");
    assert_near(&places[2], &[[15.0, 0.0, 1.0], [14.0, 0.0, 1.0], [15.0, 1.0, 1.0]], "nested");
    let meshes: Vec<_> = view.instances().map(|instance| instance.mesh_id()).collect();
    assert!(meshes.iter().all(|&mesh| mesh == meshes[0]));
}

#[test]
fn a_file_without_scenes_shows_all_roots_and_one_without_nodes_is_empty() {
    let mut writer = Writer::new();
    let mesh = writer.triangle();
    let nodes = json!([{ "mesh": mesh, "children": [2] }, { "mesh": mesh }, { "mesh": mesh }]);
    let mut writer = writer.with(json!({ "nodes": nodes }));
    assert_eq!(frame(&mut writer.good(), 0.0).instances().len(), 3);
    writer.json["scenes"] = json!([{}]);
    assert_eq!(frame(&mut writer.good(), 0.0).instances().len(), 0);
    assert_eq!(frame(&mut Writer::new().good(), 0.0).instances().len(), 0);
}

#[test]
fn degenerate_huge_and_vanished_geometry_is_ordinary() {
    let mut writer = Writer::new();
    let positions = writer.vec3(&[TRIANGLE[0], TRIANGLE[1], TRIANGLE[2], [3e6, 0.0, 0.0], [0.0, 4e6, -5e6]]);
    let indices = writer.u8("SCALAR", &[0, 0, 0, 0, 1, 2, 0, 1, 2, 2, 1, 0, 0, 1, 1, 0, 3, 4]);
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    let mesh = writer.push("meshes", json!({ "primitives": [primitive] }));
    writer.push("nodes", json!({ "mesh": mesh }));
    writer.push("nodes", json!({ "mesh": mesh, "scale": [0, 0, 0] }));
    writer.push("nodes", json!({ "mesh": mesh, "scale": [-1, 1, 1] }));
    let view = frame(&mut writer.good(), 0.0);
    assert_eq!(view.instances().len(), 2, "what has no size is left out");
    assert_eq!(view.instance_at(0).triangles().len(), 6);
}
