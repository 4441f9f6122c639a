//! Boxes, rays, triangles and placements; no tree in sight.
//!
//! Points and vectors are `[f32; 3]` on the outside, so that no user is tied to a math crate.

mod aabb;
mod affine;
pub(crate) mod clip;
mod conversions;
pub(crate) mod exact;
mod float;
mod interpolate;
pub(crate) mod inverse;
mod precision;
mod ray;
pub(crate) mod slab;
mod triangle;
mod triangles;
pub(crate) mod watertight;

pub use aabb::Aabb;
pub use affine::Affine;
pub(crate) use clip::clipped_bounds;
pub(crate) use float::{fast_max, fast_min};
pub use interpolate::Interpolate;
pub use precision::Precision;
pub(crate) use precision::{AT_LEAST, AT_MOST, DISTANCE_ERROR};
pub use ray::Ray;
pub(crate) use slab::SafeRay;
pub use triangle::Triangle;
pub use triangles::Triangles;
pub(crate) use triangles::fingerprint;
pub use watertight::TriangleHit;
#[doc(hidden)]
pub use watertight::WatertightRay;
pub(crate) use watertight::{Edges, LaneHits, OTHERS, REACH};

/// The unit roundoff of `f32`: a correctly rounded operation errs by at most this, relatively.
pub(crate) const UNIT_ROUNDOFF: f32 = f32::EPSILON * 0.5;

/// Whether all three are numbers, and finite.
pub(crate) fn is_finite(v: [f32; 3]) -> bool {
    v.iter().all(|x| x.is_finite())
}
