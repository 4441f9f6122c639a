//! The cost of testing a set of triangles.

/// Triangles are tested four at a time: see [`TriangleBlock`](crate::wide::TriangleBlock).
const AT_ONCE: u32 = 4;

/// The cost relative to one triangle: a partly filled block costs as much as a full one. So splits
/// prefer full blocks, which saves a tenth of the memory at the same number of block tests per ray.
#[inline(always)]
pub(super) fn tests(count: u32) -> f32 {
    (count.div_ceil(AT_ONCE) * AT_ONCE) as f32
}
