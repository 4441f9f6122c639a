//! Features that add conversions: `serde`, `glam` and `mint`. Run with
//! `cargo test -p kinetree --features serde,glam,mint --test conversions`.

#![cfg(any(feature = "serde", feature = "glam", feature = "mint"))]

#[path = "common/mod.rs"]
mod common;

use common::Random;
use kinetree::Affine;

#[cfg(feature = "serde")]
mod of_serde {
    use super::*;
    use kinetree::{
        Action, BuildOptions, Coherence, Cull, FrameReport, InstanceId, MeshId, Motion, NodeId, Precision, Quality,
        Reason, Scene, TopLevelMethod, Work,
    };
    use serde_json::{from_str, json, to_string, to_value};

    #[test]
    fn placements_come_back_to_the_bit() {
        let mut random = Random::new(5);
        for _ in 0..200 {
            let map = random.placement(1e3);
            assert_eq!(from_str::<Affine>(&to_string(&map).unwrap()).unwrap(), map);
        }
        let text = r#"{"x_axis":[1,0,0],"y_axis":[0,1,0],"z_axis":[0,0,1],"translation":[4,5,6]}"#;
        assert_eq!(from_str::<Affine>(text).unwrap(), Affine::from_translation([4.0, 5.0, 6.0]));
    }

    #[test]
    fn options_are_written_by_name() {
        let options = BuildOptions::new().quality(Quality::Best);
        assert_eq!(to_value(&options).unwrap(), json!({ "quality": "best" }));
        assert_eq!(from_str::<BuildOptions>(r#"{ "quality": "fastest" }"#).unwrap().quality, Quality::Fastest);
        assert_eq!(from_str::<BuildOptions>("{}").unwrap().quality, Quality::default());
        for motion in [Motion::Static, Motion::Rigid, Motion::Deforming, Motion::Dynamic] {
            assert_eq!(from_str::<Motion>(&to_string(&motion).unwrap()).unwrap(), motion);
        }
        assert_eq!(to_value((Motion::Deforming, Precision::Watertight)).unwrap(), json!(["deforming", "watertight"]));
        assert_eq!(to_value((Cull::Back, Coherence::Unknown)).unwrap(), json!(["back", "unknown"]));
        assert!(from_str::<Quality>(r#""marvellous""#).is_err());
    }

    #[test]
    fn reports_come_back() {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(common::cube(), Motion::Rigid).unwrap();
        scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
        let flat = scene.add_instance(scene.root(), mesh, Affine::from_scale([0.0; 3])).unwrap();
        let view = scene.commit();
        let text = to_string(view.report()).unwrap();
        let report: FrameReport = from_str(&text).unwrap();
        assert_eq!(report.meshes, view.report().meshes);
        assert_eq!((report.frame, report.memory), (view.report().frame, view.report().memory));
        assert_eq!((report.left_out, report.total_time), (vec![flat], view.report().total_time));
        assert_eq!(report.top_level.method, TopLevelMethod::Clustered);
        let value = to_value(view.report()).unwrap();
        assert_eq!(value["meshes"][0]["action"], json!("built"));
        assert_eq!(
            to_value((Action::Loaded, Reason::NotMadeForRefit)).unwrap(),
            json!(["loaded", "not_made_for_refit"])
        );
        let mut work = Work::default();
        work.nodes = 7;
        assert_eq!(from_str::<Work>(&to_string(&work).unwrap()).unwrap(), work);
    }

    #[test]
    fn handles_come_back_within_the_process() {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(common::cube(), Motion::Rigid).unwrap();
        let node = scene.add_node(scene.root(), Affine::IDENTITY).unwrap();
        let instance = scene.add_instance(node, mesh, Affine::IDENTITY).unwrap();
        assert_eq!(from_str::<MeshId>(&to_string(&mesh).unwrap()).unwrap(), mesh);
        assert_eq!(from_str::<NodeId>(&to_string(&node).unwrap()).unwrap(), node);
        assert_eq!(from_str::<InstanceId>(&to_string(&instance).unwrap()).unwrap(), instance);
        assert!(scene.transform(from_str::<NodeId>("[9, 9, 9, 9]").unwrap()).is_err());
    }
}

#[cfg(feature = "glam")]
mod of_glam {
    use super::*;
    use glam::{Affine3, Affine3A, Mat4, Vec2, Vec3};
    use kinetree::{Interpolate, Mesh};

    #[test]
    fn placements_are_converted_both_ways() {
        let mut random = Random::new(6);
        for _ in 0..200 {
            let map = random.placement(10.0);
            assert_eq!(Affine::from(Affine3A::from(map)), map);
            assert_eq!(Affine::from(Affine3::from(map)), map);
            assert_eq!(Affine::from(Affine3A::from_mat4(Mat4::from(map))), map);
            let point = random.point(10.0);
            let moved = Affine3A::from(map).transform_point3(point.into());
            assert!(moved.distance(map.transform_point(point).into()) < 1e-4);
        }
    }

    #[test]
    fn vectors_are_positions_and_can_be_interpolated() {
        let points = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let mesh = Mesh::new(&points, &[[0, 1, 2]]).unwrap();
        let back: Vec<Vec3> = mesh.positions().iter().copied().map(Vec3::from).collect();
        assert_eq!(back, points);
        assert_eq!(Mesh::new(&points[..], &[0_u16, 1, 2]).unwrap().positions(), mesh.positions());
        assert_eq!(Vec2::weighted([Vec2::ZERO, Vec2::X, Vec2::Y], [0.25, 0.25, 0.5]), Vec2::new(0.25, 0.5));
    }
}

#[cfg(feature = "mint")]
mod of_mint {
    use super::*;
    use kinetree::{Mesh, Ray};
    use mint::{ColumnMatrix3x4, ColumnMatrix4, Point3, RowMatrix3x4, Vector3};

    #[test]
    fn placements_are_converted_both_ways() {
        let mut random = Random::new(7);
        for _ in 0..200 {
            let map = random.placement(10.0);
            assert_eq!(Affine::from(ColumnMatrix3x4::from(map)), map);
            assert_eq!(Affine::from(RowMatrix3x4::from(map)), map);
            let rows = RowMatrix3x4::from(map);
            assert_eq!([rows.x.w, rows.y.w, rows.z.w], map.translation);
            let matrix = ColumnMatrix4::from(map);
            assert_eq!([matrix.x.w, matrix.y.w, matrix.z.w, matrix.w.w], [0.0, 0.0, 0.0, 1.0]);
            assert_eq!([matrix.y.x, matrix.y.y, matrix.y.z], map.y_axis);
        }
    }

    /// By mint's own conversions from and to arrays.
    #[test]
    fn points_and_vectors_are_converted_both_ways() {
        let points: [Point3<f32>; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Into::into);
        let mesh = Mesh::new(&points.map(<[f32; 3]>::from), &[[0, 1, 2]]).unwrap();
        assert_eq!(mesh.positions().iter().map(|&point| Point3::from(point)).collect::<Vec<_>>(), points);
        let (origin, direction) = (points[1], Vector3 { x: 0.0, y: 0.0, z: -1.0 });
        assert_eq!(Ray::new(origin.into(), direction.into()).origin, [1.0, 0.0, 0.0]);
    }
}
