//! Placements: affine maps of space, read as `to_from_from`.

use std::ops::Mul;

use glam::{DVec3, Mat3, Quat, Vec3};

use super::{Aabb, UNIT_ROUNDOFF, is_finite};

/// An affine map: three column vectors and a translation. `world_from_object` takes points from
/// object space to the world.
///
/// Chains read from right to left: `world_from_car * car_from_wheel` is `world_from_wheel`.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Affine {
    /// The image of the x axis.
    pub x_axis: [f32; 3],
    /// The image of the y axis.
    pub y_axis: [f32; 3],
    /// The image of the z axis.
    pub z_axis: [f32; 3],
    /// The image of the origin.
    pub translation: [f32; 3],
}

const _: () = assert!(size_of::<Affine>() == 48);

impl Default for Affine {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Affine {
    /// The identity.
    pub const IDENTITY: Self =
        Self { x_axis: [1.0, 0.0, 0.0], y_axis: [0.0, 1.0, 0.0], z_axis: [0.0, 0.0, 1.0], translation: [0.0; 3] };

    /// From the images of the axes and of the origin.
    pub const fn from_columns(x_axis: [f32; 3], y_axis: [f32; 3], z_axis: [f32; 3], translation: [f32; 3]) -> Self {
        Self { x_axis, y_axis, z_axis, translation }
    }

    /// A translation.
    pub const fn from_translation(translation: [f32; 3]) -> Self {
        Self { translation, ..Self::IDENTITY }
    }

    /// A scale along each axis, about the origin.
    pub const fn from_scale(scale: [f32; 3]) -> Self {
        Self {
            x_axis: [scale[0], 0.0, 0.0],
            y_axis: [0.0, scale[1], 0.0],
            z_axis: [0.0, 0.0, scale[2]],
            translation: [0.0; 3],
        }
    }

    /// A rotation by a quaternion (x, y, z, w), which is normalised; zero means no rotation.
    pub fn from_quaternion(quaternion: [f32; 4]) -> Self {
        Self::from_scale_rotation_translation([1.0; 3], quaternion, [0.0; 3])
    }

    /// A rotation by an angle in radians about an axis of any length, counter-clockwise when the
    /// axis points at the viewer.
    pub fn from_axis_angle(axis: [f32; 3], radians: f32) -> Self {
        let axis = Vec3::from(axis).normalize_or(Vec3::Y);
        Self::from_quaternion(Quat::from_axis_angle(axis, radians).to_array())
    }

    /// A scale, then a rotation, then a translation.
    pub fn from_scale_rotation_translation(scale: [f32; 3], quaternion: [f32; 4], translation: [f32; 3]) -> Self {
        let quaternion = Quat::from_array(quaternion);
        let quaternion = if quaternion.length_squared() > 0.0 { quaternion.normalize() } else { Quat::IDENTITY };
        let turned = Mat3::from_quat(quaternion);
        let column = |axis: Vec3, scale: f32| (axis * scale).into();
        Self::from_columns(
            column(turned.x_axis, scale[0]),
            column(turned.y_axis, scale[1]),
            column(turned.z_axis, scale[2]),
            translation,
        )
    }

    /// Places an object at `eye` so that its -z axis looks at `target` and its +y axis is as near
    /// to `up` as can be.
    pub fn look_at(eye: [f32; 3], target: [f32; 3], up: [f32; 3]) -> Self {
        let back = (Vec3::from(eye) - Vec3::from(target)).normalize_or(Vec3::Z);
        let right = Vec3::from(up).cross(back).normalize_or(back.any_orthonormal_vector());
        Self::from_columns(right.into(), back.cross(right).into(), back.into(), eye)
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        is_finite(self.x_axis) && is_finite(self.y_axis) && is_finite(self.z_axis) && is_finite(self.translation)
    }

    fn linear(&self) -> Mat3 {
        Mat3::from_cols(self.x_axis.into(), self.y_axis.into(), self.z_axis.into())
    }

    /// The factor by which volumes grow; negative if the map mirrors.
    pub fn determinant(&self) -> f32 {
        self.linear().determinant()
    }

    /// The inverse; `None` if the map flattens space, or the inverse overflows.
    ///
    /// Computed in double precision and rounded once.
    #[must_use]
    pub fn inverse(&self) -> Option<Self> {
        Self::rounded(&self.inverse_rows()?, wide(self.translation))
    }

    /// The rows of the inverse of the linear part, in double precision; `None` when the map
    /// flattens space.
    pub(crate) fn inverse_rows(&self) -> Option<[DVec3; 3]> {
        let (columns, rows) = (self.columns(), self.cofactors());
        let determinant = columns[0].dot(rows[0]);
        let size = columns.iter().map(|column| column.length()).product::<f64>();
        let is_flat = !determinant.is_finite() || determinant.abs() <= FLAT * size;
        (!is_flat).then(|| rows.map(|row| row / determinant))
    }

    /// The map that takes `point` to the origin and has these rows, rounded once; `None` when it
    /// overflows.
    pub(crate) fn rounded(rows: &[DVec3; 3], point: DVec3) -> Option<Self> {
        let column = |axis: usize| [rows[0][axis] as f32, rows[1][axis] as f32, rows[2][axis] as f32];
        let translation = rows.map(|row| -row.dot(point) as f32);
        let map = Self::from_columns(column(0), column(1), column(2), translation);
        map.is_finite().then_some(map)
    }

    /// The images of the axes, in double precision.
    pub(crate) fn columns(&self) -> [DVec3; 3] {
        [self.x_axis, self.y_axis, self.z_axis].map(wide)
    }

    /// The cofactor matrix, by which areas transform: the cross products of the columns, in double
    /// precision. Each number has one rounding, since products of two `f32` are exact there.
    fn cofactors(&self) -> [DVec3; 3] {
        let [x, y, z] = self.columns();
        [y.cross(z), z.cross(x), x.cross(y)]
    }

    /// -1 when the map mirrors, else 1.
    pub(crate) fn handedness(&self) -> f64 {
        if self.columns()[0].dot(self.cofactors()[0]) < 0.0 { -1.0 } else { 1.0 }
    }

    /// Transforms a point.
    #[inline(always)]
    #[must_use]
    pub fn transform_point(&self, point: [f32; 3]) -> [f32; 3] {
        (Vec3::from(self.transform_vector(point)) + Vec3::from(self.translation)).into()
    }

    /// Transforms a direction or a displacement.
    #[inline(always)]
    #[must_use]
    pub fn transform_vector(&self, vector: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = vector;
        (Vec3::from(self.x_axis) * x + Vec3::from(self.y_axis) * y + Vec3::from(self.z_axis) * z).into()
    }

    /// Transforms a normal, by the inverse transpose up to a positive factor; its largest
    /// coordinate is then 1. Not normalised. If the map flattens space, the result is the normal of
    /// the flat image, on the side given by the winding of its corners.
    #[must_use]
    pub fn transform_normal(&self, normal: [f32; 3]) -> [f32; 3] {
        let ([x, y, z], normal) = (self.cofactors(), wide(normal) * self.handedness());
        let image = x * normal.x + y * normal.y + z * normal.z;
        // Cofactors of a tiny scale would vanish in single precision.
        let largest = image.abs().max_element();
        if largest > 0.0 { (image / largest).as_vec3().into() } else { [0.0; 3] }
    }

    /// A box around the transformed box, rounded outwards. Empty stays empty.
    #[must_use]
    pub fn transform_box(&self, bounds: &Aabb) -> Aabb {
        if bounds.is_empty() {
            return Aabb::EMPTY;
        }
        let center = Vec3::from(bounds.center());
        let half = Vec3::from(bounds.max) * 0.5 - Vec3::from(bounds.min) * 0.5;
        let columns = [self.x_axis, self.y_axis, self.z_axis].map(|column| Vec3::from(column).abs());
        let reach = columns[0] * half.x + columns[1] * half.y + columns[2] * half.z;
        let middle = Vec3::from(self.transform_point(center.into()));
        let size = columns[0] * center.x.abs() + columns[1] * center.y.abs() + columns[2] * center.z.abs();
        let padding = (size + reach + Vec3::from(self.translation).abs()) * (8.0 * UNIT_ROUNDOFF);
        Aabb::new((middle - reach - padding).into(), (middle + reach + padding).into())
    }
}

/// A map is flat if its determinant is at most this fraction of the product of its columns'
/// lengths: to within the rounding of the input, it is zero.
pub(crate) const FLAT: f64 = 8.0 * f32::EPSILON as f64;

/// Converts to double precision.
pub(crate) fn wide(v: [f32; 3]) -> DVec3 {
    Vec3::from(v).as_dvec3()
}

impl Mul for Affine {
    type Output = Self;

    /// The right one is applied first.
    fn mul(self, first: Self) -> Self {
        Self::from_columns(
            self.transform_vector(first.x_axis),
            self.transform_vector(first.y_axis),
            self.transform_vector(first.z_axis),
            self.transform_point(first.translation),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn odd() -> Affine {
        Affine::from_translation([3.0, -2.0, 7.0])
            * Affine::from_axis_angle([1.0, 2.0, -1.0], 1.1)
            * Affine::from_scale([2.0, -0.5, 3.0])
    }

    fn near(a: [f32; 3], b: [f32; 3]) -> bool {
        (Vec3::from(a) - Vec3::from(b)).length() < 1e-5
    }

    #[test]
    fn an_inverse_takes_back() {
        let there = odd();
        let back = there.inverse().unwrap();
        let point = [0.3, 5.0, -2.0];
        assert!(near(back.transform_point(there.transform_point(point)), point));
        assert!(near((there * back).transform_point(point), point));
    }

    #[test]
    fn flat_and_overflowing_maps_have_no_inverse() {
        assert_eq!(Affine::from_scale([1.0, 0.0, 1.0]).inverse(), None);
        assert_eq!(Affine::from_scale([0.0; 3]).inverse(), None);
        assert_eq!(Affine::from_scale([1e-39; 3]).inverse(), None);
        let watertight = Affine { y_axis: [1.0, 1e-9, 0.0], ..Affine::IDENTITY };
        assert_eq!(watertight.inverse(), None);
        assert!(Affine::from_scale([1e-6, 1e6, 1.0]).inverse().is_some());
    }

    #[test]
    fn normals_stay_upright_under_mirrors_and_stretching() {
        let map = odd();
        let (edge, other) = ([1.0, 2.0, 0.5], [-0.3, 1.0, 4.0]);
        let normal = Vec3::from(edge).cross(other.into());
        let moved = Vec3::from(map.transform_normal(normal.into()));
        assert!(moved.dot(map.transform_vector(edge).into()).abs() < 1e-4);
        assert!(moved.dot(map.transform_vector(other).into()).abs() < 1e-4);
        // A point above the plane stays on the side that the normal shows.
        assert!(moved.dot(map.transform_vector(normal.into()).into()) > 0.0);
    }

    #[test]
    fn a_moved_box_contains_its_moved_corners() {
        let map = odd();
        let bounds = Aabb::new([-1.0, 2.0, 0.0], [4.0, 2.5, 9.0]);
        let moved = map.transform_box(&bounds);
        for corner in 0..8 {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
            assert!(moved.contains_point(map.transform_point([pick(0), pick(1), pick(2)])));
        }
        assert!(map.transform_box(&Aabb::EMPTY).is_empty());
    }

    #[test]
    fn look_at_faces_its_target() {
        let camera = Affine::look_at([1.0, 2.0, 3.0], [1.0, 2.0, -5.0], [0.0, 1.0, 0.0]);
        assert!(near(camera.transform_vector([0.0, 0.0, -1.0]), [0.0, 0.0, -1.0]));
        let down = Affine::look_at([0.0, 9.0, 0.0], [0.0; 3], [0.0, 1.0, 0.0]);
        assert!(near(down.transform_vector([0.0, 0.0, -1.0]), [0.0, -1.0, 0.0]) && down.inverse().is_some());
    }
}
