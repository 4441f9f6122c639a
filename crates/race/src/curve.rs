//! Monotone piecewise cubic interpolation: smooth curves through given values that never overshoot
//! them.
//!
//! Fritsch and Butland 1984, "A Method for Constructing Local Monotone Piecewise Cubic
//! Interpolants": tangents are harmonic means of the neighbouring slopes, and zero at a turn.

/// The value at `x` of the curve through `knots`, given as (x, value) with ascending x; level
/// beyond both ends.
pub(crate) fn curve(knots: &[(f32, f32)], x: f32) -> f32 {
    let after = knots.partition_point(|knot| knot.0 <= x);
    let (Some(low), Some(high)) = (after.checked_sub(1), (after < knots.len()).then_some(after)) else {
        let end = if after == 0 { knots.first() } else { knots.last() };
        return end.map_or(0.0, |knot| knot.1);
    };
    let slope = |i: usize| (knots[i + 1].1 - knots[i].1) / (knots[i + 1].0 - knots[i].0);
    let tangent = |i: usize| {
        if i == 0 {
            return slope(0);
        }
        if i + 1 == knots.len() {
            return slope(i - 1);
        }
        let (a, b) = (slope(i - 1), slope(i));
        if a * b <= 0.0 { 0.0 } else { 2.0 * a * b / (a + b) }
    };
    let width = knots[high].0 - knots[low].0;
    let t = (x - knots[low].0) / width;
    let (t2, t3) = (t * t, t * t * t);
    knots[low].1 * (2.0 * t3 - 3.0 * t2 + 1.0)
        + tangent(low) * width * (t3 - 2.0 * t2 + t)
        + knots[high].1 * (3.0 * t2 - 2.0 * t3)
        + tangent(high) * width * (t3 - t2)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOTS: [(f32, f32); 4] = [(0.0, 1.0), (1.0, 3.0), (2.0, 3.5), (4.0, 0.5)];

    #[test]
    fn it_meets_its_knots_and_is_level_beyond() {
        for (x, value) in KNOTS {
            assert!((curve(&KNOTS, x) - value).abs() < 1e-6);
        }
        assert!((curve(&KNOTS, -5.0) - 1.0).abs() < 1e-6);
        assert!((curve(&KNOTS, 9.0) - 0.5).abs() < 1e-6);
        assert!(curve(&[], 1.0).abs() < 1e-6);
    }

    #[test]
    fn it_never_overshoots() {
        for i in 0..=400 {
            let value = curve(&KNOTS, i as f32 / 100.0);
            assert!((0.5..=3.5).contains(&value), "{value}");
        }
    }
}
