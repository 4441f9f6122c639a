//! Numbers that are never rounded: sums of floats that do not overlap.
//!
//! Shewchuk 1997, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
//! Predicates".
//!
//! Exact as long as nothing overflows or underflows: products of up to six differences of finite
//! `f32` do neither.

use std::cmp::Ordering;
use std::ops::{Add, Mul, Sub};

/// The sum of its components, which grow in magnitude and do not overlap; none of them is zero.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Expansion(Vec<f64>);

/// `a + b` as the rounded sum and its rounding error (Knuth 1969).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// `a * b` as the rounded product and its rounding error.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

impl Expansion {
    /// `a - b`.
    pub(crate) fn difference(a: f64, b: f64) -> Self {
        let (sum, rest) = two_sum(a, -b);
        Self([rest, sum].into_iter().filter(|part| *part != 0.0).collect())
    }

    /// The comparison with zero: the sign of the largest component.
    pub(crate) fn sign(&self) -> Ordering {
        self.0.last().map_or(Ordering::Equal, |most| most.total_cmp(&0.0))
    }

    /// Rounded, within two units of the last place.
    pub(crate) fn value(&self) -> f64 {
        self.0.iter().sum()
    }

    /// Adds one float; the components stay free of overlap.
    fn push(&mut self, more: f64) {
        let (mut rest, mut kept) = (more, 0);
        for at in 0..self.0.len() {
            let (sum, low) = two_sum(rest, self.0[at]);
            rest = sum;
            if low != 0.0 {
                self.0[kept] = low;
                kept += 1;
            }
        }
        self.0.truncate(kept);
        if rest != 0.0 {
            self.0.push(rest);
        }
    }
}

impl Add for &Expansion {
    type Output = Expansion;

    fn add(self, other: &Expansion) -> Expansion {
        let mut sum = self.clone();
        other.0.iter().for_each(|part| sum.push(*part));
        sum
    }
}

impl Sub for &Expansion {
    type Output = Expansion;

    fn sub(self, other: &Expansion) -> Expansion {
        let mut difference = self.clone();
        other.0.iter().for_each(|part| difference.push(-*part));
        difference
    }
}

impl Mul for &Expansion {
    type Output = Expansion;

    fn mul(self, other: &Expansion) -> Expansion {
        let mut product = Expansion::default();
        for a in &self.0 {
            for b in &other.0 {
                let (high, low) = two_product(*a, *b);
                product.push(low);
                product.push(high);
            }
        }
        product
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn number(parts: &[f64]) -> Expansion {
        let mut number = Expansion::default();
        parts.iter().for_each(|part| number.push(*part));
        number
    }

    #[test]
    fn rounding_errors_are_kept() {
        let big = number(&[1e30, 1.0]);
        assert_eq!((&big - &number(&[1e30])).value(), 1.0);
        assert_eq!((&big - &big).sign(), Ordering::Equal);
        let tiny = number(&[1.0, 1e-30]);
        let square = &tiny * &tiny;
        assert_eq!((&square - &number(&[1.0, 2e-30])).sign(), Ordering::Greater);
        assert_eq!((&number(&[1.0]) - &tiny).sign(), Ordering::Less);
        assert_eq!(Expansion::difference(1.0, 1e-30).value(), 1.0);
        assert_eq!((&Expansion::difference(1.0, 1e-30) - &number(&[1.0])).value(), -1e-30);
    }

    /// Compares with integer arithmetic.
    #[test]
    fn sums_and_products_are_those_of_whole_numbers() {
        for stream in 0..2000 {
            let mut rng = Rng::new(7, stream);
            let mut whole = || (rng.bits() as i64 >> (rng.bits() % 40)) as i128 >> 12;
            let [a, b, c, d] = [whole(), whole(), whole(), whole()];
            let float = |x: i128| Expansion::difference(x as f64, 0.0);
            let [x, y, z, w] = [a, b, c, d].map(float);
            let number = &(&(&x + &y) * &z) - &w;
            let expected = (a + b) * c - d;
            assert_eq!(number.sign(), expected.cmp(&0), "stream {stream}");
            let rest = number.0.iter().map(|part| *part as i128).sum::<i128>();
            assert_eq!(rest, expected, "stream {stream}: {a} {b} {c} {d}");
            assert!(number.0.windows(2).all(|pair| pair[0].abs() < pair[1].abs()));
        }
    }
}
