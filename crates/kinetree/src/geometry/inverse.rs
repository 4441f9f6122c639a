//! How rays enter an instance: by the inverse of its placement in single precision where that is
//! exact enough, in double precision where it is not.
//!
//! Let M be the linear part of a placement, N its rounded inverse, o and d a ray, and x = o + t d a
//! point of it. Computing N o + s and N d in single precision errs by at most `g (|N||o| + |s|)`
//! and `g |N||d|`, g being a few roundings; seen from the world, by `g (|M||N|) (|o| + t |d|)` and
//! `g |M||s|`. The matrix `|M||N|` of absolute values says which placements are harmless: its rows
//! sum to at most 3 for a rotation after a scale, whatever the scale, since stretching an axis of
//! the object cancels in it. Only skew makes it larger. (Higham 2002, "Accuracy and Stability of
//! Numerical Algorithms", section 7.2, calls it the condition number of Bauer and Skeel.)
//!
//! * Up to [`COVERED_SKEW`], the error bound of box tests of the top level is enough
//!   ([`ErrorBound::INSTANCES`](super::slab::ErrorBound::INSTANCES)).
//! * Up to [`MOST_SKEWED`], boxes and far rays are padded more (`scene/top_level.rs`).
//! * Beyond, and for flat placements, the ray is taken to the object in double precision, moved to
//!   where it enters the bounds of the mesh, and rounded only there: the remaining errors are
//!   roundings of the mesh's own coordinates ([`DoubleInverse`]).

use glam::DVec3;

use super::affine::wide;
use super::{Aabb, Affine, Ray, UNIT_ROUNDOFF};

/// The row sums of `|M||N|` that the error bound of box tests covers for every ray: 3, and a little
/// more for placements that are rotations and scales only up to rounding.
pub(crate) const COVERED_SKEW: f32 = 3.2;

/// Rows of `|M||N|` that sum to more go through double precision: the errors of single precision
/// would begin to show, and boxes would become large.
const MOST_SKEWED: f32 = 16.0;

/// Columns shorter than this count as zero where the inverse overflows, metres.
const VANISHING: f64 = 1e-36;

/// The inverse of a placement.
#[derive(Debug, Clone)]
pub(crate) enum Inverse {
    /// In single precision.
    Single {
        object_from_world: Affine,
        /// The row sums of `|M||N|`.
        skew: [f32; 3],
    },
    Double(Box<DoubleInverse>),
}

/// The inverse of a placement that is flat along one axis, or badly skewed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DoubleInverse {
    /// Rows of the inverse of the linear part.
    rows: [DVec3; 3],
    /// The image of the object's origin, metres, world space.
    center: DVec3,
    /// The map that is inverted: the placement, or the placement after its nearly flat image was
    /// made exactly flat.
    pub(crate) world_from_object: Affine,
    flat: Option<Flat>,
}

/// How a flat object is projected onto its plane.
#[derive(Debug, Clone, Copy)]
struct Flat {
    /// Unit normal of the plane, world space.
    normal: DVec3,
    /// Unit vector that the placement takes to zero, object space; towards the side of the object
    /// that is seen from the side that the normal points to.
    along: DVec3,
}

/// A ray in object space; its origin may have been moved along it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalRay {
    pub(crate) ray: Ray,
    /// Distances along the world ray are `start + rate * t`.
    start: f64,
    rate: f64,
}

impl Inverse {
    /// The inverse of a finite placement; `None` if it is flat along two or three axes, or the
    /// inverse overflows.
    pub(crate) fn of(world_from_object: &Affine) -> Option<Self> {
        let center = wide(world_from_object.translation);
        let columns = world_from_object.columns();
        if let Some(rows) = world_from_object.inverse_rows()
            && let Some(object_from_world) = Affine::rounded(&rows, center)
        {
            let skew = row_sums(&columns, &rows);
            if skew.iter().all(|&sum| sum <= MOST_SKEWED) {
                return Some(Self::Single { object_from_world, skew });
            }
            let world_from_object = *world_from_object;
            return Some(Self::Double(Box::new(DoubleInverse { rows, center, world_from_object, flat: None })));
        }
        DoubleInverse::flattened(world_from_object).map(Box::new).map(Self::Double)
    }

    /// The inverse, rounded to single precision; `None` if it overflows.
    pub(crate) fn object_from_world(&self) -> Option<Affine> {
        match self {
            Self::Single { object_from_world, .. } => Some(*object_from_world),
            Self::Double(double) => Affine::rounded(&double.rows, double.center),
        }
    }

    /// A bound on the part of the rays' error near an instance that does not depend on their
    /// origin, metres along each axis, world space. `bounds` are those of the mesh.
    pub(crate) fn error(&self, world_from_object: &Affine, bounds: &Aabb) -> [f32; 3] {
        let columns = world_from_object.columns();
        let local = match self {
            // The translation of the inverse is rounded when it is made, and when it is added.
            Self::Single { object_from_world, .. } => wide(object_from_world.translation).abs() * 4.0,
            Self::Double(double) => double.local_error(bounds),
        };
        let error = columns[0].abs() * local.x + columns[1].abs() * local.y + columns[2].abs() * local.z;
        (error * f64::from(UNIT_ROUNDOFF)).as_vec3().into()
    }
}

/// The row sums of the product of absolute values.
fn row_sums(columns: &[DVec3; 3], rows: &[DVec3; 3]) -> [f32; 3] {
    let sums = rows.map(|row| row.abs().element_sum());
    let all = columns[0].abs() * sums[0] + columns[1].abs() * sums[1] + columns[2].abs() * sums[2];
    all.as_vec3().into()
}

impl DoubleInverse {
    /// Of a placement that is flat along one axis. Its image is moved into the plane that it hardly
    /// leaves; what the way back takes to zero there becomes the direction in which rays go through
    /// the object.
    fn flattened(world_from_object: &Affine) -> Option<Self> {
        let columns = world_from_object.columns();
        let may_vanish = world_from_object.inverse_rows().is_some();
        let columns =
            columns.map(|column| if may_vanish && column.length() < VANISHING { DVec3::ZERO } else { column });
        // The plane of the two columns that are the farthest from parallel, each taken at length
        // one, so that thin is not mistaken for flat.
        let units = columns.map(DVec3::normalize_or_zero);
        let pairs = [(1, 2), (2, 0), (0, 1)].map(|(a, b)| units[a].cross(units[b]));
        let normal = pairs.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
        let has_area = normal.length() > super::affine::FLAT;
        let is_solid = may_vanish && columns.iter().all(|column| *column != DVec3::ZERO);
        if !has_area || is_solid {
            return None;
        }
        let normal = normal.normalize();
        let right = normal.any_orthonormal_vector();
        let up = normal.cross(right);
        // The two coordinates in the plane, as rows over the object.
        let row = |axis: DVec3| DVec3::from_array(columns.map(|column| column.dot(axis)));
        let (x, y) = (row(right), row(up));
        let cross = x.cross(y);
        let along = cross.normalize();
        let (back_x, back_y) = (y.cross(along) / cross.length(), along.cross(x) / cross.length());
        let rows = [0, 1, 2].map(|axis| right * back_x[axis] + up * back_y[axis] + normal * along[axis]);
        let center = wide(world_from_object.translation);
        let flat = columns.map(|column| (column - normal * column.dot(normal)).as_vec3().to_array());
        let flat = Affine::from_columns(flat[0], flat[1], flat[2], world_from_object.translation);
        let is_finite = rows.iter().all(|row| row.is_finite()) && Affine::rounded(&rows, center).is_some();
        is_finite.then_some(Self {
            rows,
            center,
            world_from_object: flat,
            flat: Some(Flat { normal, along: along * world_from_object.handedness() }),
        })
    }

    /// In roundings, metres along each axis, object space. The ray is rounded within the bounds,
    /// and errs as the triangle test does along what it crosses of them.
    fn local_error(&self, bounds: &Aabb) -> DVec3 {
        let crossed = match &self.flat {
            Some(flat) => flat.along.abs() * (2.0 * depth(bounds, flat.along)),
            None => wide(bounds.extent()),
        };
        (farthest(bounds) + crossed * 2.0) * 16.0
    }

    /// The ray in the space of the object, starting where it comes to the bounds of the mesh.
    /// `None` when it does not, within its own bounds.
    pub(crate) fn enter(&self, ray: &Ray, bounds: &Aabb) -> Option<LocalRay> {
        if bounds.is_empty() {
            return None;
        }
        let (origin, direction) = (wide(ray.origin) - self.center, wide(ray.direction));
        match &self.flat {
            Some(flat) => self.cross(flat, ray, origin, direction, bounds),
            None => self.approach(ray, self.turned(origin), self.turned(direction), bounds),
        }
    }

    fn turned(&self, v: DVec3) -> DVec3 {
        DVec3::from_array(self.rows.map(|row| row.dot(v)))
    }

    /// All of a flat object is met at once, where the ray meets the plane; what lies there is found
    /// by tracing the object along the direction that was flattened.
    fn cross(&self, flat: &Flat, ray: &Ray, origin: DVec3, direction: DVec3, bounds: &Aabb) -> Option<LocalRay> {
        let step = flat.normal.dot(direction);
        let t = -flat.normal.dot(origin) / step;
        let rounded = t as f32 + 0.0;
        if !rounded.is_finite() || rounded < ray.t_min || ray.t_max < rounded {
            return None;
        }
        let along = flat.along * step.signum();
        let (point, middle) = (self.turned(origin + direction * t), wide(bounds.center()));
        let depth = depth(bounds, along);
        let margin = (depth + wide(bounds.extent()).max_element()) * 1e-3 + farthest(bounds).max_element() * 1e-6;
        let start = point + along * (along.dot(middle - point) - depth - margin);
        let ray = Ray::new(start.as_vec3().into(), along.as_vec3().into()).validated()?;
        Some(LocalRay { ray, start: t, rate: 0.0 })
    }

    /// To where the ray comes to the bounds.
    fn approach(&self, ray: &Ray, origin: DVec3, direction: DVec3, bounds: &Aabb) -> Option<LocalRay> {
        let (t_min, t_max) = (f64::from(ray.t_min), f64::from(ray.t_max));
        let (mut entry, mut exit) = (t_min, t_max);
        // Roundings of the ray and of the triangle test, twice.
        let padding = (farthest(bounds) + wide(bounds.extent())) * (32.0 * f64::from(UNIT_ROUNDOFF));
        let (low, high) = (wide(bounds.min) - padding - origin, wide(bounds.max) + padding - origin);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if low[axis] > 0.0 || high[axis] < 0.0 {
                    return None;
                }
                continue;
            }
            let (one, other) = (low[axis] / direction[axis], high[axis] / direction[axis]);
            entry = entry.max(one.min(other));
            exit = exit.min(one.max(other));
        }
        if exit < entry {
            return None;
        }
        let at = origin + direction * entry;
        let ray = Ray::new(at.as_vec3().into(), direction.as_vec3().into()).validated()?;
        Some(LocalRay { ray, start: entry, rate: 1.0 })
    }
}

/// Half of what lies between the first and the last point of a box along a direction.
fn depth(bounds: &Aabb, along: DVec3) -> f64 {
    along.abs().dot(wide(bounds.extent())) * 0.5
}

/// The largest coordinates of a box.
fn farthest(bounds: &Aabb) -> DVec3 {
    wide(bounds.min).abs().max(wide(bounds.max).abs())
}

impl LocalRay {
    /// Converts a distance along this ray to one along the world ray.
    pub(crate) fn in_world(&self, t: f32) -> f32 {
        (self.start + self.rate * f64::from(t)) as f32 + 0.0
    }

    /// A distance along this ray that is not before any point whose world distance is at most
    /// `t_max`.
    pub(crate) fn beyond(&self, t_max: f32) -> f32 {
        if self.rate == 0.0 {
            return f32::INFINITY;
        }
        // The distance in the world rounds to nearest; the share is that of more than one rounding
        // of it.
        let t = f64::from(t_max) * (1.0 + 2.0 * f64::from(f32::EPSILON)) - self.start;
        (t.max(0.0) * (1.0 + f64::from(f32::EPSILON))) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skew(map: &Affine) -> f32 {
        let rows = map.inverse_rows().unwrap();
        row_sums(&map.columns(), &rows).into_iter().fold(0.0, f32::max)
    }

    #[test]
    fn only_skew_makes_a_placement_hard() {
        let turned = Affine::from_axis_angle([1.0, 2.0, -3.0], 1.1);
        for scale in [[1.0; 3], [1.0, 1e-6, 1.0], [1e-9, 1e6, 1.0]] {
            assert!(skew(&(turned * Affine::from_scale(scale))) <= 3.0001, "{scale:?}");
            let thin = turned * Affine::from_scale(scale);
            assert!(matches!(Inverse::of(&thin), Some(Inverse::Single { .. })));
        }
        let skewed = Affine::from_scale([1.0, 1e-3, 1.0]) * turned;
        assert!(skew(&skewed) > 100.0);
        assert!(matches!(Inverse::of(&skewed), Some(Inverse::Double(double)) if double.flat.is_none()));
    }

    #[test]
    fn what_is_flat_along_one_axis_has_a_way_back_and_what_is_flatter_has_none() {
        let turned = Affine::from_axis_angle([1.0, 2.0, -3.0], 1.1);
        let is_flat = |map: Affine| match Inverse::of(&map) {
            Some(Inverse::Double(double)) => double.flat.is_some(),
            _ => false,
        };
        for map in [
            Affine::from_scale([1.0, 0.0, 1.0]),
            turned * Affine::from_scale([5.0, 5.0, 0.0]),
            Affine::from_scale([5.0, 5.0, 0.0]) * turned,
            Affine::from_scale([1e-20, 0.0, 1e10]),
            Affine::from_scale([1.0, 1e-39, 1.0]),
            Affine { y_axis: [1.0, 1e-9, 0.0], ..Affine::IDENTITY },
        ] {
            assert!(is_flat(map), "{map:?}");
        }
        for scale in [[0.0; 3], [1.0, 0.0, 0.0], [1e-39; 3], [1e-39, 1.0, 1e-39]] {
            assert!(Inverse::of(&(turned * Affine::from_scale(scale))).is_none(), "{scale:?}");
        }
        let line = Affine { y_axis: [1.0, 1e-9, 0.0], z_axis: [2.0, 0.0, 0.0], ..Affine::IDENTITY };
        assert!(Inverse::of(&line).is_none());
    }
}
