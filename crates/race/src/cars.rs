//! The two cars in the scene: bodies that roll and pitch, wheels that steer and turn, each with a
//! node of its own.

use std::f32::consts::PI;

use glam::{Affine3A, Quat, Vec3};
use kinetree::{Affine, EditError, Motion, NodeId, Scene};

use crate::car::{self, AXLES, HALF_TRACK, HUB};
use crate::driving::Driving;
use crate::palette::Palette;
use crate::scene_builder::{SceneBuilder, affine};
use crate::wheel::wheel;

/// A car: car -> body, and car -> steering -> rolling -> wheel.
pub(crate) struct Car {
    /// On the road.
    pub(crate) node: NodeId,
    body: NodeId,
    wheels: Vec<Wheel>,
}

struct Wheel {
    hub: Vec3,
    steers: bool,
    steering: NodeId,
    rolling: NodeId,
}

/// Adds both cars, which share one mesh for their eight wheels.
pub(crate) fn build(builder: &mut SceneBuilder, palette: &Palette) -> Result<[Car; 2], EditError> {
    let shared = builder.prop(wheel(palette), Motion::Rigid)?;
    let colors = [([0.02, 0.02, 0.022], [0.70, 0.05, 0.04]), ([0.85, 0.30, 0.02], [0.78, 0.78, 0.76])];
    let mut build = |index: usize| -> Result<Car, EditError> {
        let (accent, helmet) = colors[index];
        let shell = builder.prop(car::body(palette.liveries[index], accent, helmet, palette), Motion::Rigid)?;
        let root = builder.scene.root();
        let node = builder.scene.add_node(root, Affine::IDENTITY)?;
        let body = builder.scene.add_node(node, Affine::IDENTITY)?;
        builder.put(body, shell, &Affine3A::IDENTITY)?;
        let mut wheels = Vec::new();
        for axle in AXLES {
            for side in [1.0f32, -1.0] {
                let hub = Vec3::new(side * HALF_TRACK, HUB, axle);
                let steering = builder.scene.add_node(node, Affine::from_translation(hub.to_array()))?;
                let rolling = builder.scene.add_node(steering, Affine::IDENTITY)?;
                // The wheel's outer side is at +x of its mesh.
                let turned = Affine3A::from_rotation_y(if side > 0.0 { 0.0 } else { PI });
                builder.put(rolling, shared, &turned)?;
                wheels.push(Wheel { hub, steers: axle > 0.0, steering, rolling });
            }
        }
        Ok(Car { node, body, wheels })
    };
    Ok([build(0)?, build(1)?])
}

impl Car {
    /// Moves the car to a time.
    pub(crate) fn go_to(
        &self,
        scene: &mut Scene,
        driving: &Driving,
        car: usize,
        seconds: f64,
    ) -> Result<(), EditError> {
        let moment = driving.moment(car, seconds);
        scene.place(self.node, affine(&moment.world_from_car))?;
        // The body leans around a line near the road; forward is +z, so a positive turn around it
        // lifts the left.
        let lean = Quat::from_rotation_z(moment.lean) * Quat::from_rotation_x(moment.dive);
        scene.place(self.body, affine(&Affine3A::from_quat(lean)))?;
        for wheel in &self.wheels {
            let steer = if wheel.steers { moment.steer } else { 0.0 };
            let place = Affine3A::from_rotation_translation(Quat::from_rotation_y(steer), wheel.hub);
            scene.place(wheel.steering, affine(&place))?;
            scene.place(wheel.rolling, affine(&Affine3A::from_rotation_x(moment.roll)))?;
        }
        Ok(())
    }
}
