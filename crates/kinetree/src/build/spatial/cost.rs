//! What it costs to test a set of triangles.

/// Triangles are tested four at a time: see [`TriangleBlock`](crate::wide::TriangleBlock).
const AT_ONCE: u32 = 4;

/// In units of one triangle: a block that is not full costs as much as a full one. So cuts leave full blocks, which saves a tenth of the memory and costs
/// nothing in the blocks that a ray tests.
#[inline(always)]
pub(super) fn tests(count: u32) -> f32 {
    (count.div_ceil(AT_ONCE) * AT_ONCE) as f32
}
