//! Warps from the unit square to directions and triangles, with their pdfs.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

/// A right-handed orthonormal basis around a normal.
///
/// Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
#[derive(Debug, Clone, Copy)]
pub(crate) struct Basis {
    tangent: Vec3,
    bitangent: Vec3,
    normal: Vec3,
}

impl Basis {
    /// The basis whose z axis is a unit vector.
    pub(crate) fn around(normal: Vec3) -> Self {
        let sign = 1.0_f32.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            tangent: Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            bitangent: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    /// Transforms a vector from this basis to world space.
    pub(crate) fn to_world(self, local: Vec3) -> Vec3 {
        self.tangent * local.x + self.bitangent * local.y + self.normal * local.z
    }
}

/// A point of the unit disc, uniform by area: the concentric map, which is continuous.
///
/// Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square".
fn disc(u: Vec2) -> Vec2 {
    let square = u * 2.0 - Vec2::ONE;
    if square == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle) = if square.x.abs() > square.y.abs() {
        (square.x, PI / 4.0 * (square.y / square.x))
    } else {
        (square.y, PI / 2.0 - PI / 4.0 * (square.x / square.y))
    };
    radius * Vec2::new(angle.cos(), angle.sin())
}

/// A direction about +z with pdf cosine over pi (Malley's method).
pub(crate) fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let point = disc(u);
    point.extend((1.0 - point.length_squared()).max(0.0).sqrt())
}

/// A direction within an angle of +z, uniform by solid angle. `versine` is one minus the cosine of
/// the angle, which keeps its precision for small angles.
pub(crate) fn cone(u: Vec2, versine: f32) -> Vec3 {
    let drop = u.x * versine;
    let radius = (drop * (2.0 - drop)).max(0.0).sqrt();
    let angle = 2.0 * PI * u.y;
    Vec3::new(radius * angle.cos(), radius * angle.sin(), 1.0 - drop)
}

/// Barycentric coordinates, the weights of the second and third vertex, uniform by area.
pub(crate) fn triangle(u: Vec2) -> [f32; 2] {
    let root = u.x.sqrt();
    [root * (1.0 - u.y), root * u.y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;

    fn mean(of: impl Fn(Vec2) -> f32) -> f32 {
        let count = 4096;
        (0..count).map(|i| of(Vec2::from(Sampler::new(1, [0, 0], i).next_2d()))).sum::<f32>() / count as f32
    }

    #[test]
    fn a_basis_is_orthonormal_and_right_handed() {
        for normal in [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z, Vec3::new(1.0, -2.0, 3.0).normalize()] {
            let basis = Basis::around(normal);
            assert!((basis.tangent.cross(basis.bitangent) - normal).length() < 1e-6);
            assert!(basis.tangent.dot(normal).abs() < 1e-6);
        }
    }

    #[test]
    fn the_hemisphere_has_the_moments_of_a_cosine() {
        // The mean cosine is 2/3, the mean of its square 1/2.
        assert!((mean(|u| cosine_hemisphere(u).z) - 2.0 / 3.0).abs() < 1e-3);
        assert!((mean(|u| cosine_hemisphere(u).z.powi(2)) - 0.5).abs() < 1e-3);
        assert!(mean(|u| cosine_hemisphere(u).x).abs() < 1e-3);
    }

    #[test]
    fn a_cone_is_uniform_by_solid_angle() {
        let versine = 0.3;
        assert!((mean(|u| cone(u, versine).z) - (1.0 - versine / 2.0)).abs() < 1e-3);
        assert!(mean(|u| (cone(u, versine).length() - 1.0).abs()) < 1e-6);
    }

    #[test]
    fn a_triangle_is_uniform_by_area() {
        assert!((mean(|u| triangle(u)[0]) - 1.0 / 3.0).abs() < 1e-3);
        assert!((mean(|u| triangle(u)[1]) - 1.0 / 3.0).abs() < 1e-3);
        // The second moment of a weight over a triangle is 1/6.
        assert!((mean(|u| triangle(u)[1].powi(2)) - 1.0 / 6.0).abs() < 1e-3);
    }
}
