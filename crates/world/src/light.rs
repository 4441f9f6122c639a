//! Lights that are not surfaces: points, spots and suns, as in KHR_lights_punctual.

use glam::Vec3;
use kinetree::Affine;

/// A light, in the space of the node that it is attached to, or in world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// An isotropic point light.
    Point {
        /// Metres.
        position: [f32; 3],
        /// Radiant intensity, linear RGB, W/sr.
        intensity: [f32; 3],
        /// The light fades to zero at this distance, metres; `f32::INFINITY` for the inverse square
        /// law alone (KHR_lights_punctual).
        range: f32,
    },
    /// A spot light.
    Spot {
        /// Metres.
        position: [f32; 3],
        /// Unit vector, from the light.
        direction: [f32; 3],
        /// Radiant intensity on the axis, linear RGB, W/sr.
        intensity: [f32; 3],
        /// As for a point light.
        range: f32,
        /// Cosine of the half angle within which the light has full strength.
        inner_cos: f32,
        /// Cosine of the half angle beyond which it has none.
        outer_cos: f32,
    },
    /// A directional light, or a disc in the sky when `angle` is larger than zero.
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
    /// Transforms a light from the space of a node to world space. Position and direction follow
    /// the node; intensity, range and angles do not scale with it (KHR_lights_punctual).
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
            panic!("a spot stays a spot")
        };
        assert!((Vec3::from(position) - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-6);
        assert!((Vec3::from(direction) - Vec3::NEG_X).length() < 1e-6);
        assert_eq!((intensity, range), ([5.0; 3], 7.0));
    }
}
