//! Counts how an engine's answers differ from exact ones.

use glam::{DVec3, Vec3};
use serde::Serialize;

use super::shape::Shape;
use crate::exact::{closest_by_brute_force, crossing};
use crate::ray::{Answer, Ray};

/// The relative error of distances that `Precision::Watertight` allows.
pub(super) const DISTANCE_BOUND: f64 = 1.0 / (1 << 14) as f64;

/// The exact answer of a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExactHit {
    /// The distance of the nearest hit, in lengths of the direction.
    t: f64,
}

/// The exact answers of rays from inside a shape; `None` for a ray that hits nothing, since
/// rounding has moved its origin outside.
pub(super) fn exact_hits(shape: &Shape, rays: &[Ray]) -> Vec<Option<ExactHit>> {
    let found = closest_by_brute_force(&shape.soup, rays);
    let exact = |(ray, answer): (&Ray, Answer)| {
        let found = answer.is_hit().then(|| crossing(ray, &shape.soup.corners(answer.primitive))).flatten();
        found.map(|found| ExactHit { t: found.t })
    };
    rays.iter().zip(found).map(exact).collect()
}

/// A ray with a wrong answer, as an example.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Example {
    shape: u64,
    origin: [f32; 3],
    direction: [f32; 3],
    #[serde(rename = "right")]
    exact: f64,
    /// `None` where the engine reported a miss.
    given: Option<f32>,
}

/// The counts of one engine.
#[derive(Debug, Clone, Default, Serialize)]
pub(super) struct Tally {
    /// Rays that cross the surface.
    pub(super) rays: usize,
    /// Of those, the number that hit nothing.
    pub(super) slips: usize,
    /// Hits on a triangle that the ray, in exact arithmetic, does not meet.
    pub(super) false_hits: usize,
    /// The largest distance between such a ray and the triangle, over half the width of the shape.
    pub(super) worst_pass: f64,
    /// Distances whose relative error is larger than `Precision::Watertight` allows.
    pub(super) wrong_distances: usize,
    /// The largest relative error of a distance.
    pub(super) worst_part: f64,
    /// The largest error of a hit along the ray, over half the width of the shape.
    pub(super) worst_error: f64,
    pub(super) first_slip: Option<Example>,
    pub(super) first_false_hit: Option<Example>,
    pub(super) first_wrong_distance: Option<Example>,
}

impl Tally {
    /// Whether all answers were right.
    pub(super) fn is_clean(&self) -> bool {
        self.slips + self.false_hits + self.wrong_distances == 0
    }

    /// Counts the answers to the rays of a shape.
    pub(super) fn count(
        &mut self,
        number: u64,
        shape: &Shape,
        rays: &[Ray],
        exact: &[Option<ExactHit>],
        given: &[Answer],
    ) {
        for ((ray, exact), given) in rays.iter().zip(exact).zip(given) {
            let Some(ExactHit { t }) = *exact else { continue };
            self.rays += 1;
            let t_given = given.is_hit().then_some(given.t);
            let example =
                Example { shape: number, origin: ray.origin, direction: ray.direction, exact: t, given: t_given };
            if !given.is_hit() {
                self.slips += 1;
                self.first_slip.get_or_insert(example);
                continue;
            }
            let corners = shape.soup.corners(given.primitive);
            if !crossing(ray, &corners).is_some_and(|crossing| crossing.is_hit) {
                self.false_hits += 1;
                self.worst_pass = self.worst_pass.max(distance(ray, &corners) / shape.half_width);
                self.first_false_hit.get_or_insert(example);
            }
            let error = (f64::from(given.t) - t).abs();
            let part = if error == 0.0 { 0.0 } else { error / t };
            if part > DISTANCE_BOUND {
                self.wrong_distances += 1;
                self.first_wrong_distance.get_or_insert(example);
            }
            self.worst_part = self.worst_part.max(part);
            let length = Vec3::from(ray.direction).as_dvec3().length();
            self.worst_error = self.worst_error.max(error * length / shape.half_width);
        }
    }
}

/// The distance between a ray and a triangle that it does not meet, metres: to the nearest edge, or
/// from the origin of the ray to the inside of the triangle.
fn distance(ray: &Ray, corners: &[Vec3; 3]) -> f64 {
    let origin = Vec3::from(ray.origin).as_dvec3();
    let corners = corners.map(|corner| corner.as_dvec3() - origin);
    let direction = Vec3::from(ray.direction).as_dvec3().normalize();
    let edges = [0, 1, 2].map(|from| to_segment(direction, corners[from], corners[(from + 1) % 3]));
    let nearest = edges.into_iter().fold(f64::INFINITY, f64::min);
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
    let foot = normal * normal.dot(corners[0]);
    let sides = [0, 1, 2].map(|from| {
        let (a, b) = (corners[from], corners[(from + 1) % 3]);
        normal.dot((b - a).cross(foot - a))
    });
    if normal != DVec3::ZERO && sides.iter().all(|side| *side >= 0.0) { nearest.min(foot.length()) } else { nearest }
}

/// The distance between a ray from the origin along a unit vector, and a segment (Ericson 2005,
/// "Real-Time Collision Detection", 5.1.9).
fn to_segment(direction: DVec3, from: DVec3, to: DVec3) -> f64 {
    let edge = to - from;
    let (edge_edge, along) = (edge.length_squared(), direction.dot(edge));
    let (ray_from, edge_from) = (direction.dot(from), edge.dot(from));
    let denominator = edge_edge - along * along;
    // For parallel lines, one end of the segment is as near as any of its points.
    let fraction = if denominator > 0.0 { (along * ray_from - edge_from) / denominator } else { 0.0 };
    let nearest = |fraction: f64| {
        let point = from + edge * fraction.clamp(0.0, 1.0);
        (point - direction * direction.dot(point).max(0.0)).length()
    };
    let behind = if edge_edge > 0.0 { -edge_from / edge_edge } else { 0.0 };
    [fraction, behind, 0.0, 1.0].into_iter().map(nearest).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_between_rays_and_triangles_are_right() {
        let triangle = [Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 4.0];
        let passes =
            |origin: [f32; 3], direction: [f32; 3]| distance(&Ray::new(origin.into(), direction.into()), &triangle);
        let cases = [
            ([1.0, -3.0, 5.0], [0.0, 0.0, -2.0], 3.0),
            // Pointing away from the inside of the triangle.
            ([1.0, 1.0, 5.0], [0.0, 0.0, 1.0], 5.0),
            ([-3.0, -4.0, 1.0], [0.0, 0.0, -1.0], 5.0),
            // Parallel to an edge.
            ([1.0, -2.0, 0.0], [1.0, 0.0, 0.0], 2.0),
            ([5.0, 0.0, 0.0], [1.0, 0.0, 0.0], 1.0),
            ([-5.0, 1.0, 2.0], [1.0, 0.0, 0.0], 2.0),
        ];
        for (origin, direction, expected) in cases {
            let found = passes(origin, direction);
            assert!((found - expected).abs() < 1e-12, "{origin:?} {direction:?}: {found}");
        }
    }

    #[test]
    fn slips_false_hits_and_wrong_distances_are_told_apart() {
        let shape = Shape::new(1, 0);
        let rays = super::super::rays::rays(&shape, 64, 1, 0);
        let exact = exact_hits(&shape, &rays);
        assert!(exact.iter().filter(|exact| exact.is_some()).count() > 60);
        let answers = closest_by_brute_force(&shape.soup, &rays);
        let tally = |answers: &[Answer]| {
            let mut tally = Tally::default();
            tally.count(0, &shape, &rays, &exact, answers);
            tally
        };
        let clean = tally(&answers);
        assert!(clean.is_clean() && clean.worst_part < 1e-7, "{clean:?}");
        let at = exact.iter().position(Option::is_some).unwrap();
        let mut slipped = answers.clone();
        slipped[at] = Answer::MISS;
        assert_eq!((tally(&slipped).slips, tally(&slipped).false_hits), (1, 0));
        let mut elsewhere = answers.clone();
        let missed = |primitive: &u32| crossing(&rays[at], &shape.soup.corners(*primitive)).is_none_or(|it| !it.is_hit);
        elsewhere[at].primitive = (0..shape.soup.len() as u32).find(missed).unwrap();
        let counted = tally(&elsewhere);
        assert!(counted.false_hits == 1 && counted.slips + counted.wrong_distances == 0 && counted.worst_pass > 0.0);
        let mut off = answers.clone();
        off[at].t *= 1.001;
        assert_eq!((tally(&off).wrong_distances, tally(&off).false_hits), (1, 0));
    }
}
