//! Pinhole cameras.

use glam::Vec3;
use kinetree::{Affine, Ray};

/// A pinhole camera. Without rotation it looks along -z, with +y up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position and orientation. The axes are used as directions only: scale has no effect.
    pub world_from_camera: Affine,
    /// Vertical field of view, radians.
    pub fov_y: f32,
}

impl Camera {
    /// A camera at `eye` that looks at `target`, with +y up.
    pub fn look_at(eye: [f32; 3], target: [f32; 3], fov_y: f32) -> Self {
        Self { world_from_camera: Affine::look_at(eye, target, [0.0, 1.0, 0.0]), fov_y }
    }

    /// The ray through a point of an image of `size` pixels, width and height, in world space with
    /// unit direction. `pixel` counts from the upper left corner; the centre of the first pixel is
    /// `[0.5, 0.5]`, so that positions of a mouse can be passed as they are.
    ///
    /// ```
    /// use kinetree_world::Camera;
    ///
    /// let camera = Camera::look_at([0.0, 0.0, 5.0], [0.0; 3], 0.8);
    /// let ray = camera.ray([320.0, 240.0], [640, 480]);
    /// assert_eq!((ray.origin, ray.direction), ([0.0, 0.0, 5.0], [0.0, 0.0, -1.0]));
    /// ```
    ///
    /// For many rays of one image, a [`CameraProjection`] does the work that they share once.
    pub fn ray(&self, pixel: [f32; 2], size: [u32; 2]) -> Ray {
        let [width, height] = size.map(|side| side.max(1) as f32);
        CameraProjection::new(self, width / height).ray([pixel[0] / width, pixel[1] / height])
    }

    /// Position, metres, world space.
    pub fn position(&self) -> [f32; 3] {
        self.world_from_camera.translation
    }
}

/// The perspective projection of a camera for images of one aspect ratio.
#[derive(Debug, Clone, Copy)]
pub struct CameraProjection {
    eye: Vec3,
    forward: Vec3,
    /// From the centre of the image plane at distance 1 to its right edge.
    right: Vec3,
    /// From the centre of the image plane at distance 1 to its upper edge.
    up: Vec3,
}

impl CameraProjection {
    /// `aspect` is width over height. Degenerate axes are replaced by valid ones, and the field of
    /// view is clamped to between 0.001 and 3.1 radians.
    pub fn new(camera: &Camera, aspect: f32) -> Self {
        let placement = &camera.world_from_camera;
        let finite =
            |vector: [f32; 3]| Some(Vec3::from(vector)).filter(|vector| vector.is_finite()).unwrap_or(Vec3::ZERO);
        let back = finite(placement.z_axis).normalize_or(Vec3::Z);
        let right = finite(placement.y_axis).cross(back).normalize_or(back.any_orthonormal_vector());
        let fov = if camera.fov_y.is_finite() { camera.fov_y.clamp(1e-3, 3.1) } else { 1.0 };
        let half = (fov * 0.5).tan();
        Self {
            eye: finite(placement.translation),
            forward: -back,
            right: right * half * aspect,
            up: back.cross(right) * half,
        }
    }

    /// Whether a point in world space projects into the image, occluded or not.
    #[inline]
    pub fn contains(&self, point: Vec3) -> bool {
        let offset = point - self.eye;
        let depth = offset.dot(self.forward);
        let within = |edge: Vec3| offset.dot(edge).abs() <= depth * edge.length_squared();
        depth > 0.0 && within(self.right) && within(self.up)
    }

    /// The ray through a point of the image, in world space with unit direction: (0, 0) is the
    /// upper left corner, (1, 1) the lower right.
    #[inline]
    pub fn ray(&self, [x, y]: [f32; 2]) -> Ray {
        let direction = self.forward + self.right * (2.0 * x - 1.0) + self.up * (1.0 - 2.0 * y);
        Ray::new(self.eye.into(), direction.normalize().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_image_is_upright_and_as_wide_as_its_aspect() {
        let camera = Camera { world_from_camera: Affine::IDENTITY, fov_y: std::f32::consts::FRAC_PI_2 };
        let projection = CameraProjection::new(&camera, 2.0);
        let at = |x, y| {
            let direction = Vec3::from(projection.ray([x, y]).direction);
            direction / -direction.z
        };
        assert!((at(0.5, 0.5) - Vec3::NEG_Z).length() < 1e-6);
        assert!((at(0.0, 0.0) - Vec3::new(-2.0, 1.0, -1.0)).length() < 1e-5);
        assert!((at(1.0, 1.0) - Vec3::new(2.0, -1.0, -1.0)).length() < 1e-5);
    }

    #[test]
    fn pixels_are_counted_from_the_upper_left_corner() {
        let camera = Camera::look_at([1.0, 2.0, 3.0], [4.0, 0.0, -1.0], 0.7);
        let projection = CameraProjection::new(&camera, 2.0);
        for (pixel, point) in [([0.0, 0.0], [0.0, 0.0]), ([0.5, 0.5], [0.125, 0.25]), ([4.0, 1.0], [1.0, 0.5])] {
            assert_eq!(camera.ray(pixel, [4, 2]), projection.ray(point));
        }
        assert!(Vec3::from(camera.ray([0.0; 2], [0, 0]).direction).is_normalized());
    }

    #[test]
    fn points_on_rays_of_the_image_are_in_it() {
        let projection = CameraProjection::new(&Camera::look_at([1.0, 2.0, 3.0], [4.0, 0.0, -1.0], 0.7), 1.5);
        for (point, is_inside) in
            [([0.01, 0.99], true), ([0.99, 0.01], true), ([-0.01, 0.5], false), ([0.5, 1.01], false)]
        {
            let ray = projection.ray(point);
            assert_eq!(projection.contains(ray.at(7.0).into()), is_inside, "{point:?}");
            assert!(!projection.contains((2.0 * Vec3::from(ray.origin)) - Vec3::from(ray.at(7.0))), "behind {point:?}");
        }
    }

    #[test]
    fn degenerate_cameras_have_finite_rays() {
        for value in [0.0, f32::NAN, f32::INFINITY, -1.0] {
            let axis = [value; 3];
            let camera = Camera { world_from_camera: Affine::from_columns(axis, axis, axis, axis), fov_y: value };
            let ray = CameraProjection::new(&camera, 1.0).ray([0.25, 0.75]);
            assert!(Vec3::from(ray.direction).is_normalized() && Vec3::from(ray.origin).is_finite());
        }
    }
}
