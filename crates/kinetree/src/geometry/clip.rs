//! The bounds of the part of a triangle that lies in a box.
//!
//! Spatial splits (Stich, Friedrich and Dietrich 2009) bound the part of a triangle on each side of
//! a plane. The polygon is clipped in double precision and its box rounded outwards, so that it
//! contains the exact part.

use super::{Aabb, Triangle};

/// The box around the part of a triangle that lies in `bounds`; empty when there is none. It lies
/// within `bounds`.
pub(crate) fn clipped_bounds(triangle: &Triangle, bounds: &Aabb) -> Aabb {
    let mut polygon = Polygon::of(triangle);
    for axis in 0..3 {
        polygon = polygon.above(axis, f64::from(bounds.min[axis]), 1.0);
        polygon = polygon.above(axis, f64::from(bounds.max[axis]), -1.0);
    }
    polygon.points().iter().fold(Aabb::EMPTY, |all, point| all.union(&around(*point))).intersection(bounds)
}

/// At most nine corners: three, and one more for each plane.
struct Polygon {
    corners: [[f64; 3]; 9],
    count: usize,
}

impl Polygon {
    fn of(triangle: &Triangle) -> Self {
        let mut polygon = Self { corners: [[0.0; 3]; 9], count: 0 };
        triangle.corners.iter().for_each(|corner| polygon.push(corner.map(f64::from)));
        polygon
    }

    fn push(&mut self, point: [f64; 3]) {
        self.corners[self.count] = point;
        self.count += 1;
    }

    fn points(&self) -> &[[f64; 3]] {
        &self.corners[..self.count]
    }

    /// The part with `sign * x >= sign * plane` (Sutherland and Hodgman 1974). Points in the plane
    /// belong to it.
    fn above(&self, axis: usize, plane: f64, sign: f64) -> Self {
        let mut kept = Self { corners: [[0.0; 3]; 9], count: 0 };
        for (i, &from) in self.points().iter().enumerate() {
            let to = self.points()[(i + 1) % self.count];
            let (height, next) = ((from[axis] - plane) * sign, (to[axis] - plane) * sign);
            if height >= 0.0 {
                kept.push(from);
            }
            if (height > 0.0 && next < 0.0) || (height < 0.0 && next > 0.0) {
                let along = height / (height - next);
                let mut point = [0, 1, 2].map(|i| from[i] + (to[i] - from[i]) * along);
                point[axis] = plane;
                kept.push(point);
            }
        }
        kept
    }
}

/// The smallest box of single-precision numbers around a point.
fn around(point: [f64; 3]) -> Aabb {
    let below = point.map(|x| if f64::from(x as f32) > x { (x as f32).next_down() } else { x as f32 });
    let above = point.map(|x| if f64::from(x as f32) < x { (x as f32).next_up() } else { x as f32 });
    Aabb::new(below, above)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLOPE: Triangle = Triangle { corners: [[0.0, 0.0, 0.0], [4.0, 4.0, 0.0], [4.0, 0.0, 0.0]] };

    #[test]
    fn a_triangle_inside_keeps_its_box() {
        let all = Aabb::new([-1.0; 3], [5.0; 3]);
        assert_eq!(clipped_bounds(&SLOPE, &all), SLOPE.bounds());
    }

    #[test]
    fn a_cut_triangle_has_the_box_of_what_is_left() {
        let left = Aabb::new([0.0, -1.0, -1.0], [1.0, 9.0, 1.0]);
        assert_eq!(clipped_bounds(&SLOPE, &left), Aabb::new([0.0; 3], [1.0, 1.0, 0.0]));
    }

    #[test]
    fn both_sides_of_a_plane_cover_the_triangle() {
        for plane in [0.1_f32, 1.0 / 3.0, 2.7, 3.999_999] {
            let mut sides = [SLOPE.bounds(); 2];
            sides[0].max[0] = plane;
            sides[1].min[0] = plane;
            let [left, right] = sides.map(|side| clipped_bounds(&SLOPE, &side));
            assert_eq!(left.union(&right), SLOPE.bounds());
            assert!(left.max[1] >= plane && right.min[0] == plane);
        }
    }

    #[test]
    fn a_triangle_outside_leaves_nothing_and_one_that_touches_leaves_a_line() {
        assert!(clipped_bounds(&SLOPE, &Aabb::new([5.0; 3], [6.0; 3])).is_empty());
        let touching = clipped_bounds(&SLOPE, &Aabb::new([4.0, 0.0, 0.0], [9.0, 9.0, 9.0]));
        assert_eq!(touching, Aabb::new([4.0, 0.0, 0.0], [4.0, 4.0, 0.0]));
    }
}
