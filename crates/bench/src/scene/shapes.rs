//! Meshes that scenes are made of.

use glam::Vec3;

/// A unit sphere about the origin: an octahedron whose edges are divided `cuts` times, of `8 * cuts
/// * cuts` triangles.
pub(crate) fn sphere(cuts: usize) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let cuts = cuts.max(1);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for face in 0..8_u32 {
        let sign = |bit: u32| if face >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let [x, y, z] = [Vec3::X * sign(0), Vec3::Y * sign(1), Vec3::Z * sign(2)];
        // An odd number of mirrorings reverses the orientation.
        let [a, b, c] = if face.count_ones() % 2 == 0 { [x, y, z] } else { [x, z, y] };
        let first = positions.len() as u32;
        for row in 0..=cuts {
            for column in 0..=cuts - row {
                let (i, j) = (row as f32, column as f32);
                positions.push((a * (cuts as f32 - i - j) + b * i + c * j).normalize());
            }
        }
        // Each row is one vertex shorter than the one before.
        let at =
            |row: usize, column: usize| first + (row * (cuts + 1) - row * row.saturating_sub(1) / 2 + column) as u32;
        for row in 0..cuts {
            for column in 0..cuts - row {
                triangles.push([at(row, column), at(row + 1, column), at(row, column + 1)]);
                if column + 1 < cuts - row {
                    triangles.push([at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)]);
                }
            }
        }
    }
    (positions, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_closed_and_faces_outwards() {
        for cuts in [1, 2, 5] {
            let (positions, triangles) = sphere(cuts);
            assert_eq!(triangles.len(), 8 * cuts * cuts);
            let mut volume = 0.0;
            for triangle in &triangles {
                let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
                let piece = a.dot(b.cross(c)) / 6.0;
                assert!(piece > 0.0);
                volume += piece;
            }
            assert!((1.3..4.2).contains(&volume), "{volume}");
        }
    }
}
