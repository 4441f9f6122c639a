//! Lights that are no surfaces: points, spots and a sun.

use glam::Vec3;
use kinetree::Affine;

/// A light in the space of the node it hangs on (or in world space).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// Sends the same in all directions from one point.
    Point {
        /// Metres.
        position: [f32; 3],
        /// Radiant intensity, linear RGB, W/sr.
        intensity: [f32; 3],
        /// Beyond this distance it gives nothing, metres; `f32::INFINITY` for a light without a
        /// bound (KHR_lights_punctual).
        range: f32,
    },
    /// Sends light into a cone.
    Spot {
        /// Metres.
        position: [f32; 3],
        /// Unit vector, from the light.
        direction: [f32; 3],
        /// Radiant intensity on the axis, linear RGB, W/sr.
        intensity: [f32; 3],
        /// As for a point.
        range: f32,
        /// Cosine of the half angle within which the light has full strength.
        inner_cos: f32,
        /// Cosine of the half angle beyond which it gives nothing.
        outer_cos: f32,
    },
    /// So far away that its rays are parallel, or a disc in the sky when `angle` is larger than
    /// zero.
    Sun {
        /// Unit vector, from the sun to the scene.
        direction: [f32; 3],
        /// Irradiance on a surface that faces it, linear RGB, W/m^2.
        irradiance: [f32; 3],
        /// Angular diameter, radians; the real sun has 0.0093.
        angle: f32,
    },
}

impl Light {
    /// The light of a node as the world sees it. Position and direction move with the node;
    /// strength, range and angles do not scale with it (KHR_lights_punctual).
    pub fn placed(&self, world_from_node: &Affine) -> Self {
        let turned = |direction: [f32; 3]| {
            let turned = Vec3::from(world_from_node.transform_vector(direction));
            turned.try_normalize().map_or(direction, Vec3::into)
        };
        match *self {
            Self::Point { position, intensity, range } => {
                Self::Point { position: world_from_node.transform_point(position), intensity, range }
            }
            Self::Spot { position, direction, intensity, range, inner_cos, outer_cos } => Self::Spot {
                position: world_from_node.transform_point(position),
                direction: turned(direction),
                intensity,
                range,
                inner_cos,
                outer_cos,
            },
            Self::Sun { direction, irradiance, angle } => Self::Sun { direction: turned(direction), irradiance, angle },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_move_and_turn_with_their_node_and_do_not_scale() {
        let turn = Affine::from_axis_angle([0.0, 1.0, 0.0], std::f32::consts::FRAC_PI_2);
        let node = Affine::from_translation([1.0, 2.0, 3.0]) * turn * Affine::from_scale([2.0; 3]);
        let spot = Light::Spot {
            position: [0.0; 3],
            direction: [0.0, 0.0, -1.0],
            intensity: [5.0; 3],
            range: 7.0,
            inner_cos: 0.9,
            outer_cos: 0.8,
        };
        let Light::Spot { position, direction, intensity, range, .. } = spot.placed(&node) else {
            panic!("a spot stays one")
        };
        assert!((Vec3::from(position) - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-6);
        assert!((Vec3::from(direction) - Vec3::NEG_X).length() < 1e-6);
        assert_eq!((intensity, range), ([5.0; 3], 7.0));
    }
}
