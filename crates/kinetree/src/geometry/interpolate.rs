//! Interpolating values over a triangle.

/// A value that can be given per vertex and weighted: a number, a texture coordinate, a colour, a
/// normal.
pub trait Interpolate: Copy {
    /// The weighted sum of the values at the three corners. The weights sum to one.
    fn weighted(corners: [Self; 3], weights: [f32; 3]) -> Self;
}

impl Interpolate for f32 {
    fn weighted([a, b, c]: [Self; 3], [wa, wb, wc]: [f32; 3]) -> Self {
        a * wa + b * wb + c * wc
    }
}

impl<const N: usize> Interpolate for [f32; N] {
    fn weighted([a, b, c]: [Self; 3], weights: [f32; 3]) -> Self {
        std::array::from_fn(|i| f32::weighted([a[i], b[i], c[i]], weights))
    }
}
