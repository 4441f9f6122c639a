//! Normals for vertices without a usable one.

/// The unit normal of a triangle, on the side from which it is counter-clockwise; +y for one
/// without an area.
pub(crate) fn face_normal(positions: &[[f32; 3]], triangle: [u32; 3]) -> [f32; 3] {
    // In double precision: neither the smallest nor the largest triangles may lose their normal.
    let [a, b, c] = triangle.map(|corner| glam::Vec3::from(positions[corner as usize]).as_dvec3());
    (b - a).cross(c - a).try_normalize().unwrap_or(glam::DVec3::Y).as_vec3().to_array()
}

/// Replaces normals that have no direction by that of a face at the vertex, and says how many there
/// were.
pub(crate) fn repair(normals: &mut [[f32; 3]], positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> usize {
    let broken = |normal: &[f32; 3]| !glam::Vec3::from(*normal).length_squared().is_normal();
    let count = normals.iter().filter(|normal| broken(normal)).count();
    if count > 0 {
        for &triangle in triangles {
            for corner in triangle {
                if broken(&normals[corner as usize]) {
                    normals[corner as usize] = face_normal(positions, triangle);
                }
            }
        }
        // What is left belongs to no triangle.
        normals.iter_mut().filter(|normal| broken(normal)).for_each(|normal| *normal = [0.0, 1.0, 0.0]);
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_normal_has_length_one_at_any_size() {
        for scale in [1e-18, 1e-3, 1.0, 1e18_f32] {
            let positions = [[0.0; 3], [scale, 0.0, 0.0], [0.0, scale, 0.0]];
            assert_eq!(face_normal(&positions, [0, 1, 2]), [0.0, 0.0, 1.0], "at {scale}");
            assert_eq!(face_normal(&positions, [0, 2, 1]), [0.0, 0.0, -1.0], "at {scale}");
        }
        assert_eq!(face_normal(&[[1.0; 3]; 3], [0, 1, 2]), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn only_broken_normals_are_replaced() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [5.0; 3]];
        let mut normals = [[1.0, 0.0, 0.0], [0.0; 3], [f32::NAN, 0.0, 1.0], [f32::INFINITY; 3]];
        assert_eq!(repair(&mut normals, &positions, &[[0, 1, 2]]), 3);
        assert_eq!(normals, [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]);
    }
}
