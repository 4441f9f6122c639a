//! What the library says: errors that name what is wrong, and `Debug` that fits on a screen.

mod common;

use std::process::Command;

use common::{grid, placed};
use kinetree::simd::Level;
use kinetree::{Affine, EditError, Mesh, MeshError, MorphTarget, Motion, Pose, Scene, Skin};

fn triangle() -> Mesh {
    Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]).unwrap()
}

fn skin(weights: [f32; 4]) -> Skin {
    Skin { joints: vec![[0; 4]; 3], weights: vec![[1.0, 0.0, 0.0, 0.0], weights, [1.0, 0.0, 0.0, 0.0]] }
}

#[test]
fn joints_posed_on_a_mesh_without_a_skin_are_refused() {
    let mut scene = Scene::new();
    let bare = scene.add_mesh(triangle(), Motion::Deforming).unwrap();
    let morphed = vec![MorphTarget { positions: vec![[0.0; 3]; 3], normals: vec![] }];
    let morphed = scene.add_mesh(triangle().with_morph_targets(morphed).unwrap(), Motion::Deforming).unwrap();
    let skinned = skin([1.0, 0.0, 0.0, 0.0]);
    let skinned = scene.add_mesh(triangle().with_skin(skinned).unwrap(), Motion::Deforming).unwrap();
    let joints = [Affine::IDENTITY; 2];
    let refused = Err(EditError::PoseDiffers { what: "joints", expected: 0, found: 2 });
    assert_eq!(scene.pose(bare, &Pose { weights: &[], joints: &joints }), refused);
    assert_eq!(scene.pose(morphed, &Pose { weights: &[0.5], joints: &joints }), refused);
    assert_eq!(scene.pose(skinned, &Pose { weights: &[], joints: &joints }), Ok(()));
    assert_eq!(scene.pose(bare, &Pose::default()), Ok(()));
}

#[test]
fn a_negative_skin_weight_is_called_negative() {
    let refusal = |weights| triangle().with_skin(skin(weights)).unwrap_err();
    let negative = refusal([1.5, -0.5, 0.0, 0.0]);
    assert_eq!(negative, MeshError::NegativeWeight { at: 1 });
    assert!(negative.to_string().contains("negative") && !negative.to_string().contains("finite"), "{negative}");
    for weight in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(refusal([1.0, weight, 0.0, 0.0]), MeshError::NonFinite { at: 1 });
    }
    assert!(triangle().with_skin(skin([1.0, -0.0, 0.0, 0.0])).is_ok());
}

#[test]
fn debug_says_how_large_things_are_and_not_all_that_is_in_them() {
    let mesh = grid(60, 1.0);
    let skinned = Skin { joints: vec![[0; 4]; 3721], weights: vec![[1.0, 0.0, 0.0, 0.0]; 3721] };
    let mesh = mesh.with_skin(skinned.clone()).unwrap();
    let target = MorphTarget { positions: vec![[1.0; 3]; 3721], normals: vec![] };
    let mut scene = Scene::new();
    let id = scene.add_mesh(mesh.clone(), Motion::Static).unwrap();
    for _ in 0..300 {
        scene.add_instance(scene.root(), id, Affine::IDENTITY).unwrap();
    }
    let view = scene.commit();
    let shown = placed(mesh.clone(), &[Affine::IDENTITY]);
    let instance = view.instance_at(7);
    let texts = [
        format!("{scene:?}"),
        format!("{view:?}"),
        format!("{shown:#?}"),
        format!("{mesh:?}"),
        format!("{instance:?}"),
        format!("{:?}", view.meshes().next().unwrap()),
        format!("{:?}", instance.bvh()),
        format!("{:?}", instance.bvh().tree()),
        format!("{:?}", view.top_level()),
        format!("{skinned:?}"),
        format!("{target:?}"),
    ];
    for text in &texts {
        assert!(text.len() < 300, "{} letters: {}", text.len(), &text[..300]);
    }
    assert!(texts[0].contains("instances: 300") && texts[3].contains("triangles: 7200"), "{texts:?}");
}

/// For the test below, which runs this one in another process.
#[test]
fn levels_are_looked_up() {
    println!("level {:?}, then {:?}", Level::current(), Level::current());
}

#[test]
fn a_level_that_is_none_is_said_once_with_those_there_are() {
    let best = Level::available().last().unwrap().name();
    let run = |value: &str| {
        let mut program = Command::new(std::env::current_exe().unwrap());
        program.args(["--exact", "levels_are_looked_up", "--nocapture"]).env("KINETREE_SIMD", value);
        let output = program.output().unwrap();
        assert!(output.status.success());
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
    };
    let [out, err] = run("nonsense");
    assert_eq!(err.matches("KINETREE_SIMD=nonsense").count(), 1, "{err}");
    assert!(err.contains("scalar") && err.contains(best), "{err}");
    assert!(out.contains(&format!("level {best}, then {best}")), "{out}");
    for (value, level) in [("scalar", "scalar"), ("", best)] {
        let [out, err] = run(value);
        assert!(!err.contains("KINETREE_SIMD") && out.contains(&format!("level {level},")), "{out}\n{err}");
    }
}
