//! Real scenes, found through the environment variable `KINETREE_SCENES`; without it, there is
//! nothing to check.

use std::path::{Path, PathBuf};
use std::time::Instant;

use kinetree::Scene;
use kinetree_gltf::{Options, load, load_with, read};

use crate::writer::{frame, places};

/// Name, triangles with every mesh counted once, with every instance, and instances, as the table
/// of the scenes says.
const TABLE: [(&str, usize, usize, usize); 12] = [
    ("race_black_forest", 393_215, 1_157_529, 1_737),
    ("race_torcs_etrack3", 50_892, 64_692, 124),
    ("skinned_karts_a", 80_455, 80_455, 32),
    ("cesium_man", 4_672, 4_672, 1),
    ("kitchen_country", 1_436_027, 1_443_303, 299),
    ("stanford_bunny", 69_630, 69_630, 1),
    ("stanford_dragon", 19_332, 19_332, 1),
    ("wind_trees_a", 9_208, 41_873, 22),
    ("wind_grass_field_a", 9_122, 9_122, 1),
    ("teapot_in_stadium_a", 155_225, 432_385, 542),
    ("thin_diagonals_a", 23_595, 49_528, 46),
    ("overlap_pile_a", 19_332, 1_237_248, 64),
];

fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("KINETREE_SCENES").map(PathBuf::from).filter(|folder| folder.is_dir());
    if folder.is_none() {
        println!("SKIPPED: KINETREE_SCENES names no folder");
    }
    folder
}

fn check(path: &Path, unique: usize, flat: usize, instances: usize) {
    let start = Instant::now();
    let mut loaded = load(path).unwrap_or_else(|error| panic!("{error}"));
    let load_time = start.elapsed();
    let duration = loaded.world.animation.duration();
    let mut complete_frames = 0;
    for i in 0..4 {
        let view = frame(&mut loaded, duration * f64::from(i) / 4.0 + 0.01);
        let left_out = view.report().left_out.len();
        assert_eq!(view.instances().len() + left_out, instances, "instances of {}", path.display());
        if left_out == 0 {
            complete_frames += 1;
            let found: usize = view.instances().map(|instance| instance.triangles().len()).sum();
            assert_eq!(found, flat, "triangles of all instances of {}", path.display());
            // Nodes that deform a mesh have copies of it, but share its surface.
            let bindings = &loaded.world.material_bindings;
            let mut surfaces: Vec<_> =
                view.instances().map(|i| (bindings.surface(i.id()), i.triangles().len())).collect();
            surfaces.sort_unstable();
            surfaces.dedup();
            let found: usize = surfaces.iter().map(|&(_, triangles)| triangles).sum();
            assert_eq!(found, unique, "triangles of all meshes of {}", path.display());
        }
    }
    assert!(complete_frames > 0, "{}: there is always an instance that is not in the frame", path.display());
    println!("{}: {load_time:?}, {} s, {:?}", path.display(), duration, loaded.notes);
}

#[test]
fn real_scenes_have_what_their_table_says() {
    let Some(folder) = folder() else { return };
    for (name, unique, flat, instances) in TABLE {
        let path = folder.join(name).with_extension("glb");
        if path.is_file() {
            check(&path, unique, flat, instances);
        } else {
            println!("SKIPPED: {name}");
        }
    }
}

#[test]
fn every_clip_of_the_karts_plays() {
    let Some(path) = folder().map(|folder| folder.join("skinned_karts_a.glb")).filter(|path| path.is_file()) else {
        return;
    };
    for clip in ["drive", "win", "lose"] {
        let options = Options::new().clip(clip);
        let mut loaded = load_with(&path, &options).unwrap_or_else(|error| panic!("{error}"));
        let views = [0.1, 0.4].map(|seconds| frame(&mut loaded, seconds));
        assert_ne!(places(&views[0]), places(&views[1]), "{clip} moves nothing");
        let bounds = views.map(|view| view.bounds());
        assert!(
            bounds.iter().all(|bounds| bounds.extent().iter().all(|&size| size > 0.0 && size < 1e3)),
            "{clip}: {bounds:?}"
        );
    }
}

#[test]
fn every_clip_of_the_karts_plays_in_a_scene_as_in_a_world() {
    let Some(path) = folder().map(|folder| folder.join("skinned_karts_a.glb")).filter(|path| path.is_file()) else {
        return;
    };
    let asset = read(&path, &Options::new()).unwrap_or_else(|error| panic!("{error}"));
    let mut scene = Scene::new();
    let root = scene.root();
    let mut karts = asset.load_into(&mut scene, root).unwrap_or_else(|error| panic!("{error}"));
    for clip in ["lose", "drive", "win"] {
        let options = Options::new().clip(clip);
        let mut alone = load_with(&path, &options).unwrap_or_else(|error| panic!("{error}"));
        for seconds in [0.1, 0.4] {
            karts.player.go_to(&mut scene, &clip.into(), seconds).unwrap_or_else(|error| panic!("{error}"));
            let sorted = |mut places: Vec<Vec<[f32; 3]>>| {
                places.sort_by(|a, b| a.partial_cmp(b).expect("no vertex is NaN"));
                places
            };
            let (found, wanted) = (sorted(places(&scene.commit())), sorted(places(&frame(&mut alone, seconds))));
            assert!(found == wanted, "{clip} at {seconds}");
        }
    }
}
