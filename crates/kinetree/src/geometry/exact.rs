//! The ray-triangle test without rounding errors, for the rays that single precision cannot decide.
//!
//! All decisions are signs of one form: the dot product of a vector with the normal of a triangle.
//! It is evaluated in double precision first. Where that leaves fewer than 26 correct bits, it is
//! summed again as an expansion: a list of doubles whose exact sum is the value.
//!
//! Shewchuk 1997, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
//! Predicates".

use super::{Ray, Triangle, TriangleHit};

/// Where the ray meets the triangle, if it does so within the bounds (inclusive). Edges and corners
/// belong to the triangle; a ray in its plane, and a triangle without area, meet nothing. The
/// distance and the weights are the exact ones, rounded to single precision.
///
/// The ray and the triangle are finite.
#[cold]
#[inline(never)]
pub(crate) fn hit(ray: &Ray, triangle: &Triangle, t_min: f32, t_max: f32) -> Option<TriangleHit> {
    let (origin, direction) = (ray.origin, ray.direction);
    let [a, b, c] = triangle.corners;
    let [ab, bc, ca] = [minus(b, a), minus(c, b), minus(a, c)];
    let step = direction.map(f64::from);
    let exactly = |from, to| {
        let mut sum = Expansion::default();
        sum.add_along_normal(direction, [from, to, origin], 1.0);
        sum.value()
    };
    // Seen from the origin, `direction · (from × to)`, which is `direction · (from × edge)`.
    let u = -along_normal(step, minus(b, origin), bc).unwrap_or_else(|| exactly(b, c));
    let v = -along_normal(step, minus(c, origin), ca).unwrap_or_else(|| exactly(c, a));
    let w = -along_normal(step, minus(a, origin), ab).unwrap_or_else(|| exactly(a, b));
    let back = u < 0.0 || v < 0.0 || w < 0.0;
    let front = u > 0.0 || v > 0.0 || w > 0.0;
    if front == back {
        return None;
    }
    // No cancellation: none of the three has the other sign.
    let determinant = u + v + w;
    let height = along_normal(minus(a, origin), ca, ab).unwrap_or_else(|| {
        let mut sum = Expansion::default();
        sum.add_along_normal(a, [a, b, c], 1.0);
        sum.add_along_normal(origin, [a, b, c], -1.0);
        sum.value()
    });
    // The error is below half a rounding, so a distance that lies within the bounds exactly lies
    // within them when it is rounded. Adding zero turns a negative zero into a positive one.
    let t = (-height / determinant) as f32 + 0.0;
    let u = ((v / determinant) as f32).clamp(0.0, 1.0);
    let v = ((w / determinant) as f32).clamp(0.0, 1.0 - u);
    (t_min <= t && t <= t_max && t.is_finite()).then_some(TriangleHit { t, u, v, back })
}

/// Rounded, by 2^-53 at most.
#[inline(always)]
fn minus(a: [f32; 3], b: [f32; 3]) -> [f64; 3] {
    [f64::from(a[0]) - f64::from(b[0]), f64::from(a[1]) - f64::from(b[1]), f64::from(a[2]) - f64::from(b[2])]
}

/// `x · (p × q)` of vectors with an error of a rounding, where its error is below 2^-26 of itself.
#[inline(always)]
fn along_normal(x: [f64; 3], p: [f64; 3], q: [f64; 3]) -> Option<f64> {
    let value =
        x[0] * (p[1] * q[2] - p[2] * q[1]) + x[1] * (p[2] * q[0] - p[0] * q[2]) + x[2] * (p[0] * q[1] - p[1] * q[0]);
    let sum = |v: [f64; 3]| v[0].abs() + v[1].abs() + v[2].abs();
    // Each of the six terms is at most this, all together at most twice this, and nine roundings
    // lead from the exact vectors to any of them: the error is below 20 * 2^-53 of this.
    let magnitude = sum(x) * sum(p) * sum(q);
    (value.abs() >= magnitude * LEAST_SHARE).then_some(value)
}

/// 2^-22.
const LEAST_SHARE: f64 = 1.0 / (1_u64 << 22) as f64;

/// The most numbers that are ever added: two for each of eighteen products, twice.
const MOST_PARTS: usize = 72;

/// A number as the exact sum of doubles that do not overlap, the smallest first.
struct Expansion {
    parts: [f64; MOST_PARTS],
    count: usize,
}

impl Default for Expansion {
    fn default() -> Self {
        Self { parts: [0.0; MOST_PARTS], count: 0 }
    }
}

impl Expansion {
    /// Adds `sign * x · (p × q + q × r + r × p)`.
    fn add_along_normal(&mut self, x: [f32; 3], [p, q, r]: [[f32; 3]; 3], sign: f64) {
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            for (from, to) in [(p, q), (q, r), (r, p)] {
                self.add_product(sign * f64::from(x[axis]), from[next], to[last]);
                self.add_product(-sign * f64::from(x[axis]), from[last], to[next]);
            }
        }
    }

    /// The factors have 24 bits each, so the first product is exact, and the second one in two
    /// parts.
    fn add_product(&mut self, x: f64, y: f32, z: f32) {
        let yz = f64::from(y) * f64::from(z);
        let product = x * yz;
        self.add(x.mul_add(yz, -product));
        self.add(product);
    }

    /// Grow-Expansion of Shewchuk 1997, without the zeros.
    fn add(&mut self, x: f64) {
        let (mut total, mut kept) = (x, 0);
        for at in 0..self.count {
            let (sum, error) = two_sum(total, self.parts[at]);
            if error != 0.0 {
                self.parts[kept] = error;
                kept += 1;
            }
            total = sum;
        }
        if total != 0.0 {
            self.parts[kept] = total;
            kept += 1;
        }
        self.count = kept;
    }

    /// Right in sign, and but for a rounding: the last part outweighs all others.
    fn value(&self) -> f64 {
        self.parts[..self.count].iter().sum()
    }
}

/// The rounded sum, and what rounding took from it.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_expansion_keeps_what_double_precision_loses() {
        let mut sum = Expansion::default();
        for x in [1e200, 1.0, -1e200, 1e-200, -1.0] {
            sum.add(x);
        }
        assert_eq!(sum.value(), 1e-200);
        sum.add(-1e-200);
        assert_eq!((sum.value(), sum.count), (0.0, 0));
    }

    #[test]
    fn a_ray_in_the_plane_is_told_from_one_that_is_a_rounding_above_it() {
        // Corners of one plane in different sizes, so that no difference of theirs is a double.
        let triangle = Triangle { corners: [[3e-20, 1e10, 0.0], [1e10, 3e-20, 0.0], [-1e10, 7.0, 0.0]] };
        let meets = |origin, direction| hit(&Ray::new(origin, direction), &triangle, 0.0, f32::INFINITY);
        assert_eq!(meets([1e-30, 5.0, 0.0], [1.0, 1.0, 0.0]), None);
        assert_eq!(meets([1e-30, 5.0, 1e-45], [1.0, 1.0, 0.0]), None);
        let below = meets([1e-30, 50.0, -1e-45], [0.0, 0.0, 1.0]).unwrap();
        let above = meets([1e-30, 50.0, 1e-45], [0.0, 0.0, -1.0]).unwrap();
        assert!(below.t == 1e-45 && above.t == 1e-45 && below.back != above.back);
        assert_eq!(meets([1e-30, 50.0, 1e-45], [0.0, 0.0, 1.0]), None);
    }
}
