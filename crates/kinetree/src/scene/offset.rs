//! Rays that leave a surface without meeting it again.
//!
//! The point that was hit is computed in double precision from the weights of the hit, so that it
//! lies in the plane of the triangle to within 2^-50 of the triangle's size, however large that is.
//! The origin of the new ray is a single-precision point next to it. It is transformed to object
//! space by the operations of the queries, and moved until it is there on the right side of the
//! plane and not past an edge. So the rounding of the transform is not assumed but measured.
//!
//! Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition 2023, section 6.8, bounds
//! the same errors; Waechter and Binder 2019, "A Fast and Robust Method for Avoiding
//! Self-Intersection".

use glam::{DMat3, DVec3};

use crate::geometry::{Affine, Precision, Ray, Triangle, UNIT_ROUNDOFF};
use crate::wide::InstanceRecord;

/// The least height of an origin over the plane, as a fraction of the distance to the farthest
/// corner. A watertight hit is never behind the origin of its ray, so any height that double
/// precision distinguishes from zero is enough.
const LEAST_HEIGHT: f64 = 1.0 / (1_u64 << 42) as f64;

/// A bound on the error of a point, as a fraction of its coordinates: the roundings of double
/// precision, and more.
const POINT_ERROR: f64 = 1.0 / (1_u64 << 48) as f64;

/// The same for triangles that are tested in single precision: some eight roundings.
const LEAST_HEIGHT_FAST: f64 = 1.0 / (1_u64 << 20) as f64;

/// How often an origin is moved. Each step at least doubles the distance, so the last ones exceed
/// all roundings.
const ATTEMPTS: usize = 32;

/// Where the perimeter of a triangle is at most this many times the radius of its incircle, origins
/// move towards the incentre; in a longer one, that would lead far away.
const MOST_PERIMETER_BY_INRADIUS: f64 = 32.0;

/// The point of a triangle with the weights of a hit, object space, in the plane of the triangle.
pub(super) fn point_at(triangle: &Triangle, u: f32, v: f32) -> DVec3 {
    let [a, b, c] = triangle.corners.map(wide);
    let (u, v) = (f64::from(u), f64::from(v));
    a * (1.0 - u - v) + b * u + c * v
}

/// A point of the object in the world, in double precision.
pub(super) fn to_world(map: &Affine, point: DVec3) -> DVec3 {
    linear(map) * point + wide(map.translation)
}

/// A bound on the error of weights that were rounded to single precision a few times.
const WEIGHT_ERROR: f64 = 1.0 / (1 << 22) as f64;

/// The point where a ray meets the plane of a triangle, world space, if it agrees with the weights
/// of the hit within their error; else the point by the weights.
pub(super) fn along(world_from_object: &Affine, triangle: &Triangle, [u, v]: [f32; 2], ray: &Ray) -> DVec3 {
    let by_weights = to_world(world_from_object, point_at(triangle, u, v));
    let [a, b, c] = triangle.corners.map(|corner| to_world(world_from_object, wide(corner)));
    let (origin, direction) = (wide(ray.origin), wide(ray.direction));
    let normal = (b - a).cross(c - a);
    let on_ray = origin + direction * (normal.dot(by_weights - origin) / normal.dot(direction));
    let size = (b - a).length().max((c - a).length());
    if on_ray.distance(by_weights) <= WEIGHT_ERROR * size { on_ray } else { by_weights }
}

/// The ray in a direction that starts at the point that was hit, just off the surface, on the side
/// that the direction points to.
pub(super) fn leave(
    world_from_object: &Affine,
    record: &InstanceRecord,
    (triangle, precision): (&Triangle, Precision),
    [u, v]: [f32; 2],
    direction: [f32; 3],
) -> Ray {
    if record.in_double {
        return leave_in_world(triangle, world_from_object, [u, v], direction);
    }
    let surface = Surface::new(triangle, point_at(triangle, u, v));
    let base = to_world(world_from_object, surface.point);
    // How the height above the plane, as queries see it, grows in the world.
    let gradient = linear(&record.object_from_world).transpose() * surface.normal;
    let toward = wide(direction);
    let side = if gradient.dot(toward) < 0.0 { -1.0 } else { 1.0 };
    let gradient = gradient * side;
    // By this step in the world the height grows by one.
    let up = gradient / gradient.length_squared();
    if !up.is_finite() {
        // A triangle without area, which no ray hits.
        return Ray::new(base.as_vec3().into(), direction);
    }
    let least = if precision == Precision::Fast { LEAST_HEIGHT_FAST } else { LEAST_HEIGHT };
    let least = least * surface.reach + POINT_ERROR * surface.point.abs().max_element();
    let (mut lift, mut turn) = (least, 0.0);
    // Along the plane, as a vector and as a fraction of the way to the incentre.
    let (mut shift, mut part) = (DVec3::ZERO, 0.0);
    let (mut ray, mut keeps_inside) = (Ray::new([0.0; 3], direction), true);
    for _ in 0..ATTEMPTS {
        ray.origin = rounded(base + linear(world_from_object) * shift + up * lift, up);
        if turn > 0.0 {
            ray.direction = rounded(toward + up * turn, up);
        }
        // A ray that can hit nothing in this object does not hit the surface it leaves.
        let Some(local) = record.enter(&ray) else { return ray };
        let origin = wide(local.origin);
        let height = side * surface.normal.dot(origin - surface.point);
        let slope = side * surface.normal.dot(wide(local.direction));
        let inward = if keeps_inside { surface.step_inward(origin, height) } else { DVec3::ZERO };
        if height >= least && slope >= 0.0 && inward == DVec3::ZERO {
            break;
        }
        if height < least {
            lift = 2.0 * (lift + least - height) + step(&record.object_from_world, base);
        }
        if slope < 0.0 {
            turn = 2.0 * (turn - slope);
        }
        if inward != DVec3::ZERO {
            let step = step(&record.object_from_world, base);
            part = 2.0 * part + (inward.length() + step) / surface.inradius();
            shift = surface.shift(part, 2.0 * (shift + inward) + inward.normalize_or_zero() * step);
        }
        // A triangle that has no point of single precision over it is left where it was hit.
        if part > 0.5 {
            (shift, part, keeps_inside) = (DVec3::ZERO, 0.0, false);
        }
    }
    ray
}

/// About the spacing of single precision where a world-space point is transformed to object space.
fn step(object_from_world: &Affine, point: DVec3) -> f64 {
    let map = linear(object_from_world);
    let point = point.abs();
    let terms = map.x_axis.abs() * point.x + map.y_axis.abs() * point.y + map.z_axis.abs() * point.z;
    (terms + wide(object_from_world.translation).abs()).max_element() * f64::from(UNIT_ROUNDOFF)
}

/// As [`leave`], for objects that rays enter in double precision, since the placement is flat or
/// badly skewed: the origin is moved off the plane in world space, by the size that roundings of
/// the mesh's own coordinates have there.
fn leave_in_world(triangle: &Triangle, world_from_object: &Affine, [u, v]: [f32; 2], direction: [f32; 3]) -> Ray {
    let point = to_world(world_from_object, point_at(triangle, u, v));
    let [a, b, c] = triangle.corners.map(|corner| to_world(world_from_object, wide(corner)));
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let side = if normal.dot(wide(direction)) < 0.0 { -normal } else { normal };
    let map = linear(world_from_object);
    let sizes = triangle.corners.map(|corner| {
        let corner = wide(corner).abs();
        (map.x_axis.abs() * corner.x + map.y_axis.abs() * corner.y + map.z_axis.abs() * corner.z).max_element()
    });
    let lift = LEAST_HEIGHT_FAST * sizes.into_iter().fold(point.abs().max_element(), f64::max);
    Ray::new(rounded(point + side * lift, side), direction)
}

/// A triangle and a point in its plane, object space.
struct Surface {
    corners: [DVec3; 3],
    point: DVec3,
    /// Unit, or zero for a triangle without area.
    normal: DVec3,
    /// The largest coordinate of a corner, relative to the point.
    reach: f64,
}

impl Surface {
    fn new(triangle: &Triangle, point: DVec3) -> Self {
        let corners = triangle.corners.map(wide);
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let reach = corners.map(|corner| (corner - point).abs().max_element()).into_iter().fold(0.0, f64::max);
        Self { corners, point, normal, reach }
    }

    /// The displacement along the plane that brings an origin at least as far from the edges as it
    /// is from the plane: where two walls meet, an origin that is rounded past the edge would be
    /// behind the other wall.
    fn step_inward(&self, origin: DVec3, height: f64) -> DVec3 {
        let [a, b, c] = self.corners;
        let mut way = DVec3::ZERO;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let across = self.normal.cross((to - from).normalize_or_zero());
            let missing = height - across.dot(origin - from);
            if missing > 0.0 {
                way += across * missing;
            }
        }
        way
    }

    /// The radius of the incircle.
    fn inradius(&self) -> f64 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a).length() / self.perimeter()
    }

    fn perimeter(&self) -> f64 {
        let [a, b, c] = self.corners;
        a.distance(b) + b.distance(c) + c.distance(a)
    }

    /// A fraction of the way to the incentre, which leads away from all edges; `otherwise` for a
    /// long thin triangle.
    fn shift(&self, part: f64, otherwise: DVec3) -> DVec3 {
        if self.perimeter() > MOST_PERIMETER_BY_INRADIUS * self.inradius() {
            return otherwise;
        }
        let [a, b, c] = self.corners;
        let middle = (a * b.distance(c) + b * c.distance(a) + c * a.distance(b)) / self.perimeter();
        (middle - self.point) * part
    }
}

/// Rounds to single precision, each coordinate to the side that a vector points to.
fn rounded(point: DVec3, toward: DVec3) -> [f32; 3] {
    [0, 1, 2].map(|axis| {
        let near = point[axis] as f32;
        let apart = f64::from(near) - point[axis];
        if toward[axis] > 0.0 && apart < 0.0 {
            near.next_up()
        } else if toward[axis] < 0.0 && apart > 0.0 {
            near.next_down()
        } else {
            near
        }
    })
}

fn linear(map: &Affine) -> DMat3 {
    DMat3::from_cols(wide(map.x_axis), wide(map.y_axis), wide(map.z_axis))
}

fn wide(v: [f32; 3]) -> DVec3 {
    glam::Vec3::from(v).as_dvec3()
}
