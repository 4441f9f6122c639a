//! Morton codes: positions along a space-filling curve.
//!
//! A code interleaves the bits of the coordinates, so that neighbours along the curve are
//! neighbours in space. Each bit goes to the axis along which cells are longest at that level:
//! cells become cubes, and a flat or long scene spends no bits on axes without extent.
//!
//! Morton 1966, "A Computer Oriented Geodetic Data Base"; the choice of axes after Vinkler, Bittner
//! and Havran 2017, "Extended Morton Codes for High Performance Bounding Volume Hierarchy
//! Construction".

use crate::geometry::Aabb;

/// The most bits per axis: the precision of an `f32`.
const AXIS_BITS: usize = 24;

/// The Morton curve of a box.
pub(crate) struct Curve {
    start: [f32; 3],
    scale: [f32; 3],
    axes: [AxisBits; 3],
}

/// The bits of a code that hold the coordinate along one axis.
#[derive(Clone, Copy, Default)]
struct AxisBits {
    /// The number of bits.
    count: usize,
    /// The bit position in the code of each of them, the most significant first.
    positions: [u8; AXIS_BITS],
}

impl AxisBits {
    fn last_cell(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// The code with only the given bit of the coordinate set, counted from the lowest; zero beyond
    /// the last bit.
    fn deposit(&self, bit: usize) -> u64 {
        if bit < self.count { 1 << self.positions[self.count - 1 - bit] } else { 0 }
    }
}

impl Curve {
    /// The curve of a box, with codes below 2^`bits`.
    pub(crate) fn through(bounds: &Aabb, bits: u32) -> Self {
        let extent = bounds.extent();
        let mut cell = extent;
        let mut axes = [AxisBits::default(); 3];
        for bit in (0..bits).rev() {
            let mut longest = None;
            for axis in 0..3 {
                let may_have_more = cell[axis] > 0.0 && extent[axis].is_finite() && axes[axis].count < AXIS_BITS;
                // The first of equal axes.
                if may_have_more && longest.is_none_or(|longest: usize| cell[axis] > cell[longest]) {
                    longest = Some(axis);
                }
            }
            let Some(axis) = longest else { break };
            cell[axis] *= 0.5;
            let AxisBits { count, positions } = &mut axes[axis];
            positions[*count] = bit as u8;
            *count += 1;
        }
        let scale = [0, 1, 2].map(|axis| {
            let scale = (1_u32 << axes[axis].count) as f32 / extent[axis];
            if scale.is_finite() { scale } else { 0.0 }
        });
        Self { start: bounds.min, scale, axes }
    }

    /// The cell of a point along an axis. Points outside the box are clamped; the conversion maps
    /// NaN to 0.
    #[inline(always)]
    fn cell(&self, point: [f32; 3], axis: usize) -> u32 {
        (((point[axis] - self.start[axis]) * self.scale[axis]) as u32).min(self.axes[axis].last_cell())
    }

    /// The code of a point, bit by bit: the faster way for a few points.
    pub(crate) fn code(&self, point: [f32; 3]) -> u64 {
        let mut code = 0;
        for axis in 0..3 {
            let mut cell = self.cell(point, axis);
            let AxisBits { count, positions } = &self.axes[axis];
            for position in positions[..*count].iter().rev() {
                code |= u64::from(cell & 1) << position;
                cell >>= 1;
            }
        }
        code
    }

    /// The same curve with lookup tables, for many points.
    pub(crate) fn tabled(self) -> TabledCurve {
        let deposit = [0, 1, 2].map(|axis| [0, 1, 2].map(|byte| deposits(&self.axes[axis], byte)));
        TabledCurve { curve: self, deposit }
    }
}

/// A curve that looks up its codes, one byte of a coordinate at a time. Filling the tables takes as
/// long as the codes of about a hundred points.
pub(crate) struct TabledCurve {
    curve: Curve,
    /// For each axis, byte and value of the byte, the bits of the code.
    deposit: [[[u64; 256]; 3]; 3],
}

impl TabledCurve {
    /// As [`Curve::code`].
    #[inline]
    pub(crate) fn code(&self, point: [f32; 3]) -> u64 {
        let mut code = 0;
        for axis in 0..3 {
            let cell = self.curve.cell(point, axis);
            for byte in 0..3 {
                code |= self.deposit[axis][byte][(cell >> (8 * byte) & 255) as usize];
            }
        }
        code
    }
}

/// For each value of a byte of a coordinate, the bits of the code.
fn deposits(axis: &AxisBits, byte: usize) -> [u64; 256] {
    let mut all = [0; 256];
    for value in 1..256_usize {
        // The code without the lowest set bit has been computed before.
        let lowest = value.trailing_zeros() as usize;
        all[value] = all[value & (value - 1)] | axis.deposit(8 * byte + lowest);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_random::Random;

    #[test]
    fn a_cube_interleaves_its_axes() {
        let curve = Curve::through(&Aabb::new([0.0; 3], [8.0; 3]), 9);
        let tabled = Curve::through(&Aabb::new([0.0; 3], [8.0; 3]), 9).tabled();
        for x in 0..8_u64 {
            for y in 0..8_u64 {
                for z in 0..8_u64 {
                    let expected = (0..3).fold(0, |code, bit| {
                        code | (x >> bit & 1) << (3 * bit + 2)
                            | (y >> bit & 1) << (3 * bit + 1)
                            | (z >> bit & 1) << (3 * bit)
                    });
                    let middle = [x, y, z].map(|at| at as f32 + 0.5);
                    assert_eq!((curve.code(middle), tabled.code(middle)), (expected, expected), "{x} {y} {z}");
                }
            }
        }
    }

    #[test]
    fn bits_go_where_the_cells_are_long() {
        // Sixteen times as long as wide: the long axis gets four bits, then the axes alternate; the
        // flat axis gets none.
        let curve = Curve::through(&Aabb::new([0.0, 5.0, 0.0], [1.0, 5.0, 16.0]), 8);
        assert_eq!(curve.code([0.0, 5.0, 15.5]) >> 4, 15);
        assert_eq!(curve.code([0.9, 5.0, 0.0]), 0b0000_1010);
        assert_eq!(curve.code([0.0, 5.0, 0.9]), 0b0000_0101);
    }

    #[test]
    fn tables_give_the_codes_that_bits_give() {
        let mut generator = Random(11);
        let mut random = || generator.unit();
        for extent in [[1.0, 1.0, 1.0], [100.0, 3.0, 0.0], [1e-3, 7.0, 1e4], [0.0; 3]] {
            for bits in [3, 12, 33, 44, 60] {
                let bounds = Aabb::new([-2.0; 3], extent.map(|x| x - 2.0));
                let (curve, tabled) = (Curve::through(&bounds, bits), Curve::through(&bounds, bits).tabled());
                for _ in 0..200 {
                    let point = extent.map(|x| x * random() - 2.0);
                    assert_eq!(curve.code(point), tabled.code(point), "{point:?}, {bits} bits in {bounds:?}");
                }
            }
        }
    }

    #[test]
    fn every_point_has_a_code_within_range() {
        let huge = Aabb::new([-1e30; 3], [1e30; 3]);
        let endless = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
        for bounds in [Aabb::EMPTY, Aabb::new([1.0; 3], [1.0; 3]), huge, endless, Aabb::new([0.0; 3], [1e-42; 3])] {
            let curve = Curve::through(&bounds, 44);
            let tabled = Curve::through(&bounds, 44).tabled();
            for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 1.0, 1e30, f32::MAX] {
                assert!(curve.code([x; 3]) < 1 << 44, "{x} in {bounds:?}");
                assert_eq!(curve.code([x; 3]), tabled.code([x; 3]), "{x} in {bounds:?}");
            }
        }
        let curve = Curve::through(&huge, 44);
        assert_eq!((curve.code([-1e30; 3]), curve.code([1e30; 3])), (0, (1 << 44) - 1));
    }
}
