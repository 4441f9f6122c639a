//! Closed tubes and boxes: prisms whose neighbouring triangles share their corners, from compact to
//! very long.

use glam::{DVec2, DVec3, Vec3};

use crate::rng::Rng;
use crate::soup::Soup;

/// Widths and lengths, metres, before scaling.
const WIDTHS: [f64; 2] = [0.01, 1.0];
const LENGTHS: [f64; 2] = [1.0, 1e6];
/// Shapes are scaled by factors from 1 / `SCALE` to `SCALE`.
const SCALE: f64 = 1e6;
/// How far from the origin shapes may lie, metres.
const OFFSETS: [f64; 2] = [1e-8, 1e6];
/// The least width of a shape in units in the last place of its largest coordinate: thinner ones
/// are no longer tubes after rounding.
const LEAST_WIDTH: f64 = 1000.0;

/// Corners of cross sections, within [-1, 1] x [-1, 1].
const SECTIONS: [&[[f64; 2]]; 4] = [
    &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
    &[[-1.0, -1.0], [1.0, -1.0], [0.0, 1.0]],
    &[[1.0, 0.0], [0.5, 1.0], [-0.5, 1.0], [-1.0, 0.0], [-0.5, -1.0], [0.5, -1.0]],
    &[[1.0, -0.5], [1.0, 0.5], [0.5, 1.0], [-0.5, 1.0], [-1.0, 0.5], [-1.0, -0.5], [-0.5, -1.0], [0.5, -1.0]],
];

/// A closed shape with the functions that find points in it and on it.
pub(super) struct Shape {
    pub(super) soup: Soup,
    /// Half the width of the cross section, metres.
    pub(super) half_width: f64,
    section: &'static [[f64; 2]],
    length: f64,
    middle: DVec3,
    /// Two axes of the cross section, and the axis along the shape.
    axes: [DVec3; 3],
}

impl Shape {
    /// Shape number `number` of a seed.
    pub(super) fn new(seed: u64, number: u64) -> Self {
        let mut rng = Rng::new(seed, number << 8 | 0xc1);
        let section = SECTIONS[rng.below(2 * SECTIONS.len() - 1).saturating_sub(SECTIONS.len() - 1)];
        let axes = axes(&mut rng);
        loop {
            let scale = log_between(&mut rng, [1.0 / SCALE, SCALE]);
            let half_width = log_between(&mut rng, WIDTHS) * 0.5 * scale;
            let length = log_between(&mut rng, LENGTHS) * scale;
            let mut offset = || f64::from(rng.between(-1.0, 1.0));
            let direction = DVec3::new(offset(), offset(), offset());
            let middle = match rng.below(4) {
                0 => DVec3::ZERO,
                // As far from the origin as the width allows.
                1 => direction * (half_width / (LEAST_WIDTH * f64::from(f32::EPSILON))).min(OFFSETS[1]),
                _ => direction * log_between(&mut rng, OFFSETS),
            };
            let rings = 2 + rng.below(3);
            let shape = Self { soup: Soup::default(), half_width, section, length, middle, axes };
            let ring_positions: Vec<f64> = (0..rings).map(|ring| shape.ring(ring, rings, &mut rng)).collect();
            if let Some(shape) = shape.with_soup(&ring_positions, &mut rng) {
                return shape;
            }
        }
    }

    /// The position of a ring of corners along the shape, from -1 to 1.
    fn ring(&self, ring: usize, rings: usize, rng: &mut Rng) -> f64 {
        let between = (ring > 0 && ring + 1 < rings).then(|| f64::from(rng.between(-0.3, 0.3)));
        (2 * ring) as f64 / (rings - 1) as f64 - 1.0 + between.unwrap_or(0.0)
    }

    /// The point with coordinates `across` in half widths on the cross section and `along` from -1
    /// to 1.
    fn point(&self, across: DVec2, along: f64) -> Vec3 {
        let [x, y, z] = self.axes;
        (self.middle + (x * across.x + y * across.y) * self.half_width + z * (along * self.length * 0.5)).as_vec3()
    }

    /// Adds the triangles; `None` when the shape is too thin for its distance from the origin.
    fn with_soup(mut self, ring_positions: &[f64], rng: &mut Rng) -> Option<Self> {
        let sides = self.section.len() as u32;
        let corners =
            ring_positions.iter().flat_map(|along| self.section.iter().map(|at| self.point(DVec2::from(*at), *along)));
        let positions: Vec<Vec3> = corners.collect();
        let largest = positions.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
        let unit = f64::from(f32::from_bits(largest.to_bits() + 1) - largest);
        if 2.0 * self.half_width < LEAST_WIDTH * unit {
            return None;
        }
        let mut triangles = Vec::new();
        let mut quad = |[a, b, c, d]: [u32; 4]| {
            triangles.extend(if rng.below(2) == 0 { [[a, b, c], [a, c, d]] } else { [[b, c, d], [b, d, a]] });
        };
        for ring in 0..ring_positions.len() as u32 - 1 {
            for side in 0..sides {
                let (from, to) = (ring * sides + side, ring * sides + (side + 1) % sides);
                quad([from, to, to + sides, from + sides]);
            }
        }
        let last = (ring_positions.len() as u32 - 1) * sides;
        for side in 1..sides - 1 {
            triangles.push([0, side + 1, side]);
            triangles.push([last, last + side, last + side + 1]);
        }
        // Hits do not depend on the orientation and the first corner of a triangle.
        for triangle in &mut triangles {
            triangle.rotate_left(rng.below(3));
            if rng.below(2) == 0 {
                triangle.swap(0, 1);
            }
        }
        self.soup.add(positions, &triangles);
        Some(self)
    }

    /// A random point inside, at the fraction `outwards` (below 1) of the way from the axis to the
    /// wall.
    pub(super) fn inside(&self, rng: &mut Rng, outwards: f64) -> Vec3 {
        let along = f64::from(rng.between(-0.999, 0.999));
        self.point(self.on_the_section(rng) * outwards, along)
    }

    /// A random point of the wall at the position `along`, from -1 to 1.
    pub(super) fn side(&self, rng: &mut Rng, along: f64) -> Vec3 {
        self.point(self.on_the_section(rng), along)
    }

    fn on_the_section(&self, rng: &mut Rng) -> DVec2 {
        let from = rng.below(self.section.len());
        let [a, b] = [from, (from + 1) % self.section.len()].map(|at| DVec2::from(self.section[at]));
        a.lerp(b, f64::from(rng.uniform()))
    }

    /// The position of a point along the shape, from -1 to 1.
    pub(super) fn along(&self, point: Vec3) -> f64 {
        (point.as_dvec3() - self.middle).dot(self.axes[2]) / (self.length * 0.5)
    }

    /// A random point on an edge between two triangles, often a corner.
    pub(super) fn edge(&self, rng: &mut Rng) -> Vec3 {
        let corners = self.soup.corners(rng.below(self.soup.len()) as u32);
        let from = rng.below(3);
        let fraction = if rng.below(4) == 0 { 0.0 } else { f64::from(rng.uniform()) };
        corners[from].as_dvec3().lerp(corners[(from + 1) % 3].as_dvec3(), fraction).as_vec3()
    }

    /// The direction along the shape.
    pub(super) fn axis(&self) -> Vec3 {
        self.axes[2].as_vec3()
    }
}

/// The axes of the world in some order, or a random orthonormal basis.
fn axes(rng: &mut Rng) -> [DVec3; 3] {
    if rng.below(3) > 0 {
        let mut axes = [DVec3::X, DVec3::Y, DVec3::Z];
        rng.shuffle(&mut axes);
        return axes;
    }
    let along = rng.direction().as_dvec3().normalize();
    let across = along.any_orthonormal_vector();
    [across, along.cross(across), along]
}

/// A random number whose logarithm is evenly distributed.
fn log_between(rng: &mut Rng, [low, high]: [f64; 2]) -> f64 {
    low * (high / low).powf(f64::from(rng.uniform()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn every_edge_is_shared_by_two_triangles_and_sizes_are_of_all_kinds() {
        let (mut slimmest, mut smallest, mut largest, mut farthest) = (0.0_f64, f64::INFINITY, 0.0_f64, 0.0_f64);
        for number in 0..2000 {
            let shape = Shape::new(1, number);
            let mut edges = BTreeMap::new();
            for triangle in &shape.soup.triangles {
                for from in 0..3 {
                    let [a, b] = [triangle[from], triangle[(from + 1) % 3]];
                    *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
                }
            }
            assert!(edges.values().all(|count| *count == 2), "shape {number}");
            slimmest = slimmest.max(shape.length / shape.half_width);
            smallest = smallest.min(shape.half_width);
            largest = largest.max(shape.half_width);
            farthest = farthest.max(shape.middle.abs().max_element());
        }
        assert!(slimmest > 1e4 && smallest < 1e-7 && largest > 1e5 && farthest > 1e5);
    }
}
