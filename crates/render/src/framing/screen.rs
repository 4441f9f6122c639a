//! Projection of points to the picture, with coordinates from -1 to 1, to the right and up.

use glam::{Vec2, Vec3};
use kinetree_world::Camera;

use super::subject::SampledObject;

/// The projection of a camera.
#[derive(Debug)]
pub(super) struct ScreenProjection {
    pub(super) eye: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Half extents of the image plane at distance 1.
    half: Vec2,
}

impl ScreenProjection {
    /// `camera` must have unit axes.
    pub(super) fn new(camera: &Camera, aspect: f32) -> Self {
        let placement = &camera.world_from_camera;
        let half = (0.5 * camera.fov_y).tan();
        Self {
            eye: placement.translation.into(),
            right: placement.x_axis.into(),
            up: placement.y_axis.into(),
            forward: -Vec3::from(placement.z_axis),
            half: Vec2::new(half * aspect, half),
        }
    }

    /// Projects a point; within -1 to 1 it is in the picture. `None` for points that are not in
    /// front of the camera.
    pub(super) fn project(&self, point: Vec3) -> Option<Vec2> {
        let offset = point - self.eye;
        let depth = offset.dot(self.forward);
        (depth > 0.0).then(|| Vec2::new(offset.dot(self.right), offset.dot(self.up)) / (depth * self.half))
    }

    /// The vector from the eye through a point of the picture, at distance 1 along the view.
    pub(super) fn ray(&self, at: Vec2) -> Vec3 {
        let at = at * self.half;
        self.forward + self.right * at.x + self.up * at.y
    }

    /// Approximate size of an object relative to the picture's width; huge for one at the eye.
    pub(super) fn width_of(&self, object: &SampledObject) -> f32 {
        object.size / (2.0 * self.half.x * object.center.distance(self.eye)).max(1e-30)
    }
}

/// The bounding box of points of the picture.
#[derive(Debug)]
pub(super) struct ScreenBounds {
    pub(super) min: Vec2,
    pub(super) max: Vec2,
}

impl Default for ScreenBounds {
    fn default() -> Self {
        Self { min: Vec2::INFINITY, max: Vec2::NEG_INFINITY }
    }
}

impl ScreenBounds {
    pub(super) fn add(&mut self, at: Vec2) {
        (self.min, self.max) = (self.min.min(at), self.max.max(at));
    }

    /// The part of the picture's width or height that the box takes up, whichever is larger; 0
    /// without points.
    pub(super) fn largest(&self) -> f32 {
        (0.5 * (self.max - self.min)).max_element().max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinetree_world::CameraProjection;

    #[test]
    fn places_are_projected_to_where_their_ray_starts() {
        let camera = Camera::look_at([1.0, 2.0, 3.0], [4.0, 0.0, -1.0], 0.7);
        let (screen, projection) = (ScreenProjection::new(&camera, 1.5), CameraProjection::new(&camera, 1.5));
        for [x, y] in [[0.5, 0.5], [0.1, 0.9], [1.2, 0.3]] {
            let ray = projection.ray([x, y]);
            let (at, expected) = (screen.project(ray.at(5.0).into()), Vec2::new(2.0 * x - 1.0, 1.0 - 2.0 * y));
            assert!(at.is_some_and(|at| at.distance(expected) < 1e-4), "{at:?} {expected}");
            assert!(screen.ray(expected).angle_between(ray.direction.into()) < 1e-3);
            assert!(screen.project(ray.at(-5.0).into()).is_none());
        }
    }

    #[test]
    fn an_extent_without_points_is_nothing() {
        let mut extent = ScreenBounds::default();
        assert!(extent.largest() <= 0.0);
        extent.add(Vec2::new(-0.5, 0.0));
        extent.add(Vec2::new(0.5, 0.8));
        assert!((extent.largest() - 0.5).abs() < 1e-6);
    }
}
