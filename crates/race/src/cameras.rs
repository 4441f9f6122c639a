//! The cameras of the race.

use glam::Vec3;
use kinetree::{Affine, EditError, NodeId, Scene};
use kinetree_world::{Camera, CameraSource};

use crate::driving::Driving;
use crate::ground::Ground;

/// A camera beside the track that turns with the cars.
pub(crate) struct Panning {
    pub(crate) node: NodeId,
    eye: Vec3,
    /// What it looks at at time 0.
    target: Vec3,
}

impl Panning {
    pub(crate) fn new(node: NodeId, ground: &Ground) -> Self {
        let (x, z) = (152.9, -13.9);
        Self { node, eye: ground.below(x, z) + Vec3::Y * 1.3, target: Vec3::new(166.0, 2.35, 0.0) }
    }

    pub(crate) fn go_to(&self, scene: &mut Scene, driving: &Driving, seconds: f64) -> Result<(), EditError> {
        let place = |car, seconds| Vec3::from(driving.moment(car, seconds).world_from_car.translation);
        let middle = |seconds| (place(0, seconds) + place(1, seconds)) * 0.5;
        let target = self.target + middle(seconds) - middle(0.0);
        scene.place(self.node, Affine::look_at(self.eye.to_array(), target.to_array(), [0.0, 1.0, 0.0]))
    }
}

/// The cameras; the first is the default.
pub(crate) fn cameras(ground: &Ground, cars: [NodeId; 2], panning: &Panning) -> Vec<CameraSource> {
    let fixed = |name: &str, [x, up, z]: [f32; 3], target: [f32; 3], degrees: f32| {
        let eye = ground.below(x, z) + Vec3::Y * up;
        CameraSource {
            name: name.into(),
            node: None,
            camera: Camera::look_at(eye.to_array(), target, degrees.to_radians()),
        }
    };
    let riding = |name: &str, car: NodeId, eye: [f32; 3], target: [f32; 3], degrees: f32| CameraSource {
        name: name.into(),
        node: Some(car),
        camera: Camera::look_at(eye, target, degrees.to_radians()),
    };
    vec![
        CameraSource {
            name: "track".into(),
            node: Some(panning.node),
            camera: Camera { world_from_camera: Affine::IDENTITY, fov_y: 25.5_f32.to_radians() },
        },
        fixed("aerial", [-40.0, 120.0, 235.0], [25.0, 0.0, 12.0], 48.0),
        riding("chase", cars[0], [0.0, 2.1, -6.8], [0.0, 0.9, 4.0], 55.0),
        riding("front", cars[0], [2.6, 1.3, 5.4], [0.1, 0.6, -0.6], 42.0),
        riding("wheel", cars[1], [1.9, 0.75, -2.6], [0.6, 0.5, 3.0], 60.0),
        fixed("grandstand", [24.0, 8.0, 104.0], [30.0, 1.0, 70.0], 60.0),
        fixed("pit", [34.0, 1.5, 66.5], [6.0, 3.4, 82.0], 55.0),
        fixed("hairpin", [-121.0, 1.5, -50.5], [-126.0, 1.2, -20.0], 58.0),
    ]
}
