//! Refitting a chunk: blocks from vertices, then boxes from the leaves up.
//!
//! Blocks are written in order, and the box of each is computed while the corners are in registers.
//! Then nodes are refitted from the last to the first, because children come after their parents.
//! The boxes of blocks and nodes are kept in a table, as points; those of a node's children are
//! transposed to the rows of the node. Nodes are only written; only their links are read.

use super::super::node::LANES;
use super::super::{TriangleBlock, WideLink, WideNode};
use super::ChunkBounds;
use super::plan::Corners;
use crate::geometry::Aabb;
use crate::simd::{Isa, Kernel};
use crate::wide::costs::Costs;

/// The prefetch distances. Measured: from 8 to 32 blocks there is no difference; without
/// prefetching, refits of 0.3, 0.6 and 4.5 million triangles take 12, 30 and 41 % longer.
const BLOCKS_AHEAD: usize = 16;
const NODES_AHEAD: usize = 8;

// The sum of costs below assumes equal costs of a node and a block.
const _: () = assert!(Costs::TRIANGLES.node.to_bits() == Costs::TRIANGLES.item.to_bits());

/// A lower and an upper corner; the fourth lanes are unused.
type TwoCorners = [[f32; 4]; 2];

pub(super) struct Sweep<'a> {
    pub(super) nodes: &'a mut [WideNode],
    pub(super) blocks: &'a mut [TriangleBlock],
    /// The indices of the first node and the first block in the tree.
    pub(super) first_node: usize,
    pub(super) first_block: usize,
    /// One for each block.
    pub(super) corners: &'a [Corners],
    pub(super) positions: &'a [[f32; 3]],
}

impl Kernel for Sweep<'_> {
    type Output = ChunkBounds;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> ChunkBounds {
        let (block_count, node_count) = (self.blocks.len(), self.nodes.len());
        // Blocks first, then nodes from the last to the first.
        let mut boxes: Vec<TwoCorners> = Vec::with_capacity(block_count + node_count);
        let mut triangle_boxes = isa.splat(0.0);
        for at in 0..block_count {
            isa.prefetch(self.blocks, at + BLOCKS_AHEAD);
            if let Some(ahead) = self.corners.get(at + BLOCKS_AHEAD) {
                for vertex in ahead.as_flattened() {
                    isa.prefetch(self.positions, *vertex as usize);
                }
            }
            let moved = move_block(isa, &mut self.blocks[at], &self.corners[at], self.positions);
            boxes.push(moved.bounds);
            triangle_boxes = isa.add(triangle_boxes, moved.triangle_boxes);
        }
        let empty = (isa.splat(f32::INFINITY), isa.splat(f32::NEG_INFINITY));
        let zero = isa.splat(0.0);
        let mut cost = zero;
        for at in (0..node_count).rev() {
            isa.prefetch(self.nodes, at.wrapping_sub(NODES_AHEAD));
            let node = &mut self.nodes[at];
            let (mut lower, mut upper) = ([empty.0; LANES], [empty.1; LANES]);
            let (mut lower_corner, mut upper_corner) = empty;
            for lane in 0..node.in_use.count_ones() as usize & (2 * LANES - 1) {
                let link = WideLink::from_bits(node.links[lane & (LANES - 1)]);
                let first = if link.is_leaf() {
                    link.item_index().wrapping_sub(self.first_block)
                } else {
                    (block_count + node_count - 1 + self.first_node).wrapping_sub(link.node_index())
                };
                let (mut min, mut max) = (isa.load(&boxes[first][0]), isa.load(&boxes[first][1]));
                // The item count of a link to a node is one.
                for item in 1..link.item_count() {
                    min = isa.min(min, isa.load(&boxes[first + item][0]));
                    max = isa.max(max, isa.load(&boxes[first + item][1]));
                }
                (lower[lane & (LANES - 1)], upper[lane & (LANES - 1)]) = (min, max);
                (lower_corner, upper_corner) = (isa.min(lower_corner, min), isa.max(upper_corner, max));
            }
            boxes.push([isa.store(lower_corner), isa.store(upper_corner)]);
            let (lower, upper) = (isa.transpose_xyz(&lower), isa.transpose_xyz(&upper));
            let mut extent = [zero; 3];
            for axis in 0..3 {
                node.planes[axis] = [isa.store(lower[axis]), isa.store(upper[axis])];
                extent[axis] = isa.max(isa.sub(upper[axis], lower[axis]), zero);
            }
            let [x, y, z] = extent;
            let area = isa.add(isa.add(isa.mul(x, y), isa.mul(y, z)), isa.mul(z, x));
            let visits = isa.add(isa.extract_bits::<{ WideLink::COUNT_SHIFT as i32 }, 7>(&node.links), isa.splat(1.0));
            cost = isa.add(cost, isa.mul(area, visits));
        }
        let mut sum = 0.0;
        for area in isa.store(cost) {
            sum += f64::from(area) * f64::from(Costs::TRIANGLES.item);
        }
        let [min, max] = boxes[boxes.len() - 1];
        ChunkBounds {
            bounds: Aabb::new([min[0], min[1], min[2]], [max[0], max[1], max[2]]),
            cost: sum,
            triangle_boxes: isa.store(triangle_boxes).map(f64::from).iter().sum(),
        }
    }
}

/// The results of writing a block.
struct Moved<F4> {
    /// The same box as [`TriangleBlock::bounds`] returns.
    bounds: TwoCorners,
    /// The half areas of the boxes of its triangles, without padding; zero in unused lanes.
    triangle_boxes: F4,
}

/// Writes the corners of a block.
#[inline(always)]
fn move_block<I: Isa>(isa: I, block: &mut TriangleBlock, corners: &Corners, positions: &[[f32; 3]]) -> Moved<I::F4> {
    let zero = isa.splat(0.0);
    let mut rows = [[zero; 3]; 3];
    for corner in 0..3 {
        let [a, b, c, d] = corners[corner];
        let [a, b, c, d] = [
            isa.load3(&positions[a as usize]),
            isa.load3(&positions[b as usize]),
            isa.load3(&positions[c as usize]),
            isa.load3(&positions[d as usize]),
        ];
        let [x, y, z, _] = isa.transpose([a, b, c, d]);
        rows[corner] = [x, y, z];
    }
    let [min, max] = block.set_corners(isa, rows);
    let extent = [isa.sub(max[0], min[0]), isa.sub(max[1], min[1]), isa.sub(max[2], min[2])];
    let mut largest = zero;
    for axis in 0..3 {
        largest = isa.max(extent[axis], largest);
    }
    let [x, y, z] = extent;
    let areas = isa.add(isa.add(isa.mul(x, y), isa.mul(y, z)), isa.mul(z, x));
    let pad = isa.mul(largest, isa.splat(Aabb::PADDING));
    let [a, b, c, d] = isa.transpose([isa.sub(min[0], pad), isa.sub(min[1], pad), isa.sub(min[2], pad), zero]);
    let lower_corner = isa.min(isa.min(a, b), isa.min(c, d));
    let [a, b, c, d] = isa.transpose([isa.add(max[0], pad), isa.add(max[1], pad), isa.add(max[2], pad), zero]);
    let upper_corner = isa.max(isa.max(a, b), isa.max(c, d));
    Moved {
        bounds: [isa.store(lower_corner), isa.store(upper_corner)],
        triangle_boxes: isa.blend_prefix(block.count, areas, zero),
    }
}
