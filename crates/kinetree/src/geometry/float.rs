//! Minimum and maximum of floats in one instruction each.
//!
//! `f32::min` and `f32::max` return the other operand if one is NaN, which takes further
//! instructions. These return the second operand, as the instructions of processors do.

/// The smaller of two numbers; `b` if they are equal, or if either is NaN.
#[inline(always)]
pub(crate) fn fast_min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers; `b` if they are equal, or if either is NaN.
#[inline(always)]
pub(crate) fn fast_max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
