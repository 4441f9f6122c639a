//! Fresnel's reflectance of a smooth boundary between two dielectrics, exact, for unpolarised
//! light.

/// Reflectances for light polarised perpendicular and parallel to the plane of incidence.
///
/// `cosine` is that of the angle of incidence, in 0..=1; `eta` the index of refraction beyond the
/// boundary over that on the side of incidence. Both are 1 under total internal reflection.
fn polarised(cosine: f32, eta: f32) -> [f32; 2] {
    let cosine = cosine.clamp(0.0, 1.0);
    let Some(beyond) = refracted_cosine(cosine, eta) else { return [1.0; 2] };
    let perpendicular = (cosine - eta * beyond) / (cosine + eta * beyond);
    let parallel = (eta * cosine - beyond) / (eta * cosine + beyond);
    // At grazing incidence and `eta` 1 both sums may vanish; such light is reflected.
    [perpendicular, parallel]
        .map(|amplitude| if amplitude.is_finite() { (amplitude * amplitude).min(1.0) } else { 1.0 })
}

/// Cosine of the angle of refraction by Snell's law; `None` under total internal
/// reflection.
pub(super) fn refracted_cosine(cosine: f32, eta: f32) -> Option<f32> {
    let sine_squared = (1.0 - cosine * cosine).max(0.0) / (eta * eta);
    (sine_squared < 1.0).then(|| (1.0 - sine_squared).sqrt())
}

/// Reflectance of a single boundary.
pub(super) fn reflectance(cosine: f32, eta: f32) -> f32 {
    let [perpendicular, parallel] = polarised(cosine, eta);
    0.5 * (perpendicular + parallel)
}

/// Reflectance of a slab with two parallel boundaries, summed over all internal reflections: for
/// each polarisation `r + (1 - r)^2 r + (1 - r)^2 r^3 + ... = 2 r / (1 + r)`. `ior` is the index of
/// refraction of the slab over that around it.
pub(super) fn slab_reflectance(cosine: f32, ior: f32) -> f32 {
    let [perpendicular, parallel] = polarised(cosine, ior).map(|r| 2.0 * r / (1.0 + r));
    0.5 * (perpendicular + parallel)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_incidence_has_the_textbook_value() {
        assert!((reflectance(1.0, 1.5) - 0.04).abs() < 1e-6);
        assert!((reflectance(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-6);
        assert!((slab_reflectance(1.0, 1.5) - 0.08 / 1.04).abs() < 1e-6);
        assert!((reflectance(0.0, 1.5) - 1.0).abs() < 1e-6);
        assert!(reflectance(0.7, 1.0) < 1e-12);
    }

    #[test]
    fn no_parallel_light_is_reflected_at_brewsters_angle() {
        let angle = 1.5_f32.atan();
        let [perpendicular, parallel] = polarised(angle.cos(), 1.5);
        assert!(parallel < 1e-12);
        // There the angles of incidence and refraction make a right angle: r = cos(2 angle)^2.
        assert!((perpendicular - (2.0 * angle).cos().powi(2)).abs() < 1e-6);
    }

    #[test]
    fn from_the_dense_side_all_light_is_reflected_beyond_the_critical_angle() {
        let critical = (1.0_f32 - 1.0 / (1.5 * 1.5)).sqrt();
        assert!((reflectance(critical - 1e-3, 1.0 / 1.5) - 1.0).abs() < 1e-9);
        assert!(reflectance(critical + 1e-2, 1.0 / 1.5) < 0.9);
    }

    #[test]
    fn both_sides_of_a_boundary_reflect_the_same() {
        for cosine in [0.1, 0.3, 0.6, 0.9] {
            let beyond = refracted_cosine(cosine, 1.5).expect("no total reflection from the thin side");
            assert!((reflectance(cosine, 1.5) - reflectance(beyond, 1.0 / 1.5)).abs() < 1e-5);
        }
    }

    #[test]
    fn awkward_numbers_give_a_fraction() {
        for eta in [0.01, 1.0, 100.0] {
            for cosine in [0.0, f32::MIN_POSITIVE, 1.0, 1.0 + f32::EPSILON] {
                assert!(
                    (0.0..=1.0).contains(&reflectance(cosine, eta))
                        && (0.0..=1.0).contains(&slab_reflectance(cosine, eta))
                );
            }
        }
    }
}
