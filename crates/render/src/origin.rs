//! Where rays start so that they do not hit the surface they leave.
//!
//! The place of a hit is known up to rounding. The bound on that error follows the numbers the place was computed from, so
//! that it is a millionth of a millimetre on a thimble at the origin and half a millimetre a kilometre away, and rays start
//! just beyond it, along the geometric normal.
//!
//! Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition 2023, section 6.8 (error bounds); Waechter and
//! Binder 2019, "A Fast and Robust Method for Avoiding Self-Intersection" (offsets along the geometric normal).

use glam::Vec3;
use kinetree::Affine;

/// How many roundings of the largest terms the bound allows for. Interpolating and placing a point costs about five, and
/// the next ray meets the same triangle with an origin that has been taken to object space and back: about as many again.
const ROUNDINGS: f32 = 8.0;

/// How far above a surface rays start, metres, where a transform has placed a point of the object whose coordinates were
/// summed from terms of the given absolute size.
///
/// The largest axis counts for all. A floor that lies exactly at height zero has no error in its height, but the distance
/// at which a grazing ray meets it is summed from its width, and errs accordingly.
pub(crate) fn lift(world_from_object: &Affine, terms: Vec3) -> f32 {
    let [x, y, z, moved] =
        [world_from_object.x_axis, world_from_object.y_axis, world_from_object.z_axis, world_from_object.translation]
            .map(|column| Vec3::from(column).abs());
    let size = (x * terms.x + y * terms.y + z * terms.z + moved).max_element();
    size * (ROUNDINGS * f32::EPSILON * 0.5)
}

/// A position moved along a unit normal by a distance, rounded away from where it was.
pub(crate) fn lifted(position: Vec3, normal: Vec3, distance: f32) -> Vec3 {
    let moved = position + normal * distance;
    Vec3::from_array(std::array::from_fn(|axis| {
        let rounded = moved[axis];
        if normal[axis] > 0.0 {
            rounded.next_up()
        } else if normal[axis] < 0.0 {
            rounded.next_down()
        } else {
            rounded
        }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_offset_follows_the_size_of_the_numbers() {
        let near = lift(&Affine::IDENTITY, Vec3::splat(1e-3));
        assert!(near < 1e-8, "{near}");
        let far = lift(&Affine::from_translation([1000.0, 0.0, 1000.0]), Vec3::ONE);
        assert!((1e-4..2e-3).contains(&far), "{far}");
        // Large numbers that cancel have left their error behind.
        let cancelled = lift(&Affine::from_translation([0.0, -1000.0, 0.0]), Vec3::new(0.0, 1000.0, 0.0));
        assert!(cancelled > 5e-4, "{cancelled}");
    }

    #[test]
    fn a_lifted_position_has_left_its_plane() {
        let position = Vec3::new(0.0, 1e6, 0.0);
        assert!(lifted(position, Vec3::Y, 1e-9).y > 1e6);
        assert!(lifted(position, Vec3::NEG_Y, 1e-9).y < 1e6);
    }
}
