//! Where a ray meets a triangle, and whether it does, with the result of exact arithmetic.
//!
//! The signs of three volumes, each spanned by the direction and two corners relative to the
//! origin, say on which side of each edge the ray passes. They are computed in `f64` with an error
//! bound; where the bound does not determine the sign, without rounding.

use std::cmp::Ordering;

use glam::{DVec3, Vec3};

use super::expansion::Expansion;
use crate::ray::Ray;

/// The intersection of a ray's line with the plane of a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Crossing {
    /// The distance in lengths of the direction, with a relative error below 2^-36.
    pub(crate) t: f64,
    /// Whether the point lies within the triangle, edges and corners included, and not behind the
    /// origin. Exact.
    pub(crate) is_hit: bool,
}

/// The distance at which a ray meets a triangle; `None` if it does not, or if the triangle is seen
/// edge on or has no area.
pub(crate) fn hit(ray: &Ray, corners: &[Vec3; 3]) -> Option<f64> {
    let signs = Volumes::of(ray, corners).sides.map(Volume::sign);
    // A quick rejection: most triangles are missed by a wide margin.
    if signs.contains(&Some(Ordering::Less)) && signs.contains(&Some(Ordering::Greater)) {
        return None;
    }
    crossing(ray, corners).filter(|crossing| crossing.is_hit).map(|crossing| crossing.t)
}

/// `None` if the line is parallel to the plane of the triangle, or the triangle has no area.
pub(crate) fn crossing(ray: &Ray, corners: &[Vec3; 3]) -> Option<Crossing> {
    let Volumes { sides, over } = Volumes::of(ray, corners);
    let t = Quotient { over, under: sides[0] + sides[1] + sides[2] }.value();
    match (sides.map(Volume::sign), t) {
        ([Some(a), Some(b), Some(c)], Some(t)) => Some(Crossing { t, is_hit: a == b && b == c && t >= 0.0 }),
        _ => crossing_without_rounding(ray, corners),
    }
}

/// The volumes that determine the intersection.
struct Volumes {
    /// Spanned by the direction and two corners each.
    sides: [Volume; 3],
    /// Spanned by the three corners.
    over: Volume,
}

impl Volumes {
    fn of(ray: &Ray, corners: &[Vec3; 3]) -> Self {
        let from = |corner: &Vec3| corner.as_dvec3() - Vec3::from(ray.origin).as_dvec3();
        let [a, b, c] = [from(&corners[0]), from(&corners[1]), from(&corners[2])];
        let d = Vec3::from(ray.direction).as_dvec3();
        Self { sides: [Volume::of(d, b, c), Volume::of(d, c, a), Volume::of(d, a, b)], over: Volume::of(a, b, c) }
    }
}

/// A volume in floating point, and a bound of its error.
#[derive(Clone, Copy)]
struct Volume {
    value: f64,
    error: f64,
}

/// The error of a volume, relative to the sum of the absolute values of its six products: three
/// roundings of differences and four of products and sums, each 2^-53, doubled for safety.
const ERROR: f64 = 16.0 / (1_u64 << 53) as f64;

impl Volume {
    /// The volume spanned by three vectors.
    fn of(a: DVec3, b: DVec3, c: DVec3) -> Self {
        let value = a.dot(b.cross(c));
        let sizes = DVec3::new(
            (b.y * c.z).abs() + (b.z * c.y).abs(),
            (b.z * c.x).abs() + (b.x * c.z).abs(),
            (b.x * c.y).abs() + (b.y * c.x).abs(),
        );
        Self { value, error: ERROR * a.abs().dot(sizes) }
    }

    /// `None` if the error bound does not determine the sign.
    fn sign(self) -> Option<Ordering> {
        (self.value.abs() > self.error).then(|| self.value.total_cmp(&0.0))
    }
}

impl std::ops::Add for Volume {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let value = self.value + other.value;
        Self { value, error: self.error + other.error + ERROR * value.abs() }
    }
}

/// A distance as the quotient of two volumes.
struct Quotient {
    over: Volume,
    under: Volume,
}

/// The largest relative error of a volume from which a distance may be computed.
const ENOUGH: f64 = 1.0 / (1_u64 << 38) as f64;

impl Quotient {
    /// `None` if the error may be larger than allowed.
    fn value(&self) -> Option<f64> {
        let good = |volume: &Volume| volume.error < volume.value.abs() * ENOUGH;
        (good(&self.over) && good(&self.under)).then(|| self.over.value / self.under.value)
    }
}

/// As `crossing`, without rounding.
fn crossing_without_rounding(ray: &Ray, corners: &[Vec3; 3]) -> Option<Crossing> {
    type Vector = [Expansion; 3];
    let from = |corner: &Vec3| -> Vector {
        [0, 1, 2].map(|axis| Expansion::difference(f64::from(corner[axis]), f64::from(ray.origin[axis])))
    };
    let volume = |a: &Vector, b: &Vector, c: &Vector| -> Expansion {
        let minor = |i: usize, j: usize| &(&b[i] * &c[j]) - &(&b[j] * &c[i]);
        &(&(&a[0] * &minor(1, 2)) + &(&a[1] * &minor(2, 0))) + &(&a[2] * &minor(0, 1))
    };
    let d: Vector = ray.direction.map(|x| Expansion::difference(f64::from(x), 0.0));
    let [a, b, c] = [from(&corners[0]), from(&corners[1]), from(&corners[2])];
    let sides = [volume(&d, &b, &c), volume(&d, &c, &a), volume(&d, &a, &b)];
    let (over, under) = (volume(&a, &b, &c), &(&sides[0] + &sides[1]) + &sides[2]);
    if under.sign() == Ordering::Equal {
        return None;
    }
    let outside = Ordering::reverse(under.sign());
    let within = sides.iter().all(|side| side.sign() != outside);
    let is_ahead = over.sign() == Ordering::Equal || over.sign() == under.sign();
    Some(Crossing { t: over.value() / under.value(), is_hit: within && is_ahead })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
        Ray::new(origin.into(), direction.into())
    }

    #[test]
    fn edges_and_corners_belong_to_the_triangle_and_what_is_behind_does_not() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let found = |x: f32, y: f32, z: f32, down: f32| {
            crossing(&ray([x, y, z], [0.0, 0.0, down]), &triangle).map(|crossing| (crossing.t, crossing.is_hit))
        };
        assert_eq!(found(0.25, 0.25, 2.0, -1.0), Some((2.0, true)));
        assert_eq!(found(0.25, 0.25, 2.0, -0.5), Some((4.0, true)));
        assert_eq!(found(0.25, 0.25, -2.0, 1.0), Some((2.0, true)));
        assert_eq!(found(0.25, 0.25, 2.0, 1.0), Some((-2.0, false)));
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.5, 0.0), (0.0, 0.25)] {
            assert_eq!(found(x, y, 1.0, -1.0), Some((1.0, true)), "{x} {y}");
        }
        for (x, y) in [(-1e-40, 0.0), (0.5, 0.500_000_06), (0.5, -1e-45), (1.000_000_1, 0.0)] {
            assert_eq!(found(x, y, 1.0, -1.0), Some((1.0, false)), "{x} {y}");
        }
        assert_eq!(crossing(&ray([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0]), &triangle), None);
        assert_eq!(crossing(&ray([0.0; 3], [0.0, 0.0, 1.0]), &[Vec3::X, Vec3::X, Vec3::Y]), None);
        assert_eq!(found(0.25, 0.25, 0.0, -1.0), Some((0.0, true)));
    }

    /// Rays against long thin triangles, with known distances.
    #[test]
    fn long_thin_triangles_are_met_where_they_are() {
        let thin = [[-1.0, -1.0, 0.0], [-1.0, 1.0, 1e4], [-1.0, 1.0, 0.0]].map(Vec3::from);
        let found = crossing(&ray([-0.73255056, -0.88905156, 6064.6772], [-0.12834036, 0.5289329, 0.67851985]), &thin);
        let exact = (-1.0 + f64::from(0.732_550_56_f32)) / f64::from(-0.128_340_36_f32);
        assert!((found.unwrap().t - exact).abs() < 1e-9 && (exact - 2.0839).abs() < 1e-4);

        let behind = [[-1.0, 1.0, 0.0], [-1.0, 1.0, 1e5], [1.0, 1.0, 1e5]].map(Vec3::from);
        let found = crossing(&ray([-0.71970516, 0.67832696, 10136.273], [0.40267408, -0.46208763, 0.6626947]), &behind);
        assert!(!found.unwrap().is_hit && found.unwrap().t < 0.0);
    }

    #[test]
    fn floats_and_exact_sums_agree_and_neighbours_share_every_ray() {
        let mut both = 0;
        for stream in 0..20_000 {
            let mut rng = Rng::new(3, stream);
            // Few different coordinates, so that many cases are degenerate.
            let mut point = || Vec3::new(rng.below(5) as f32, rng.below(5) as f32, rng.below(5) as f32);
            let [a, b, c, d, origin, through] = [point(), point(), point(), point(), point(), point()];
            let ray = Ray::new(origin, through - origin);
            for triangle in [[a, b, c], [d, c, b]] {
                assert_eq!(
                    crossing(&ray, &triangle).map(|it| it.is_hit),
                    crossing_without_rounding(&ray, &triangle).map(|it| it.is_hit)
                );
                both += usize::from(crossing(&ray, &triangle).is_some_and(|it| it.is_hit));
            }
        }
        assert!(both > 1000);
    }
}
