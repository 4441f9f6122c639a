//! One triangle.

use glam::Vec3;

use super::Aabb;

/// Three corners, counter-clockwise as seen from the front.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Triangle {
    /// Corners, metres.
    pub corners: [[f32; 3]; 3],
}

impl Triangle {
    /// The smallest box around it.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(self.corners)
    }

    /// The longest edge of the smallest box around it, metres.
    #[inline]
    pub fn extent(&self) -> f32 {
        let [x, y, z] = self.bounds().extent();
        x.max(y).max(z)
    }

    /// The normal on the front side; its length is twice the area, zero for a degenerate triangle.
    pub fn normal(&self) -> [f32; 3] {
        let [a, b, c] = self.corners.map(Vec3::from);
        (b - a).cross(c - a).into()
    }

    /// Square metres.
    pub fn area(&self) -> f32 {
        Vec3::from(self.normal()).length() * 0.5
    }

    /// The point with weight `u` of the second corner and `v` of the third.
    pub fn at(&self, u: f32, v: f32) -> [f32; 3] {
        let [a, b, c] = self.corners.map(Vec3::from);
        (a * (1.0 - u - v) + b * u + c * v).into()
    }
}
