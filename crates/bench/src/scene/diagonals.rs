//! Long thin triangles at random angles in a box: about the worst case for axis-aligned boxes.

use glam::Vec3;

use crate::rng::Rng;
use crate::soup::Soup;

/// Half the length of a triangle; their centres lie in a box of side two.
const REACH: f32 = 0.5;
/// Half the width of a triangle.
const WIDTH: f32 = 5e-4;

/// `count` triangles.
pub(crate) fn diagonals(seed: u64, count: usize) -> Soup {
    let mut rng = Rng::new(seed, 1);
    let mut positions = Vec::with_capacity(3 * count);
    for _ in 0..count {
        let middle = Vec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0));
        let along = rng.direction();
        let across = along.cross(rng.direction()).normalize_or(along.any_orthonormal_vector());
        let ends = [middle - along * REACH, middle + along * REACH];
        positions.extend([ends[0] - across * WIDTH, ends[0] + across * WIDTH, ends[1]]);
    }
    let triangles: Vec<[u32; 3]> = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mut soup = Soup::default();
    soup.add(positions, &triangles);
    soup
}
