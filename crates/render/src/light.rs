//! Lights that are no surfaces: points, spots and a sun.

/// A light in the space of the node it hangs on (or in world space).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// Sends the same in all directions from one point.
    Point {
        /// Metres.
        position: [f32; 3],
        /// Radiant intensity, linear RGB, W/sr.
        intensity: [f32; 3],
        /// Beyond this distance it gives nothing, metres; `f32::INFINITY` for a light without a bound (KHR_lights_punctual).
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
    /// So far away that its rays are parallel, or a disc in the sky when `angle` is larger than zero.
    Sun {
        /// Unit vector, from the sun to the scene.
        direction: [f32; 3],
        /// Irradiance on a surface that faces it, linear RGB, W/m^2.
        irradiance: [f32; 3],
        /// Angular diameter, radians; the real sun has 0.0093.
        angle: f32,
    },
}
