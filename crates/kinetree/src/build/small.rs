//! Building trees over a few triangles: a full sweep of the surface area heuristic.
//!
//! Games rebuild thousands of small meshes in a frame. For those, setting up the curve, the chunks
//! and the lists of the clustering builder takes longer than all merges. Here everything but the
//! tree itself is on the stack. Triangles are sorted once along each axis, and the three lists are
//! partitioned by each cut, so that choosing a cut is two passes over each list. The costliest leaf
//! is cut next, also if that gains nothing by itself, because later cuts may make up for it; the
//! collapse undoes the cuts that do not pay.
//!
//! The sorting is that of Wald and Havran 2006, "On building fast kd-Trees for Ray Tracing, and on
//! doing that in O(N log N)".

use std::ops::Range;

use super::fast_box::FastBox;
use crate::geometry::Triangles;
use crate::tree::{Bvh, Link, Node};
use crate::wide::{Costs, LANES};

/// The largest set of triangles that is built here: as many as fill the blocks of one wide node.
pub(super) const MAX_SMALL: usize = 32;

/// Sets of up to this many triangles are cut into at most as many leaves as a wide node has lanes.
/// From the cuts of larger sets down to single triangles, the collapse chooses leaves and nodes.
const MAX_ONE_NODE: usize = 2 * LANES;

/// Builds a tree over at most [`MAX_SMALL`] triangles. Those whose box is empty are left out.
///
/// # Panics
/// When there are more triangles.
pub(super) fn build_small(triangles: &Triangles) -> Bvh {
    assert!(triangles.len() <= MAX_SMALL, "{} triangles are not few", triangles.len());
    let mut lists = SortedLists::new();
    let mut bounds = FastBox::EMPTY;
    for triangle in 0..triangles.len() {
        let own = triangles.bounds_of(triangle as u32);
        if own.has_point() {
            let own = FastBox::from(&own);
            lists.insert(triangle, own);
            bounds = bounds.union(&own);
        }
    }
    let count = lists.count;
    if count == 0 {
        return Bvh::default();
    }
    let max_leaves = if count <= MAX_ONE_NODE { LANES.min(count) } else { count };
    let mut nodes = Vec::with_capacity(2 * max_leaves - 1);
    nodes.push(Node { bounds: bounds.into(), link: Link::UNUSED });
    let mut leaves = [Leaf::default(); MAX_SMALL];
    leaves[0] = Leaf::new(0, &bounds, 0..count, 0);
    let mut leaf_count = 1;
    while leaf_count < max_leaves {
        let Some(next) = costliest(&leaves[..leaf_count]) else { break };
        let leaf = leaves[next];
        let (axis, left) = lists.best_cut(&leaf);
        let middle = leaf.first + left;
        if left.max(leaf.count - left) > 2 {
            lists.partition(&leaf, axis, left);
        }
        nodes[leaf.node].link = Link::node(nodes.len() as u32);
        for (at, range) in [(next, leaf.first..middle), (leaf_count, middle..leaf.first + leaf.count)] {
            let bounds = lists.bounds_of(axis, range.clone());
            leaves[at] = Leaf::new(nodes.len(), &bounds, range, axis);
            nodes.push(Node { bounds: bounds.into(), link: Link::UNUSED });
        }
        leaf_count += 1;
    }
    let mut primitives = vec![0; count];
    for leaf in &leaves[..leaf_count] {
        let range = leaf.first..leaf.first + leaf.count;
        nodes[leaf.node].link = Link::primitives(range.start as u32..range.end as u32);
        let sorted = &lists.sorted[leaf.list][range.clone()];
        primitives[range].iter_mut().zip(sorted).for_each(|(to, from)| *to = (*from).into());
    }
    Bvh::from_parts(nodes, primitives, count as u32)
}

/// A leaf, which may yet be cut.
#[derive(Clone, Copy, Default)]
struct Leaf {
    /// The index of its node.
    node: usize,
    /// Its part of the sorted lists, which is also that of the tree's primitives.
    first: usize,
    count: usize,
    /// The axis of the list that it is in. Leaves of more than two triangles are in all lists.
    list: usize,
    /// The cost of its tests.
    cost: f32,
}

impl Leaf {
    fn new(node: usize, bounds: &FastBox, range: Range<usize>, list: usize) -> Self {
        let count = range.len();
        // `max` turns NaN, the area of some infinite boxes, to 0: every leaf has a place in the
        // order.
        let cost = (bounds.half_area() * BLOCKS[count % BLOCKS.len()]).max(0.0);
        Self { node, first: range.start, count, list, cost }
    }
}

/// The leaf of several triangles that costs most.
fn costliest(leaves: &[Leaf]) -> Option<usize> {
    let mut best = None;
    let mut best_cost = f32::NEG_INFINITY;
    for (at, leaf) in leaves.iter().enumerate() {
        if leaf.count > 1 && leaf.cost > best_cost {
            (best, best_cost) = (Some(at), leaf.cost);
        }
    }
    best
}

/// Triangles, sorted along each axis.
struct SortedLists {
    count: usize,
    /// By triangle.
    boxes: [FastBox; MAX_SMALL],
    /// Twice the centre of each box, by axis and triangle.
    doubled_centers: [[f32; MAX_SMALL]; 3],
    /// For each axis, the triangles of each leaf in the order of their centres.
    sorted: [[u8; MAX_SMALL]; 3],
}

impl SortedLists {
    fn new() -> Self {
        Self {
            count: 0,
            boxes: [FastBox::EMPTY; MAX_SMALL],
            doubled_centers: [[0.0; MAX_SMALL]; 3],
            sorted: [[0; MAX_SMALL]; 3],
        }
    }

    fn insert(&mut self, triangle: usize, bounds: FastBox) {
        self.boxes[triangle] = bounds;
        let centers = (bounds.min + bounds.max).to_array();
        for axis in 0..3 {
            let (centers_along, sorted) = (&mut self.doubled_centers[axis], &mut self.sorted[axis]);
            centers_along[triangle] = centers[axis];
            let mut at = self.count;
            // Triangles come in the order of their indices, so equal ones keep it.
            while at > 0 && centers[axis] < centers_along[usize::from(sorted[at - 1]) % MAX_SMALL] {
                sorted[at] = sorted[at - 1];
                at -= 1;
            }
            sorted[at] = triangle as u8;
        }
        self.count += 1;
    }

    #[inline(always)]
    fn bounds(&self, triangle: u8) -> &FastBox {
        &self.boxes[usize::from(triangle) % MAX_SMALL]
    }

    #[inline(always)]
    fn bounds_of(&self, axis: usize, range: Range<usize>) -> FastBox {
        self.sorted[axis][range].iter().fold(FastBox::EMPTY, |all, &triangle| all.union(self.bounds(triangle)))
    }

    /// The axis, and how many triangles of its list are on the left. If no cut has a finite cost,
    /// half of them are.
    fn best_cut(&self, leaf: &Leaf) -> (usize, usize) {
        let count = leaf.count;
        let mut best = (leaf.list, count / 2);
        if count == 2 {
            return best;
        }
        let mut best_cost = f32::INFINITY;
        let mut right_costs = [0.0; MAX_SMALL];
        for axis in 0..3 {
            let sorted = &self.sorted[axis][leaf.first..leaf.first + count];
            // The costs of either side never fall as it grows, so a pass ends at the first cut
            // where one side alone costs too much.
            let mut first_left = 1;
            let mut side = FastBox::EMPTY;
            for left in (1..count).rev() {
                side = side.union(self.bounds(sorted[left]));
                let cost = side.half_area() * BLOCKS[(count - left) % BLOCKS.len()];
                if cost >= best_cost {
                    first_left = left + 1;
                    break;
                }
                right_costs[left % MAX_SMALL] = cost;
            }
            let mut side = FastBox::EMPTY;
            for left in 1..count {
                side = side.union(self.bounds(sorted[left - 1]));
                if left < first_left {
                    continue;
                }
                let left_cost = side.half_area() * BLOCKS[left % BLOCKS.len()];
                if left_cost >= best_cost {
                    break;
                }
                let cost = left_cost + right_costs[left % MAX_SMALL];
                if cost < best_cost {
                    (best, best_cost) = ((axis, left), cost);
                }
            }
        }
        best
    }

    /// Divides the lists of the other axes like that of `axis`, keeping the order on each side.
    fn partition(&mut self, leaf: &Leaf, axis: usize, left: usize) {
        let range = leaf.first..leaf.first + leaf.count;
        let mut is_right = !0_u32;
        for &triangle in &self.sorted[axis][leaf.first..leaf.first + left] {
            is_right &= !(1 << (triangle % 32));
        }
        for other in [(axis + 1) % 3, (axis + 2) % 3] {
            let before = self.sorted[other];
            let mut next = [range.start, range.start + left];
            for &triangle in &before[range.clone()] {
                let slot = &mut next[(is_right >> (triangle % 32) & 1) as usize];
                self.sorted[other][*slot % MAX_SMALL] = triangle;
                *slot += 1;
            }
        }
    }
}

/// The number of blocks that a number of triangles fill. The length is a power of two, so that the
/// remainder of an index is one instruction and in bounds.
const BLOCKS: [f32; 2 * MAX_SMALL] = {
    let mut blocks = [0.0; 2 * MAX_SMALL];
    let mut count = 0;
    while count < blocks.len() {
        blocks[count] = count.div_ceil(Costs::TRIANGLES.item_size) as f32;
        count += 1;
    }
    blocks
};

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::build::BuildOptions;
    use crate::build::cluster::clustered_from_branches;
    use crate::test_random::Random;
    use crate::threads::Threads;
    use crate::wide::MeshBvh;

    /// Triangles of edges up to `size`, scattered in a unit cube.
    fn scattered(count: usize, size: f32, random: &mut Random) -> Triangles {
        let mut positions = Vec::new();
        for _ in 0..count {
            let corner = [0; 3].map(|_| random.unit());
            positions.extend([0; 3].map(|_| corner.map(|x| x + size * (random.unit() - 0.5))));
        }
        let indices: Arc<[[u32; 3]]> = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Triangles::new(positions, indices).expect("all indices are in range")
    }

    /// The first triangles of a grid of quads, `width` of them in a row, bent by `place`, which
    /// gets the grid's coordinates.
    fn grid(count: usize, width: u32, place: impl FnMut([f32; 2]) -> [f32; 3]) -> Triangles {
        let rows = count.div_ceil(2 * width as usize) as u32;
        let corners = (0..=rows).flat_map(|y| (0..=width).map(move |x| [x as f32, y as f32]));
        let quads = (0..rows).flat_map(|y| (0..width).map(move |x| y * (width + 1) + x));
        let triangles = quads.flat_map(|a| [[a, a + 1, a + width + 1], [a + 1, a + width + 2, a + width + 1]]);
        let indices: Vec<[u32; 3]> = triangles.take(count).collect();
        Triangles::new(corners.map(place).collect(), indices.into()).expect("all indices are in range")
    }

    /// Boxes of 12 triangles, side by side.
    fn boxes(count: usize, random: &mut Random) -> Triangles {
        const QUADS: [[u32; 4]; 6] =
            [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        let (mut positions, mut indices) = (Vec::new(), Vec::new());
        for number in 0..count as u32 {
            let size = [0; 3].map(|_| 0.1 + random.unit());
            let offset = [1.2 * number as f32, 0.0, 0.0];
            let corner = |i: u32| [0, 1, 2].map(|axis| offset[axis] + size[axis] * (i >> axis & 1) as f32);
            positions.extend((0..8).map(corner));
            let quads = QUADS.map(|quad| quad.map(|i| i + 8 * number));
            indices.extend(quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]));
        }
        Triangles::new(positions, indices.into()).expect("all indices are in range")
    }

    /// Small meshes as games have them.
    fn typical(count: usize, random: &mut Random) -> Vec<(&'static str, Triangles)> {
        let turn = std::f32::consts::TAU;
        vec![
            ("particles", scattered(count, 0.05, random)),
            ("shards", scattered(count, 0.3, random)),
            ("a heap", scattered(count, 1.0, random)),
            ("a strip", grid(count, 1, |[x, y]| [x, y, 0.5 * random.unit()])),
            ("a patch", grid(count, 4, |[x, y]| [x, y, 0.5 * random.unit()])),
            ("a tube", grid(count, 4, |[x, y]| [(x * turn / 4.0).cos(), (x * turn / 4.0).sin(), 0.4 * y])),
            (
                "a ball",
                grid(count, 4, |[x, y]| {
                    let [(sin, cos), (height, radius)] =
                        [x * turn / 4.0, (y / 4.0 - 0.5) * turn / 2.0].map(f32::sin_cos);
                    [cos * radius, sin * radius, height]
                }),
            ),
            ("boxes", boxes((count / 12).max(1), random)),
        ]
    }

    fn clustered(triangles: &Triangles) -> Bvh {
        let options = BuildOptions { max_leaf: 4, node_cost: 4.0, threads: Threads::one(), ..BuildOptions::default() };
        clustered_from_branches(triangles.len(), |triangle| triangles.bounds_of(triangle), &options)
    }

    #[test]
    fn small_trees_keep_the_promises_and_are_no_worse_than_clustered_ones() {
        let mut random = Random(0x5eed_0011);
        for counts in [1..=MAX_ONE_NODE, MAX_ONE_NODE + 1..=MAX_SMALL] {
            let mut sums = [[0.0; 2]; 8];
            for (count, round) in counts.clone().flat_map(|count| (0..25).map(move |round| (count, round))) {
                for (kind, (name, triangles)) in typical(count, &mut random).into_iter().enumerate() {
                    let trees = [build_small(&triangles), clustered(&triangles)];
                    assert_eq!(trees[0].validate(), Ok(()), "{count}, {name}, round {round}");
                    assert_eq!(trees[0].primitive_count(), triangles.len(), "{count}, {name}, round {round}");
                    for (sum, tree) in sums[kind].iter_mut().zip(&trees) {
                        let wide = MeshBvh::new(tree, &triangles);
                        assert_eq!(wide.validate(), Ok(()), "{count}, {name}, round {round}");
                        *sum += wide.cost(1.0, 1.0);
                    }
                }
            }
            let ratios = sums.map(|[small, clustered]| small / clustered);
            println!("{counts:?} triangles: {ratios:.3?} times the cost of clustered trees");
            assert!(ratios.iter().all(|&ratio| ratio < 1.02), "{counts:?}: {ratios:?}");
            assert!(ratios.iter().sum::<f32>() < 0.95 * ratios.len() as f32, "{counts:?}: {ratios:?}");
        }
    }

    #[test]
    fn awkward_triangles_make_valid_trees() {
        type Distortion = fn(f32) -> f32;
        let distortions: [(&str, Distortion); 7] = [
            ("all in one place", |_| 0.25),
            ("huge", |x| (x - 0.5) * 3e38 * 2.0),
            ("tiny", |x| x * 1e-40),
            ("infinite", |x| if x < 0.5 { f32::NEG_INFINITY } else { f32::INFINITY }),
            ("some NaN", |x| if x < 0.1 { f32::NAN } else { x }),
            ("all NaN", |_| f32::NAN),
            ("zeros of both signs", |x| if x < 0.5 { -0.0 } else { 0.0 }),
        ];
        let mut random = Random(0x5eed_0012);
        for count in 0..=MAX_SMALL {
            for (name, distortion) in distortions {
                let whole = scattered(count, 0.5, &mut random);
                let positions = whole.positions().iter().map(|position| position.map(distortion)).collect();
                let triangles = Triangles::new(positions, whole.indices().into()).expect("all indices are in range");
                let tree = build_small(&triangles);
                assert_eq!(tree.validate(), Ok(()), "{count}, {name}");
                let with_point = (0..count as u32).filter(|&triangle| triangles.bounds_of(triangle).has_point());
                let mut primitives = tree.primitives().to_vec();
                primitives.sort_unstable();
                assert!(primitives.iter().copied().eq(with_point), "{count}, {name}");
                assert_eq!(MeshBvh::new(&tree, &triangles).tree().validate(), Ok(()), "{count}, {name}");
            }
        }
    }
}
