//! Where points stand along a space-filling curve.
//!
//! A code interleaves the bits of the coordinates, so that neighbours along the curve are neighbours in space. The next bit always goes to the axis along which cells are
//! longest by now: cells become cubes, and a flat or long scene spends no bits where it has no extent.
//!
//! Morton 1966, "A Computer Oriented Geodetic Data Base"; the choice of axes after Vinkler, Bittner and Havran 2017, "Extended Morton Codes for
//! High Performance Bounding Volume Hierarchy Construction".

use crate::geometry::Aabb;

/// Coordinates beyond this are finer than those of a point are.
const AXIS_BITS: u32 = 24;

/// A curve through a box.
pub(crate) struct Curve {
    start: [f32; 3],
    scale: [f32; 3],
    last_cell: [u32; 3],
    /// Which bits of the code each byte of a coordinate sets.
    deposit: [[[u64; 256]; 3]; 3],
}

impl Curve {
    /// Through a box, with codes below 2^`bits`.
    pub(crate) fn through(bounds: &Aabb, bits: u32) -> Self {
        let extent = bounds.extent();
        let mut cell = extent;
        // Per axis the bits of the code, those of coarse cells first.
        let mut given: [Vec<u32>; 3] = Default::default();
        for bit in (0..bits).rev() {
            let wants = |axis: &usize| {
                cell[*axis] > 0.0 && extent[*axis].is_finite() && given[*axis].len() < AXIS_BITS as usize
            };
            // Of equal axes, the first.
            let Some(axis) = (0..3).rev().filter(wants).max_by(|&a, &b| cell[a].total_cmp(&cell[b])) else { break };
            cell[axis] *= 0.5;
            given[axis].push(bit);
        }
        let cells = [0, 1, 2].map(|axis| 1_u32 << given[axis].len());
        let scale = [0, 1, 2].map(|axis| {
            let scale = cells[axis] as f32 / extent[axis];
            if scale.is_finite() { scale } else { 0.0 }
        });
        let deposit = [0, 1, 2].map(|axis| [0, 1, 2].map(|byte| deposits(&given[axis], byte)));
        Self { start: bounds.min, scale, last_cell: cells.map(|cells| cells - 1), deposit }
    }

    /// The code of a point. Points outside, and what is no number, have the code of some cell.
    #[inline]
    pub(crate) fn code(&self, point: [f32; 3]) -> u64 {
        let mut code = 0;
        for axis in 0..3 {
            let cell = (((point[axis] - self.start[axis]) * self.scale[axis]) as u32).min(self.last_cell[axis]);
            for byte in 0..3 {
                code |= self.deposit[axis][byte][(cell >> (8 * byte) & 255) as usize];
            }
        }
        code
    }
}

/// For each value of a byte of a coordinate, the bits of the code that it sets.
fn deposits(given: &[u32], byte: usize) -> [u64; 256] {
    std::array::from_fn(|value| {
        (0..8)
            .filter(|bit| value >> bit & 1 == 1)
            .filter_map(|bit| given.iter().rev().nth(8 * byte + bit))
            .fold(0, |code, &bit| code | 1 << bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_interleaves_its_axes() {
        let curve = Curve::through(&Aabb::new([0.0; 3], [8.0; 3]), 9);
        for x in 0..8_u64 {
            for y in 0..8_u64 {
                for z in 0..8_u64 {
                    let expected = (0..3).fold(0, |code, bit| {
                        code | (x >> bit & 1) << (3 * bit + 2)
                            | (y >> bit & 1) << (3 * bit + 1)
                            | (z >> bit & 1) << (3 * bit)
                    });
                    assert_eq!(curve.code([x, y, z].map(|at| at as f32 + 0.5)), expected, "{x} {y} {z}");
                }
            }
        }
    }

    #[test]
    fn bits_go_where_the_cells_are_long() {
        // Sixteen times as long as wide: four bits to the long axis, then both take turns; the flat axis gets none.
        let curve = Curve::through(&Aabb::new([0.0, 5.0, 0.0], [1.0, 5.0, 16.0]), 8);
        assert_eq!(curve.code([0.0, 5.0, 15.5]) >> 4, 15);
        assert_eq!(curve.code([0.9, 5.0, 0.0]), 0b0000_1010);
        assert_eq!(curve.code([0.0, 5.0, 0.9]), 0b0000_0101);
    }

    #[test]
    fn every_point_has_a_code_within_range() {
        let huge = Aabb::new([-1e30; 3], [1e30; 3]);
        let endless = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
        for bounds in [Aabb::EMPTY, Aabb::new([1.0; 3], [1.0; 3]), huge, endless, Aabb::new([0.0; 3], [1e-42; 3])] {
            let curve = Curve::through(&bounds, 44);
            for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 1.0, 1e30, f32::MAX] {
                assert!(curve.code([x; 3]) < 1 << 44, "{x} in {bounds:?}");
            }
        }
        let curve = Curve::through(&huge, 44);
        assert_eq!((curve.code([-1e30; 3]), curve.code([1e30; 3])), (0, (1 << 44) - 1));
    }
}
