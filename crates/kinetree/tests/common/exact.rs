//! A judge of ray-triangle tests that shares no code with the library: integers of any length.

use num_bigint::{BigInt, Sign};

use kinetree::Ray;

/// Where a ray meets a triangle: the distance, as a fraction of whole numbers.
pub struct Crossing {
    numerator: BigInt,
    denominator: BigInt,
}

impl Crossing {
    /// The distance, rounded.
    pub fn t(&self) -> f64 {
        let shift = 80 + self.denominator.bits().saturating_sub(self.numerator.bits());
        let quotient: BigInt = (&self.numerator << shift) / &self.denominator;
        // More than 64 bits: what is cut off does not matter to a double.
        let cut = quotient.bits().saturating_sub(64);
        let top = i128::try_from(quotient >> cut).expect("64 bits");
        top as f64 * 2.0_f64.powi(cut as i32 - shift as i32)
    }

    pub fn is_nearer(&self, other: &Self) -> bool {
        // Denominators are positive.
        &self.numerator * &other.denominator < &other.numerator * &self.denominator
    }
}

type Vector = [BigInt; 3];

/// Numbers as whole multiples of 2^-149, which all of them are.
fn whole(x: f32) -> BigInt {
    let bits = x.to_bits();
    let (exponent, fraction) = (bits >> 23 & 0xff, bits & 0x7f_ffff);
    let size =
        if exponent == 0 { BigInt::from(fraction) } else { BigInt::from(fraction | 0x80_0000) << (exponent - 1) };
    if bits >> 31 == 1 { -size } else { size }
}

fn vector(v: [f32; 3]) -> Vector {
    v.map(whole)
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

fn dot(a: &Vector, b: &Vector) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// Where the half-line from the ray's origin meets the closed triangle, if it does and does not run
/// in its plane.
pub fn crossing(ray: &Ray, triangle: [[f32; 3]; 3]) -> Option<Crossing> {
    let (origin, direction) = (vector(ray.origin), vector(ray.direction));
    let [a, b, c] = triangle.map(|corner| minus(&vector(corner), &origin));
    let sides = [(&b, &c), (&c, &a), (&a, &b)].map(|(from, to)| dot(&direction, &cross(from, to)));
    let (front, back) =
        (sides.iter().any(|side| side.sign() == Sign::Plus), sides.iter().any(|side| side.sign() == Sign::Minus));
    if front == back {
        return None;
    }
    let (numerator, denominator) = (dot(&a, &cross(&b, &c)), sides.iter().sum::<BigInt>());
    let (numerator, denominator) = if back { (-numerator, -denominator) } else { (numerator, denominator) };
    (numerator.sign() != Sign::Minus).then_some(Crossing { numerator, denominator })
}
