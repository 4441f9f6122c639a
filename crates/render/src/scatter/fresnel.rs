//! How much a smooth boundary between two dielectrics reflects: Fresnel's formulas, exact, for unpolarised light.

/// Reflected fractions for light polarised across and along the plane of incidence.
///
/// `cosine` is that of the angle of incidence, in 0..=1; `eta` the index of refraction beyond the boundary over that on the
/// side of incidence. Both are 1 under total reflection.
fn polarised(cosine: f32, eta: f32) -> [f32; 2] {
    let cosine = cosine.clamp(0.0, 1.0);
    let Some(beyond) = refracted_cosine(cosine, eta) else { return [1.0; 2] };
    let across = (cosine - eta * beyond) / (cosine + eta * beyond);
    let along = (eta * cosine - beyond) / (eta * cosine + beyond);
    // At grazing incidence with total transmission both sums may vanish; such light is reflected.
    [across, along].map(|amplitude| if amplitude.is_finite() { (amplitude * amplitude).min(1.0) } else { 1.0 })
}

/// Cosine of the angle of refraction by Snell's law; `None` under total reflection.
pub(super) fn refracted_cosine(cosine: f32, eta: f32) -> Option<f32> {
    let sine_squared = (1.0 - cosine * cosine).max(0.0) / (eta * eta);
    (sine_squared < 1.0).then(|| (1.0 - sine_squared).sqrt())
}

/// Reflected fraction of a single boundary.
pub(super) fn reflectance(cosine: f32, eta: f32) -> f32 {
    let [across, along] = polarised(cosine, eta);
    0.5 * (across + along)
}

/// Reflected fraction of a sheet with two parallel boundaries, summed over all reflections inside: for each polarisation
/// `r + (1 - r)^2 r + (1 - r)^2 r^3 + ... = 2 r / (1 + r)`. `ior` is that of the sheet over that around it.
pub(super) fn slab_reflectance(cosine: f32, ior: f32) -> f32 {
    let [across, along] = polarised(cosine, ior).map(|r| 2.0 * r / (1.0 + r));
    0.5 * (across + along)
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
    fn nothing_along_the_plane_is_reflected_at_brewsters_angle() {
        let angle = 1.5_f32.atan();
        let [across, along] = polarised(angle.cos(), 1.5);
        assert!(along < 1e-12);
        // There the angles of incidence and refraction make a right angle: r = cos(2 angle)^2.
        assert!((across - (2.0 * angle).cos().powi(2)).abs() < 1e-6);
    }

    #[test]
    fn from_the_dense_side_light_is_kept_beyond_the_critical_angle() {
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
