//! The nearest hit by brute force: the slow twin of every tree.

use rayon::prelude::*;

use super::crossing::hit;
use crate::ray::{Answer, Ray};
use crate::soup::Soup;

/// The nearest hit of each ray, found by testing every triangle. Both sides and all edges count;
/// whether there is a hit is exact.
pub(crate) fn closest_by_brute_force(soup: &Soup, rays: &[Ray]) -> Vec<Answer> {
    rays.par_iter().map(|ray| closest_of_all(soup, ray)).collect()
}

fn closest_of_all(soup: &Soup, ray: &Ray) -> Answer {
    let (mut best, mut nearest) = (Answer::MISS, f64::from(ray.t_max));
    for primitive in 0..soup.len() as u32 {
        let Some(t) = hit(ray, &soup.corners(primitive)) else { continue };
        if t <= nearest && (t < nearest || !best.is_hit()) {
            nearest = t;
            best = Answer { t: t as f32, u: 0.0, v: 0.0, primitive, mesh: 0 };
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_nearest_of_several_is_found_and_ends_count() {
        let mut soup = Soup::default();
        for z in [2.0, 1.0, 1.0, 3.0] {
            soup.add([Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| p + Vec3::Z * z), &[[0, 1, 2]]);
        }
        let ray = Ray::new(Vec3::new(0.25, 0.25, 0.0), Vec3::Z);
        let ends = |t_max| Ray { t_max, ..ray };
        let rays = [ray, ends(1.0), ends(0.99), Ray::new(Vec3::new(-1e-9, 0.25, 0.0), Vec3::Z)];
        let found: Vec<(u32, f32)> =
            closest_by_brute_force(&soup, &rays).iter().map(|answer| (answer.primitive, answer.t)).collect();
        let miss = (Answer::NOTHING, f32::INFINITY);
        assert_eq!(found, [(1, 1.0), (1, 1.0), miss, miss]);
    }
}
