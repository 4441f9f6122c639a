//! Files that once went wrong.

use serde_json::{Value, json};

use crate::writer::{TRIANGLE, Writer, assert_near, frame, places};

/// A mesh of a triangle with one morph target, up, and of another primitive with two; the weights of both targets go
/// from 0 to (1, 1) within a second.
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
