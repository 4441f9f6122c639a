//! Files in a scene of the caller's: inserted, played, and removed.

use kinetree::{Affine, EditError, Mesh, Motion, Ray, Scene, Snapshot};
use kinetree_gltf::{Asset, Clip, LoadError, Loaded, Options, PlayError, Problem, Source, read};
use serde_json::json;

use crate::skins::{bar, lifted};
use crate::writer::{TRIANGLE, TempFolder, Writer, assert_near};

fn asset(writer: &Writer) -> Asset {
    read(&writer.glb()[..], &Options::new()).unwrap_or_else(|error| panic!("{error}"))
}

fn load_into(scene: &mut Scene, writer: &Writer) -> Loaded {
    let root = scene.root();
    asset(writer).load_into(scene, root).unwrap_or_else(|error| panic!("{error}"))
}

/// A bar with a skin that bends within a second, and a triangle on its upper joint. Nodes: 0 "bar",
/// 1 the skinned mesh, 2 "lower", 3 "upper", 4 the triangle.
fn bending() -> Writer {
    let mut writer = bar();
    let triangle = writer.triangle();
    writer.json["meshes"][triangle]["name"] = json!("flag");
    writer.push("nodes", json!({ "mesh": triangle, "translation": [0, 1, 0] }));
    writer.json["nodes"][3]["children"] = json!([4]);
    for (node, name) in [(0, "bar"), (2, "lower"), (3, "upper")] {
        writer.json["nodes"][node]["name"] = json!(name);
    }
    writer.json["skins"][0]["name"] = json!("spine");
    let half = 0.5f32.sqrt();
    writer.animate(3, "rotation", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half], "LINEAR");
    writer
}

/// A triangle that morphs and moves within two seconds.
fn morphing() -> Writer {
    let mut writer = lifted();
    writer.push("nodes", json!({ "mesh": 0 }));
    writer.animate(0, "weights", &[0.0, 2.0], &[0.0, 0.0, 1.0, 3.0], "LINEAR");
    writer.animate(0, "translation", &[0.0, 2.0], &[0.0, 0.0, 0.0, 0.0, 4.0, 0.0], "LINEAR");
    writer
}

/// The vertices in the world, the user id, the mask and the opacity of every instance.
type Shown = Vec<(Vec<[f32; 3]>, u32, u32, bool)>;

fn shown(view: &Snapshot) -> Shown {
    let vertices = |instance: &kinetree::InstanceView<'_>| {
        let world_from_object = instance.world_from_object();
        instance.positions().iter().map(|&position| world_from_object.transform_point(position)).collect()
    };
    let instances = view.instances();
    instances.map(|i| (vertices(&i), i.user_id(), i.mask(), i.is_opaque())).collect()
}

/// What rays along -z and along x hit: bits of the distance, triangle, and index of the instance.
fn answers(view: &Snapshot) -> Vec<Option<(u32, u32, u32)>> {
    let steps = || (-40..=60).map(|i| i as f32 * 0.1 + 0.013);
    let down = steps().flat_map(|x| steps().map(move |y| Ray::new([x, y, 50.0], [0.0, 0.0, -1.0])));
    let along = steps().flat_map(|y| steps().map(move |z| Ray::new([-50.0, y, z], [1.0, 0.0, 0.0])));
    let answer = |ray: Ray| {
        let hit = view.closest_hit(&ray);
        assert_eq!(hit.is_some(), view.occluded(&ray));
        hit.map(|hit| (hit.t.to_bits(), hit.primitive, view.instance(&hit).index()))
    };
    down.chain(along).map(answer).collect()
}

/// A scene with a square of the caller's behind everything, and its mesh.
fn game() -> Scene {
    let mut scene = Scene::new();
    let corners = [[-3.0, -3.0, -5.0], [7.0, -3.0, -5.0], [7.0, 7.0, -5.0], [-3.0, 7.0, -5.0]];
    let mesh = Mesh::new(&corners, &[[0, 1, 2], [0, 2, 3]]).expect("a square");
    let mesh = scene.add_mesh(mesh, Motion::Static).expect("room");
    let node = scene.add_node(scene.root(), Affine::IDENTITY).expect("room");
    let instance = scene.add_instance(node, mesh, Affine::IDENTITY).expect("room");
    scene.set_user_id(instance, 77).expect("the instance is there");
    scene
}

fn assert_same(found: &mut Scene, wanted: &mut Scene, what: &str) {
    let views = [found.commit(), wanted.commit()];
    for view in &views {
        view.instances().for_each(|instance| instance.bvh().validate().expect("a sound tree"));
    }
    let [found_view, wanted_view] = views;
    assert_eq!(shown(&found_view), shown(&wanted_view), "{what}");
    assert!(answers(&found_view) == answers(&wanted_view), "rays are answered differently: {what}");
    assert_eq!(found_view.bounds(), wanted_view.bounds(), "{what}");
    assert_eq!(format!("{found:?}"), format!("{wanted:?}"), "{what}");
}

#[test]
fn of_two_animated_files_in_one_scene_one_is_removed_and_the_other_goes_on() {
    for first_is_removed in [true, false] {
        let writers = [bending(), morphing()];
        let mut scene = game();
        let mut loaded = writers.each_ref().map(|writer| load_into(&mut scene, writer));
        let mut alone_scene = game();
        let (removed, kept) = if first_is_removed { (0, 1) } else { (1, 0) };
        let mut alone = load_into(&mut alone_scene, &writers[kept]);

        let both_at = |scene: &mut Scene, loaded: &mut [Loaded; 2], seconds: f64| {
            for loaded in loaded {
                loaded.player.go_to(scene, &Clip::Together, seconds).expect("it is in the scene");
            }
            scene.commit()
        };
        let mut moved = Vec::new();
        for seconds in [0.25, 0.5, 0.875] {
            let view = both_at(&mut scene, &mut loaded, seconds);
            alone.player.go_to(&mut alone_scene, &Clip::Together, seconds).expect("it is in the scene");
            let alone_view = alone_scene.commit();
            // The instances of the file that stays are where they are without the other.
            let of = |view: &Snapshot, loaded: &Loaded| {
                let mine = |id| loaded.instances().iter().any(|instance| instance.id == id);
                let found: Vec<_> = view.instances().map(|i| mine(i.id())).zip(shown(view)).collect();
                found.into_iter().filter(|(is_mine, _)| *is_mine).map(|(_, shown)| shown).collect::<Shown>()
            };
            let (found, wanted) = (of(&view, &loaded[kept]), of(&alone_view, &alone));
            assert_eq!(found, wanted, "at {seconds}");
            assert!(!found.is_empty() && view.instances().len() > alone_view.instances().len());
            moved.push(of(&view, &loaded[removed]));
        }
        assert!(moved[0] != moved[1] && moved[1] != moved[2], "both move");

        loaded[removed].remove(&mut scene).expect("it is in the scene");
        for seconds in [0.875, 1.25, 0.125, 3.5] {
            loaded[kept].player.go_to(&mut scene, &Clip::Together, seconds).expect("it is in the scene");
            alone.player.go_to(&mut alone_scene, &Clip::Together, seconds).expect("it is in the scene");
            assert_same(&mut scene, &mut alone_scene, &format!("at {seconds}"));
        }
        let gone = loaded[removed].player.go_to(&mut scene, &Clip::Together, 0.3);
        assert_eq!(gone, Err(PlayError::Edit(EditError::StaleHandle)));
        assert_eq!(loaded[removed].remove(&mut scene), Ok(()), "a second time");
        assert_same(&mut scene, &mut alone_scene, "removed twice");
    }
}

#[test]
fn a_scene_from_which_a_file_was_removed_is_one_that_never_had_it() {
    for writer in [bending(), morphing()] {
        let (mut scene, mut never) = (game(), game());
        // Slots that are free before, and are used by the file.
        for scene in [&mut scene, &mut never] {
            let nodes = [(); 3].map(|()| scene.add_node(scene.root(), Affine::IDENTITY).expect("room"));
            [0, 2, 1].into_iter().for_each(|i| scene.remove_node(nodes[i]).expect("it is there"));
        }
        let mut loaded = load_into(&mut scene, &writer);
        for seconds in [0.1, 0.7] {
            loaded.player.go_to(&mut scene, &Clip::Index(0), seconds).expect("it is in the scene");
            assert!(shown(&scene.commit()).len() > 1);
        }
        loaded.remove(&mut scene).expect("it is in the scene");
        assert_same(&mut scene, &mut never, "removed");
        // What is added later gets the same slots, and wins or loses the same ties.
        for scene in [&mut scene, &mut never] {
            for writer in [morphing(), bending(), bending()] {
                let mut loaded = load_into(scene, &writer);
                loaded.player.go_to(scene, &Clip::Together, 0.4).expect("it is in the scene");
            }
        }
        assert_same(&mut scene, &mut never, "filled again");
    }
}

/// Two joints whose scales multiply to more than the largest number: the last edit of an insertion
/// is refused.
fn overflowing() -> Writer {
    let mut writer = bending();
    writer.json["nodes"][2]["scale"] = json!([1e30, 1e30, 1e30]);
    writer.json["nodes"][3]["scale"] = json!([1e30, 1e30, 1e30]);
    writer
}

#[test]
fn an_error_leaves_the_scene_as_it_was() {
    let (mut scene, mut never) = (game(), game());
    let (mut other, mut other_never) = (load_into(&mut scene, &morphing()), load_into(&mut never, &morphing()));
    let stale = scene.add_node(scene.root(), Affine::IDENTITY).expect("room");
    scene.remove_node(stale).expect("it is there");
    let same_in_never = never.add_node(never.root(), Affine::IDENTITY).expect("room");
    never.remove_node(same_in_never).expect("it is there");
    assert_same(&mut scene, &mut never, "before");

    let (root, foreign) = (scene.root(), never.root());
    type IsExpected = fn(&Problem) -> bool;
    let refused: [(Writer, _, IsExpected); 3] = [
        (overflowing(), root, |problem| matches!(problem, Problem::Refused { error: EditError::NonFinite { .. }, .. })),
        (bending(), stale, |problem| matches!(problem, Problem::Parent(EditError::StaleHandle))),
        (bending(), foreign, |problem| matches!(problem, Problem::Parent(EditError::OtherScene))),
    ];
    for (writer, parent, is_expected) in refused {
        let error = asset(&writer).load_into(&mut scene, parent).map(|_| ()).expect_err("it is refused");
        assert!(is_expected(error.problem()), "{error}");
        assert!(error.to_string().starts_with("a file in memory: "), "{error}");
        assert_same(&mut scene, &mut never, &error.to_string());
    }
    // What follows goes on as if nothing had been.
    for (scene, other) in [(&mut scene, &mut other), (&mut never, &mut other_never)] {
        other.player.go_to(scene, &Clip::Together, 1.5).expect("it is in the scene");
        let mut loaded = load_into(scene, &bending());
        loaded.player.go_to(scene, &Clip::Together, 0.5).expect("it is in the scene");
    }
    assert_same(&mut scene, &mut never, "afterwards");
}

#[test]
fn a_file_is_read_on_another_thread() {
    let bytes = bending().glb();
    let reader = std::thread::spawn(move || read(&bytes[..], &Options::new()));
    let asset = reader.join().expect("no panic").unwrap_or_else(|error| panic!("{error}"));
    let (mut scene, mut wanted) = (game(), game());
    let root = scene.root();
    let loaded = asset.load_into(&mut scene, root).expect("it fits");
    load_into(&mut wanted, &bending());
    assert_same(&mut scene, &mut wanted, "read elsewhere");
    // What was inserted can be handed to another thread, too.
    std::thread::spawn(move || loaded.remove(&mut scene)).join().expect("no panic").expect("it is in the scene");
}

#[test]
fn what_was_inserted_is_listed() {
    let mut scene = game();
    let loaded = load_into(&mut scene, &bending().with(json!({ "extensionsUsed": ["KHR_materials_clearcoat"] })));
    let names: Vec<_> = loaded.nodes().iter().map(|node| (node.index, node.name.as_deref())).collect();
    assert_eq!(names, [(0, Some("bar")), (1, None), (2, Some("lower")), (3, Some("upper")), (4, None)]);
    let upper = loaded.node("upper").expect("a node of this name");
    assert_eq!((upper, loaded.node("elbow")), (loaded.nodes()[3].id, None));
    assert_eq!(scene.world_from_node(upper).expect("it is there").translation, [5.0, 1.0, 0.0]);
    let instances: Vec<_> = loaded.instances().iter().map(|instance| (instance.node, instance.mesh)).collect();
    assert_eq!(instances, [(1, loaded.meshes()[0].id), (4, loaded.meshes()[1].id)]);
    let meshes: Vec<_> = loaded.meshes().iter().map(|mesh| (mesh.index, mesh.name.as_deref())).collect();
    assert_eq!(meshes, [(0, None), (1, Some("flag"))]);
    let skins: Vec<_> =
        loaded.skins().iter().map(|skin| (skin.index, skin.name.as_deref(), &skin.joints[..])).collect();
    assert_eq!(skins, [(0, Some("spine"), &[loaded.node("lower"), Some(upper)][..])]);
    let clips: Vec<_> = loaded.clips().iter().map(|clip| (clip.name.as_deref(), clip.duration, clip.is_read)).collect();
    assert_eq!(clips, [(None, 1.0, true)]);
    assert_eq!(loaded.notes(), ["the extension KHR_materials_clearcoat is ignored: nothing has a clear coat"]);
}

#[test]
fn user_ids_are_the_callers_and_materials_are_found_by_instance() {
    let mut writer = bending().with(json!({ "materials": [
        { "name": "red", "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 1] } },
        { "name": "glassy", "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 1, 0.5] } },
    ] }));
    for (mesh, material) in [(0, 0), (1, 1)] {
        writer.json["meshes"][mesh]["primitives"][0]["material"] = json!(material);
    }
    let mut scene = game();
    let loaded = load_into(&mut scene, &writer);
    let ids = |view: &Snapshot| view.instances().map(|instance| instance.user_id()).collect::<Vec<_>>();
    assert_eq!(ids(&scene.commit()), [77, 0, 0]);
    scene.set_user_id(loaded.root(), 5).expect("it is there");
    let [bar, flag] = [0, 1].map(|i| loaded.instances()[i].id);
    scene.set_user_id(flag, 6).expect("it is there");
    let view = scene.commit();
    assert_eq!(ids(&view), [77, 5, 6]);
    let opaque: Vec<_> = view.instances().map(|instance| instance.is_opaque()).collect();
    assert_eq!(opaque, [false, true, false]);
    let color = |instance, triangle| loaded.material(instance, triangle).map(|material| material.base_color);
    assert_eq!(color(bar, 3), Some([1.0, 0.0, 0.0, 1.0]));
    assert_eq!(color(flag, 0), Some([0.0, 0.0, 1.0, 0.5]));
    let hit = view.closest_hit(&Ray::new([5.2, 2.2, 9.0], [0.0, 0.0, -1.0])).expect("the flag");
    assert_eq!(color(view.instance_id(&hit), hit.primitive), color(flag, 0));
    let square = view.closest_hit(&Ray::new([-2.0, -2.0, 9.0], [0.0, 0.0, -1.0])).expect("the square");
    assert_eq!(color(view.instance_id(&square), square.primitive), None);
}

#[test]
fn two_copies_of_one_file_are_placed_and_played_apart() {
    let asset = asset(&bending());
    let mut scene = game();
    let root = scene.root();
    let mut copies = [0.0, 10.0].map(|x| {
        let loaded = asset.load_into(&mut scene, root).expect("it fits");
        scene.place(loaded.root(), Affine::from_translation([x, 0.0, 0.0])).expect("it is there");
        loaded
    });
    copies[0].player.go_to(&mut scene, &Clip::Together, 1.0).expect("it is in the scene");
    copies[1].player.go_to(&mut scene, &Clip::Together, 0.5).expect("it is in the scene");
    let apart = shown(&scene.commit());
    copies[0].player.go_to(&mut scene, &Clip::Together, 0.5).expect("it is in the scene");
    let together = shown(&scene.commit());
    assert_eq!(apart.len(), 5);
    assert_ne!(apart[1..3], together[1..3]);
    assert_eq!(apart[3..5], together[3..5]);
    // The skinned mesh and the one on the joint both follow the root.
    for (copy, shifted) in together[1..3].iter().zip(&together[3..5]) {
        let wanted: Vec<_> = copy.0.iter().map(|&[x, y, z]| [x + 10.0, y, z]).collect();
        assert_near(&shifted.0, &wanted, "ten to the side");
    }
}

/// A triangle with three animations: "go" along x and "rise" along y for its node, and "turn" for a
/// node above it.
fn with_clips() -> Writer {
    let mut writer = Writer::new();
    let mesh = writer.triangle();
    writer.push("nodes", json!({ "name": "top", "children": [1] }));
    writer.push("nodes", json!({ "name": "body", "mesh": mesh, "translation": [1, 1, 1] }));
    let half = 0.5f32.sqrt();
    for (name, node, path, duration, values) in [
        ("go", 1, "translation", 1.0, vec![0.0, 0.0, 0.0, 8.0, 0.0, 0.0]),
        ("rise", 1, "translation", 2.0, vec![0.0, 0.0, 0.0, 0.0, 8.0, 0.0]),
        ("turn", 0, "rotation", 4.0, vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]),
    ] {
        let input = writer.floats("SCALAR", &[0.0, duration]);
        let output = writer.floats(if path == "rotation" { "VEC4" } else { "VEC3" }, &values);
        writer.push(
            "animations",
            json!({ "name": name, "samplers": [{ "input": input, "output": output }],
                "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }] }),
        );
    }
    writer
}

#[test]
fn a_player_changes_between_animations_and_leaves_no_trace_of_the_last() {
    let moments: [(Clip, f64, [f32; 3]); 5] = [
        ("go".into(), 0.25, [2.0, 0.0, 0.0]),
        ("rise".into(), 0.5, [0.0, 2.0, 0.0]),
        ("turn".into(), 4.0, [-1.0, 1.0, 1.0]),
        (Clip::Index(1), 2.0, [0.0, 8.0, 0.0]),
        // "go" and "turn", of which the first waits at its end.
        (Clip::Together, 4.0, [0.0, 8.0, 0.0]),
    ];
    let mut scene = game();
    let mut loaded = load_into(&mut scene, &with_clips());
    let body = loaded.node("body").expect("a node of this name");
    let at = |scene: &Scene, wanted: [f32; 3], what: &str| {
        assert_near(&[scene.world_from_node(body).expect("it is there").translation], &[wanted], what);
    };
    at(&scene, [1.0; 3], "at rest");
    for (before, _, _) in &moments {
        for (clip, seconds, wanted) in &moments {
            loaded.player.go_to(&mut scene, before, 0.7).expect("it is in the scene");
            loaded.player.go_to(&mut scene, clip, *seconds).expect("it is in the scene");
            at(&scene, *wanted, &format!("{clip} at {seconds} after {before}"));
        }
        loaded.player.rest(&mut scene).expect("it is in the scene");
        at(&scene, [1.0; 3], "at rest again");
    }
    let durations = ["go", "rise", "turn"].map(|name| loaded.player.duration(&name.into()).expect("it was read"));
    assert_eq!(durations, [1.0, 2.0, 4.0]);
    assert_eq!(loaded.player.duration(&Clip::Together), Ok(4.0));
    for missing in [Clip::Index(3), "swim".into()] {
        let error = loaded.player.go_to(&mut scene, &missing, 0.0).expect_err("there is none");
        let known = "can be played; those that can are: 0 \"go\", 1 \"rise\", 2 \"turn\"";
        assert_eq!(error.to_string(), format!("no animation {missing} {known}"));
    }
}

#[test]
fn animations_that_were_not_read_cannot_be_played() {
    let options = Options::new().clip("rise");
    let asset = read(&with_clips().glb()[..], &options).expect("it has such an animation");
    let read: Vec<_> = asset.clips().iter().map(|clip| (clip.is_read, clip.duration)).collect();
    assert_eq!(read, [(false, 0.0), (true, 2.0), (false, 0.0)]);
    let mut scene = game();
    let root = scene.root();
    let mut loaded = asset.load_into(&mut scene, root).expect("it fits");
    let refused = loaded.player.go_to(&mut scene, &"go".into(), 0.5).expect_err("it was not read");
    assert_eq!(refused.to_string(), "no animation \"go\" can be played; those that can are: 1 \"rise\"");
    assert_eq!(loaded.player.duration(&Clip::Together), Ok(2.0));
    let still = load_into(&mut scene, &lifted().with(json!({ "nodes": [{ "mesh": 0 }] })));
    assert_eq!(still.player.duration(&Clip::Index(0)), Ok(0.0));
    assert!(still.player.duration(&Clip::Index(1)).is_err());
}

#[test]
fn what_the_caller_attaches_goes_with_the_file_and_what_it_shows_elsewhere_stays() {
    let (mut scene, mut never) = (game(), game());
    let loaded = load_into(&mut scene, &bending());
    let hat = Mesh::new(&TRIANGLE, &[[0, 1, 2]]).expect("a triangle");
    let [hat, hat_of_never] = [&mut scene, &mut never].map(|s| s.add_mesh(hat.clone(), Motion::Rigid).expect("room"));
    let upper = loaded.node("upper").expect("a node of this name");
    let worn = scene.add_instance(upper, hat, Affine::IDENTITY).expect("room");
    let flag = loaded.meshes()[1].id;
    let elsewhere = scene.add_instance(scene.root(), flag, Affine::IDENTITY).expect("room");
    loaded.remove(&mut scene).expect("it is in the scene");
    assert_eq!(scene.set_mask(worn, 1), Err(EditError::StaleHandle));
    assert_eq!(scene.set_mask(elsewhere, 1), Ok(()));
    assert_eq!(scene.commit().instances().len(), 2);
    scene.remove_instance(elsewhere).expect("it is there");
    scene.remove_mesh(flag).expect("no instance is left");
    assert_same(&mut scene, &mut never, "after all");
    assert_eq!([scene.remove_mesh(hat), never.remove_mesh(hat_of_never)], [Ok(()), Ok(())]);

    let mut other = game();
    let loaded = load_into(&mut scene, &bending());
    assert_eq!(loaded.remove(&mut other), Err(EditError::OtherScene));
    assert_eq!(scene.commit().instances().len(), 3);
    // Parts that the caller removed itself are passed over.
    scene.remove_node(loaded.node("lower").expect("a node of this name")).expect("it is there");
    assert_eq!(loaded.remove(&mut scene), Ok(()));
    assert_same(&mut scene, &mut game(), "removed in parts");
}

#[test]
fn the_motion_of_meshes_that_stand_still_is_chosen() {
    for motion in [Motion::Static, Motion::Rigid] {
        let asset = read(&with_clips_and_scenery().glb()[..], &Options::new().motion(motion)).expect("good");
        let mut scene = Scene::new();
        let root = scene.root();
        let loaded = asset.load_into(&mut scene, root).expect("it fits");
        let view = scene.commit();
        for (node, wanted) in [(1, Motion::Rigid), (2, motion)] {
            let of_node = loaded.instances().iter().find(|instance| instance.node == node).expect("it has a mesh");
            let instance = view.instances().find(|instance| instance.id() == of_node.id).expect("it is shown");
            assert_eq!(instance.motion(), wanted);
        }
    }
}

fn with_clips_and_scenery() -> Writer {
    let mut writer = with_clips();
    let mesh = writer.triangle();
    writer.push("nodes", json!({ "mesh": mesh }));
    writer
}

#[test]
fn bytes_find_other_files_only_in_a_folder() {
    let folder = TempFolder::new();
    let writer = bending();
    let path = folder.write("a.bin", &writer.bytes);
    let text = writer.gltf("a.bin");
    let refused: Result<Asset, LoadError> = read(&text[..], &Options::new());
    let message = refused.map(|_| ()).expect_err("there is no folder").to_string();
    assert_eq!(
        message,
        "a file in memory: refers to \"a.bin\", which cannot be read: a file in memory has no files next to it"
    );
    let source = Source::Bytes { name: "bar", bytes: &text, folder: path.parent() };
    let asset = read(source, &Options::new()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(asset.files(), [path]);
    let (mut scene, mut wanted) = (game(), game());
    let root = scene.root();
    asset.load_into(&mut scene, root).expect("it fits");
    load_into(&mut wanted, &writer);
    assert_same(&mut scene, &mut wanted, "from bytes");
}

#[test]
fn a_world_shows_what_a_scene_shows() {
    for (writer, clip) in [(bending(), Clip::Together), (morphing(), Clip::Together), (with_clips(), "rise".into())] {
        let options = Options::new().clip(clip);
        let asset = read(&writer.glb()[..], &options).expect("a good file");
        let mut scene = Scene::new();
        let root = scene.root();
        let mut loaded = asset.load_into(&mut scene, root).expect("it fits");
        let mut world = asset.into_world().expect("it fits").world;
        for seconds in [0.0, 0.3, 0.9, 2.0] {
            loaded.player.go_to(&mut scene, &Clip::Together, seconds).expect("it is in the scene");
            let (found, wanted) = (scene.commit(), world.frame(seconds).expect("it fits").snapshot);
            assert!(answers(&found) == answers(&wanted), "at {seconds}");
            let vertices = |view: &Snapshot| shown(view).into_iter().map(|(vertices, ..)| vertices).collect::<Vec<_>>();
            assert_eq!(vertices(&found), vertices(&wanted), "at {seconds}");
        }
    }
}
