//! Materials, textures, colours, lights and cameras.

use image::{ImageFormat, RgbaImage};
use kinetree::Ray;
use kinetree_world::{Alpha, Filter, Light, Material, Scatter, TextureRef, Wrap};
use serde_json::{Value, json};

use crate::writer::{TRIANGLE, TempFolder, Writer, frame};

/// Writes three colours in one way.
type WriteColors = fn(&mut Writer) -> usize;

/// A triangle with a material.
fn dressed(material: Value) -> Writer {
    let mut writer = Writer::new();
    let positions = writer.vec3(&TRIANGLE);
    let uvs = writer.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let other = writer.floats("VEC2", &[0.5; 6]);
    let attributes = json!({ "POSITION": positions, "TEXCOORD_0": uvs, "TEXCOORD_1": other });
    let mesh = writer.push("meshes", json!({ "primitives": [{ "attributes": attributes, "material": 0 }] }));
    writer.push("nodes", json!({ "mesh": mesh }));
    writer.push("materials", material);
    writer
}

fn material(writer: &Writer) -> (Material, bool) {
    let mut loaded = writer.good();
    let view = frame(&mut loaded, 0.0);
    assert_eq!(loaded.world.material_set.materials.len(), 1);
    (loaded.world.material_set.materials[0].clone(), view.instance_at(0).is_opaque())
}

fn png(pixels: &RgbaImage) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    pixels.write_to(&mut bytes, ImageFormat::Png).expect("a small image can be written");
    bytes.into_inner()
}

fn two_pixels() -> RgbaImage {
    RgbaImage::from_raw(2, 1, vec![255, 0, 0, 255, 0, 128, 0, 64]).expect("two pixels")
}

#[test]
fn factors_become_colour_and_emission() {
    let (material, opaque) = material(&dressed(json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 2, 0.5], "metallicFactor": 0 },
        "emissiveFactor": [1, 0.5, 0],
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 10 } },
        "doubleSided": true,
    })));
    assert_eq!(material.base_color, [0.5, 0.25, 1.0, 0.5]);
    assert_eq!(material.emission, [10.0, 5.0, 0.0]);
    assert_eq!((material.alpha, material.scatter, material.two_sided), (Alpha::Opaque, Scatter::Diffuse, true));
    assert!(opaque);
}

#[test]
fn alpha_modes_are_read() {
    for (json, alpha) in [
        (json!({ "alphaMode": "MASK" }), Alpha::Mask { cutoff: 0.5 }),
        (json!({ "alphaMode": "MASK", "alphaCutoff": 0.25 }), Alpha::Mask { cutoff: 0.25 }),
        (json!({ "alphaMode": "BLEND" }), Alpha::Blend),
        (json!({ "alphaMode": "OPAQUE" }), Alpha::Opaque),
        (json!({}), Alpha::Opaque),
    ] {
        let (material, _) = material(&dressed(json));
        assert_eq!(material.alpha, alpha);
        assert!(!material.two_sided);
    }
    assert!(dressed(json!({ "alphaMode": "GLOW" })).bad().contains("material 0 has an unknown alpha mode"));
}

#[test]
fn transmission_is_a_sheet_unless_there_is_a_volume() {
    let glass = |ior: f32, volume: Value| {
        let mut material = json!({ "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_ior": { "ior": ior } } });
        if !volume.is_null() {
            material["extensions"]["KHR_materials_volume"] = volume;
        }
        dressed(material)
    };
    assert_eq!(material(&glass(1.25, Value::Null)).0.scatter, Scatter::ThinDielectric { ior: 1.25 });
    assert_eq!(material(&glass(1.25, json!({}))).0.scatter, Scatter::ThinDielectric { ior: 1.25 });
    let thick = glass(1.25, json!({ "thicknessFactor": 0.01 }));
    assert_eq!(material(&thick).0.scatter, Scatter::Dielectric { ior: 1.25 });
    let odd = glass(0.0, Value::Null);
    assert_eq!(material(&odd).0.scatter, Scatter::ThinDielectric { ior: 1.5 });
    assert_eq!(odd.good().notes.len(), 1);
}

#[test]
fn textures_are_decoded_once_and_keep_their_sampling() {
    let mut writer = dressed(json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 0, "extensions": {
            "KHR_texture_transform": { "offset": [0.5, 0.25], "rotation": 1.5, "scale": [2, 3], "texCoord": 1 } } } },
        "emissiveTexture": { "index": 1, "texCoord": 1 },
        "emissiveFactor": [1, 1, 1],
    }));
    let view = writer.view(&png(&two_pixels()));
    let mut writer = writer.with(json!({
        "images": [{ "bufferView": view, "mimeType": "image/png" }],
        "samplers": [{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }],
        "textures": [{ "source": 0, "sampler": 0 }, { "source": 0 }, { "source": 0 }],
    }));
    let (material, _) = material(&writer);
    let base = TextureRef { texture: 0, scale: [2.0, 3.0], rotation: 1.5, offset: [0.5, 0.25] };
    assert_eq!(material.base_color_texture, Some(base));
    assert_eq!(material.emission_texture, Some(TextureRef::from(1)));
    let loaded = writer.good();
    let material_set = &loaded.world.material_set;
    assert_eq!(material_set.textures.len(), 2);
    assert_eq!(material_set.textures[0].texels, [[255, 0, 0, 255], [0, 128, 0, 64]]);
    assert_eq!(
        (material_set.textures[0].width, material_set.textures[0].height, material_set.textures[0].srgb),
        (2, 1, true)
    );
    assert_eq!(
        (material_set.textures[0].wrap, material_set.textures[0].filter),
        ([Wrap::Clamp, Wrap::Mirror], Filter::Nearest)
    );
    assert_eq!((material_set.textures[1].wrap, material_set.textures[1].filter), ([Wrap::Repeat; 2], Filter::Bilinear));
    assert_eq!(material_set.textures[1].texels, material_set.textures[0].texels);
    assert_eq!(material_set.surfaces[0].uvs, [[0.5; 2]; 3], "the set that the transform names");

    writer.json["materials"][0]["emissiveTexture"]["index"] = json!(2);
    writer.json["textures"][2]["sampler"] = json!(0);
    assert_eq!(writer.good().world.material_set.textures.len(), 1, "the same image with the same sampling");
}

#[test]
fn images_come_from_files_and_broken_ones_are_named() {
    let textured = json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorTexture": { "index": 0 } } });
    let with_image =
        |image: Value| dressed(textured.clone()).with(json!({ "images": [image], "textures": [{ "source": 0 }] }));
    let folder = TempFolder::new();
    folder.write("b.png", &png(&two_pixels()));
    let writer = with_image(json!({ "uri": "b.png" }));
    let loaded = kinetree_gltf::load(&folder.write("scene.glb", &writer.glb())).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(loaded.world.material_set.textures.len(), 1);

    let data = |bytes: &[u8]| bytes.iter().map(|byte| format!("%{byte:02x}")).collect::<String>();
    let good = png(&two_pixels());
    let (cut, mut damaged) = (&good[..40], good.clone());
    let middle = damaged.len() - 20;
    damaged[middle] ^= 0x55;
    let named =
        |name: &str, kind: &str, bytes: &[u8]| json!({ "name": name, "uri": format!("data:{kind},{}", data(bytes)) });
    for (image, note) in [
        (json!({ "uri": "b.png" }), "image 0 refers to \"b.png\", which cannot be read"),
        (
            json!({ "uri": "http://example.org/b.png" }),
            "image 0 refers to \"http://example.org/b.png\", which is neither",
        ),
        (json!({ "uri": "data:image/png;base64,?" }), "which holds broken base64"),
        (named("wood", "image/png", cut), "image 0 \"wood\" cannot be decoded"),
        (named("wood", "image/png", &damaged), "image 0 \"wood\" cannot be decoded"),
        (named("wood", "image/png", &good[..8]), "image 0 \"wood\" cannot be decoded"),
        (named("wood", "image/jpeg", b"\xff\xd8\xff"), "image 0 \"wood\" cannot be decoded"),
        (named("wood", "image/ktx2", b"\xabKTX 20"), "image 0 \"wood\" is neither PNG nor JPEG"),
        (json!({ "bufferView": 77 }), "image 0 refers to buffer view 77, but there are"),
        (json!({}), "image 0 has neither a buffer view nor a URI"),
    ] {
        // Two textures of the same image, sampled in two ways: one note each, and the rest of the
        // scene.
        let mut writer = with_image(image.clone());
        let mut loaded = writer.good();
        assert_eq!(
            (loaded.world.material_set.textures.len(), frame(&mut loaded, 0.0).instances().len()),
            (0, 1),
            "{image}"
        );
        assert_eq!(loaded.world.material_set.materials[0].base_color_texture, None);
        assert!(loaded.notes.len() == 1 && loaded.notes[0].contains(note), "{note}: {:?}", loaded.notes);
        assert!(loaded.notes[0].ends_with("; the texture is left out"), "{:?}", loaded.notes);
        writer.json["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
        assert_eq!(writer.good().notes.len(), 1);
    }
    let missing = dressed(textured.clone()).with(json!({ "textures": [{ "source": 7 }] })).good();
    assert_eq!(missing.notes, ["texture 0 refers to image 7, but there are 0; the texture is left out"]);
    let missing = dressed(textured.clone()).good();
    assert_eq!(missing.notes, ["material 0 refers to texture 0, but there are 0; the texture is left out"]);
    let mut odd = with_image(json!({ "uri": format!("data:,{}", data(&good)) }));
    odd.json["textures"][0]["sampler"] = json!(3);
    let odd = odd.good();
    assert_eq!(
        odd.notes,
        ["texture 0 refers to sampler 3, but there are 0; the texture is sampled as if it named none"]
    );
    assert_eq!(odd.world.material_set.textures.len(), 1);
}

#[test]
fn only_what_has_holes_is_not_opaque() {
    // Pixels with an alpha of 255 and 64, of 255 alone, and no texture; then vertex alphas of 1 and
    // 0.25.
    let solid = RgbaImage::from_raw(1, 1, vec![1, 2, 3, 255]).expect("a pixel");
    for (mode, factor, image, vertex_alpha, opaque) in [
        (json!("OPAQUE"), 0.25, Some(two_pixels()), Some(0.25), true),
        (json!("MASK"), 1.0, None, None, true),
        (json!("MASK"), 0.25, None, None, false),
        (json!("MASK"), 1.0, Some(two_pixels()), None, false),
        (json!("MASK"), 1.0, Some(solid.clone()), None, true),
        (json!("MASK"), 1.0, Some(solid.clone()), Some(1.0), true),
        (json!("MASK"), 1.0, None, Some(0.25), false),
        (json!("BLEND"), 1.0, None, None, true),
        (json!("BLEND"), 0.75, None, None, false),
        (json!("BLEND"), 1.0, Some(two_pixels()), None, false),
        (json!("BLEND"), 1.0, None, Some(0.25), false),
    ] {
        let what = format!("{mode} {factor} {:?} {vertex_alpha:?}", image.as_ref().map(RgbaImage::dimensions));
        let mut writer = dressed(json!({
            "alphaMode": mode, "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, factor], "metallicFactor": 0 },
        }));
        if let Some(image) = image {
            let view = writer.view(&png(&image));
            writer.push("images", json!({ "bufferView": view }));
            writer.push("textures", json!({ "source": 0 }));
            writer.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
        }
        if let Some(alpha) = vertex_alpha {
            let colors = writer.floats("VEC4", &[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, alpha, 1.0, 1.0, 1.0, 1.0]);
            writer.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
        }
        assert_eq!(material(&writer).1, opaque, "{what}");
    }
    let glass = dressed(json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 } } }));
    assert!(material(&glass).1, "glass is everywhere; what it lets through is not a matter of holes");
}

#[test]
fn properties_that_are_not_supported_are_noted_once() {
    let glossy = json!({ "pbrMetallicRoughness": { "metallicFactor": 0.5, "roughnessFactor": 0.2 },
        "normalTexture": { "index": 0 }, "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 1 } } });
    let mut writer = dressed(glossy.clone());
    let textured = writer.json["meshes"][0]["primitives"][0].clone();
    for index in 1..6 {
        writer.push("materials", glossy.clone());
        let mut primitive = textured.clone();
        primitive["material"] = json!(index);
        writer.json["meshes"][0]["primitives"].as_array_mut().expect("an array").push(primitive);
    }
    let used = json!({ "extensionsUsed": ["KHR_materials_clearcoat", "KHR_texture_transform", "ACME_sparkle", "ACME_sparkle"] });
    let wanted = [
        "a normal texture is ignored at 6 materials, first at material 0: surfaces are as smooth as their geometry",
        "metalness is ignored at 6 materials, first at material 0: metals reflect diffusely",
        "roughness is ignored at 6 materials, first at material 0: smooth surfaces reflect diffusely",
        "the extension ACME_sparkle is ignored: whatever it adds is missing",
        "the extension KHR_materials_clearcoat is ignored at 6 materials, first at material 0: nothing has a clear coat",
    ];
    assert_eq!(writer.with(used).good().notes, wanted);

    let asked = |material: Value| {
        let mut notes = dressed(material).good().notes;
        notes
            .iter_mut()
            .for_each(|note| *note = note.split(" is ignored at material 0").next().unwrap_or_default().to_owned());
        notes
    };
    assert!(asked(json!({})).is_empty());
    assert!(asked(json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 1 } })).is_empty());
    assert_eq!(asked(json!({ "pbrMetallicRoughness": {} })), ["metalness"], "which is 1 unless it is given");
    let textured =
        json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "metallicRoughnessTexture": { "index": 0 } } });
    assert_eq!(asked(textured), ["roughness"]);
    for (name, what) in [
        ("KHR_materials_unlit", "the extension KHR_materials_unlit"),
        ("KHR_materials_specular", "the extension KHR_materials_specular"),
        ("KHR_materials_sheen", "the extension KHR_materials_sheen"),
        ("KHR_materials_iridescence", "the extension KHR_materials_iridescence"),
        ("KHR_materials_anisotropy", "the extension KHR_materials_anisotropy"),
        ("KHR_materials_pbrSpecularGlossiness", "the extension KHR_materials_pbrSpecularGlossiness"),
    ] {
        let mut extensions = json!({});
        extensions[name] = json!({});
        assert_eq!(asked(json!({ "extensions": extensions })), [what]);
    }
    let glass = |pbr: Value, transmission: Value, volume: Value| {
        asked(json!({ "pbrMetallicRoughness": pbr, "extensions": {
            "KHR_materials_transmission": transmission, "KHR_materials_volume": volume } }))
    };
    let (clear, full) = (json!({ "roughnessFactor": 0 }), json!({ "transmissionFactor": 1 }));
    assert!(glass(clear.clone(), full.clone(), json!({ "thicknessFactor": 1 })).is_empty());
    assert_eq!(glass(json!({ "roughnessFactor": 0.3 }), full.clone(), json!({})), ["the roughness of glass"]);
    let absorbing = json!({ "thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [1, 0, 0] });
    assert_eq!(glass(clear.clone(), full, absorbing), ["absorption in a volume"]);
    assert_eq!(glass(clear, json!({ "transmissionFactor": 0.7 }), json!({})), ["transmission in part"]);

    let mut hidden = dressed(json!({}));
    hidden.json["nodes"][0]["extensions"] = json!({ "KHR_node_visibility": { "visible": false } });
    hidden.json["extensionsUsed"] = json!(["KHR_node_visibility", "EXT_lights_image_based"]);
    let wanted = [
        "the extension EXT_lights_image_based is ignored: the environment gives no light",
        "the extension KHR_node_visibility is ignored at node 0: hidden nodes are shown",
    ];
    assert_eq!(hidden.good().notes, wanted);
}

#[test]
fn vertex_colours_of_every_kind_are_linear_rgba() {
    let kinds: [(WriteColors, [f32; 4]); 4] = [
        (|w| w.floats("VEC3", &[0.5; 9]), [0.5, 0.5, 0.5, 1.0]),
        (|w| w.floats("VEC4", &[0.25; 12]), [0.25; 4]),
        (|w| w.u8("VEC4", &[51; 12]), [0.2; 4]),
        (|w| w.u16("VEC4", &[13107; 12]), [0.2; 4]),
    ];
    for (write, wanted) in kinds {
        let mut writer = dressed(json!({}));
        let colors = write(&mut writer);
        writer.json["accessors"][colors]["normalized"] = json!(true);
        writer.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
        assert_eq!(writer.good().world.material_set.surfaces[0].colors, [wanted; 3]);
    }
}

#[test]
fn lights_stand_where_their_nodes_do() {
    let mut writer = Writer::new().with(json!({
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "point", "color": [1, 0.5, 0], "intensity": 10, "range": 5 },
            { "type": "spot", "intensity": 2, "spot": { "innerConeAngle": 0.5, "outerConeAngle": 1 } },
            { "type": "directional", "intensity": 3 },
            { "type": "point", "intensity": 0 },
        ]}},
    }));
    let up = 0.5f32.sqrt();
    for (light, placement) in [
        (0, json!({ "translation": [1, 2, 3] })),
        (1, json!({ "translation": [4, 0, 0] })),
        // Looks down: -z turned by 90 degrees about -x.
        (2, json!({ "rotation": [-up, 0, 0, up] })),
        (3, json!({})),
    ] {
        let mut node = placement;
        node["extensions"] = json!({ "KHR_lights_punctual": { "light": light } });
        writer.push("nodes", node);
    }
    let mut loaded = writer.good();
    let lights = loaded.world.frame(0.0).expect("a frame").lights;
    assert_eq!(lights.len(), 3, "a light without intensity is none");
    assert_eq!(lights[0], Light::Point { position: [1.0, 2.0, 3.0], intensity: [10.0, 5.0, 0.0], range: 5.0 });
    let Light::Spot { position, direction, intensity, range, inner_cos, outer_cos } = lights[1] else {
        panic!("{:?}", lights[1])
    };
    assert_eq!((position, direction, intensity), ([4.0, 0.0, 0.0], [0.0, 0.0, -1.0], [2.0; 3]));
    assert_eq!((range, inner_cos, outer_cos), (f32::INFINITY, 0.5f32.cos(), 1f32.cos()));
    let Light::Sun { direction, irradiance, angle } = lights[2] else { panic!("{:?}", lights[2]) };
    assert!(direction[1] < -0.9999, "{direction:?}");
    assert_eq!((irradiance, angle), ([3.0; 3], 0.0));
    writer.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = json!(9);
    assert!(writer.bad().contains("node 0 refers to light 9, but there are 4"), "{}", writer.bad());
}

#[test]
fn cameras_are_named_and_placed() {
    let writer = Writer::new().with(json!({
        "cameras": [
            { "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } },
            { "type": "orthographic", "name": "plan", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 2, "znear": 1 } },
        ],
        "nodes": [{ "camera": 0, "name": "eye", "translation": [0, 1, 5] }, { "camera": 1, "name": "other" }],
    }));
    let loaded = writer.good();
    let world = &loaded.world;
    let names: Vec<_> = world.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["eye", "plan"]);
    let camera = world.camera(&world.cameras[0]).expect("the node is there");
    assert_eq!((camera.position(), camera.fov_y), ([0.0, 1.0, 5.0], 0.7));
    assert_eq!(loaded.notes.len(), 1, "{:?}", loaded.notes);
}

#[test]
fn a_ray_finds_the_surface_that_it_hits() {
    let mut writer = dressed(json!({ "name": "red" }));
    let mesh = writer.triangle();
    writer.push("nodes", json!({ "mesh": mesh, "translation": [10, 0, 0] }));
    let mut loaded = writer.good();
    let view = frame(&mut loaded, 0.0);
    for (x, surface) in [(0.25, 0), (10.25, 1)] {
        let hit = view.closest_hit(&Ray::new([x, 0.25, 1.0], [0.0, 0.0, -1.0])).expect("a hit");
        let instance = view.instance_id(&hit);
        assert_eq!(loaded.world.material_bindings.surface(instance), Some(surface));
    }
    assert_eq!(loaded.world.material_set.surfaces.len(), 2);
    assert!(loaded.world.lights.is_empty());
}
