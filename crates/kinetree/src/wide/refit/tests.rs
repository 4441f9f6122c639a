use super::super::{RayCost, TriangleBlock};
use super::naive;
use super::plan::{MAX_BLOCKS, MAX_NODES};
use super::*;
use crate::build::{self, BuildOptions, Quality};
use crate::test_random::Random;
use crate::threads::Executor;
use crate::tree::Location;

fn point(size: f32, random: &mut Random) -> [f32; 3] {
    [0; 3].map(|_| random.signed() * size)
}

/// Pairs of triangles that share an edge, in a cube from `-size` to `size`.
fn soup(count: u32, size: f32, random: &mut Random) -> (Vec<[f32; 3]>, Arc<[[u32; 3]]>) {
    let mut positions = Vec::new();
    for _ in 0..count.div_ceil(2) {
        let middle = point(size, random);
        for _ in 0..4 {
            let aside = point(size * 0.03, random);
            positions.push([0, 1, 2].map(|axis| middle[axis] + aside[axis]));
        }
    }
    let of = |i: u32| [[0, 1, 2], [2, 1, 3]][i as usize % 2].map(|corner| i / 2 * 4 + corner);
    (positions, (0..count).map(of).collect())
}

fn tree_of(positions: &[[f32; 3]], indices: &Arc<[[u32; 3]]>, quality: Quality) -> MeshBvh {
    let triangles = Triangles::new(positions.to_vec(), indices.clone()).expect("indices in range");
    let options = BuildOptions { quality, threads: Threads::one(), ..BuildOptions::default() };
    MeshBvh::new(&build::build_triangles(&triangles, &options), &triangles)
}

/// All bits that a refit writes, except the sign of zero: the minimum of two zeros depends on the
/// order of operands.
fn bits(tree: &MeshBvh) -> Vec<u32> {
    let bounds = tree.bounds();
    let planes = tree.tree.nodes.iter().flat_map(|node| node.planes.as_flattened().as_flattened());
    let planes = planes.chain(&bounds.min).chain(&bounds.max).map(|x| (x + 0.0).to_bits());
    let links = tree.tree.nodes.iter().flat_map(|node| node.links.iter().copied());
    let corners = |block: &TriangleBlock| {
        let corners = block.corners.as_flattened().as_flattened().to_vec();
        corners.into_iter().map(f32::to_bits).chain(block.primitives).chain([block.count])
    };
    planes.chain(links).chain(tree.blocks.iter().flat_map(corners)).collect()
}

/// A pool of a given number of threads: joins run the second job on a new thread until they are
/// used up.
struct Pool(std::sync::atomic::AtomicUsize);

impl Executor for Pool {
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
        use std::sync::atomic::Ordering::Relaxed;
        if self.0.fetch_update(Relaxed, Relaxed, |free| free.checked_sub(1)).is_err() {
            one();
            other();
            return;
        }
        std::thread::scope(|scope| {
            scope.spawn(&mut *other);
            one();
        });
        self.0.fetch_add(1, Relaxed);
    }
}

fn pools() -> Vec<Threads> {
    let own = (1..4).map(|more| Threads::of(Arc::new(Pool(more.into()))));
    [Threads::one(), Threads::default()].into_iter().chain(own).collect()
}

fn check(name: &str, tree: &MeshBvh, moved: &Triangles, spare: &mut MeshBvh) {
    let expected = naive::refit(tree, moved);
    assert_eq!(expected.validate(), Ok(()), "{name}");
    let expected_bits = bits(&expected);
    let mut chunks = None;
    for level in Level::available() {
        for threads in pools() {
            tree.refit_into(spare, moved, &threads, level);
            assert_eq!(spare.validate(), Ok(()), "{name}, {level:?}, {threads:?}");
            assert!(bits(spare) == expected_bits, "{name}, {level:?}, {threads:?}: not the boxes of the twin");
            let of = |chunk: &ChunkBounds| (chunk.bounds, chunk.cost.to_bits(), chunk.triangle_boxes.to_bits());
            let sums: Vec<(Aabb, u64, u64)> = spare.chunks.iter().map(of).collect();
            assert_eq!(chunks.get_or_insert_with(|| sums.clone()), &sums, "{name}, {level:?}, {threads:?}");
            check_cost(name, spare.ray_cost(&threads), &expected);
        }
    }
}

/// Compares the cost of the sweep with its definition in double precision. There is a cost if both
/// areas are neither zero nor infinite.
fn check_cost(name: &str, found: Option<RayCost>, tree: &MeshBvh) {
    let half_area = |bounds: &Aabb| {
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from((bounds.max[axis] - bounds.min[axis]).max(0.0)));
        x * y + y * z + z * x
    };
    let triangles = tree.blocks.iter().flat_map(|block| (0..block.count as usize).map(|lane| block.triangle(lane)));
    let crossed = triangles.map(|triangle| half_area(&triangle.bounds())).sum::<f64>() / half_area(&tree.bounds());
    let work = f64::from(tree.cost(Costs::TRIANGLES.node, Costs::TRIANGLES.item));
    let tiny_or_huge = !(1e-30..=1e30).contains(&half_area(&tree.bounds()));
    match found {
        Some(found) => {
            assert!((found.work - work).abs() <= 1e-4 * work, "{name}: {found:?}, not {work}");
            assert!(
                (found.crossed - crossed).abs() <= 1e-4 * crossed || tiny_or_huge,
                "{name}: {found:?}, not {crossed}"
            );
        }
        None => assert!(tiny_or_huge || crossed == 0.0, "{name}: {crossed} and {work} are there to be found"),
    }
}

#[test]
fn a_refit_is_the_slow_one_bit_for_bit() {
    let seed = 0x5eed_0001;
    let mut random = Random(seed);
    for count in [0, 1, 2, 3, 4, 5, 9, 40, 700, 30_000] {
        for (size, quality) in [
            (1.0, Quality::Fast),
            (1e-40, Quality::Fast),
            (1e-18, Quality::Fastest),
            (1e18, Quality::Fast),
            (3e38, Quality::Fast),
            (2.0, Quality::Best),
        ] {
            if count > 700 && size != 1.0 && size != 2.0 {
                continue;
            }
            let (still, indices) = soup(count, size, &mut random);
            let tree = tree_of(&still, &indices, quality);
            let mut spare = tree_of(&still[..still.len().min(4)], &indices[..indices.len().min(2)].into(), quality);
            for bend in [0.0, 0.3] {
                let moved = still.iter().map(|p| [p[0] - p[1] * bend, p[1], p[2] * (1.0 - bend)]).collect();
                let moved = Triangles::new(moved, indices.clone()).expect("indices in range");
                check(
                    &format!("seed {seed}, {count} of size {size:e}, {quality:?}, {bend}"),
                    &tree,
                    &moved,
                    &mut spare,
                );
            }
        }
    }
}

#[test]
fn flat_and_vanishing_triangles_are_refitted_like_others() {
    let seed = 0x5eed_0002;
    let mut random = Random(seed);
    let (still, indices) = soup(900, 1.0, &mut random);
    let tree = tree_of(&still, &indices, Quality::Fast);
    let mut spare = MeshBvh::default();
    type Deform = fn([f32; 3]) -> [f32; 3];
    let all: [(&str, Deform); 4] = [
        ("in one deform", |_| [0.25, -3.0, 7.0]),
        ("at the origin, of either sign", |[x, y, z]| [0.0 * x, 0.0 * y, 0.0 * z]),
        ("flat", |[x, y, _]| [x, y, -1.0]),
        ("on a line", |[x, _, _]| [x, x, x]),
    ];
    for (name, deform) in all {
        let moved = Triangles::new(still.iter().copied().map(deform).collect(), indices.clone()).expect("in range");
        check(&format!("seed {seed}, {name}"), &tree, &moved, &mut spare);
    }
}

#[test]
fn a_tree_of_trees_that_were_refitted_is_right_whatever_the_spare_had_missed() {
    let seed = 0x5eed_0003;
    let mut random = Random(seed);
    let (still, indices) = soup(9000, 1.0, &mut random);
    let mut current = tree_of(&still, &indices, Quality::Fast);
    let mut spares = [MeshBvh::default(), current.clone(), MeshBvh::default()];
    for step in 0..7 {
        let bend = 0.1 * step as f32;
        let moved = still.iter().map(|p| [p[0] - p[2] * bend, p[1] + bend, p[2]]).collect();
        let moved = Triangles::new(moved, indices.clone()).expect("in range");
        let expected = bits(&naive::refit(&current, &moved));
        let spare = &mut spares[step % 3];
        current.refit_into(spare, &moved, &Threads::default(), Level::current());
        assert!(bits(spare) == expected, "seed {seed}, step {step}");
        std::mem::swap(&mut current, spare);
    }
    let kept = current.plan.get().map(Arc::as_ptr);
    assert!(kept.is_some() && spares.iter().all(|spare| spare.plan.get().map(Arc::as_ptr) == kept), "one plan for all");
}

#[test]
fn a_spare_of_another_tree_takes_the_new_shape() {
    let seed = 0x5eed_0004;
    let mut random = Random(seed);
    let (one, one_indices) = soup(3000, 1.0, &mut random);
    let (other, other_indices) = soup(3000, 1.0, &mut random);
    let (one_tree, other_tree) =
        (tree_of(&one, &one_indices, Quality::Fast), tree_of(&other, &other_indices, Quality::Fast));
    let one = Triangles::new(one, one_indices).expect("in range");
    let other = Triangles::new(other, other_indices).expect("in range");
    let mut spare = MeshBvh::default();
    for _ in 0..2 {
        one_tree.refit_into(&mut spare, &one, &Threads::one(), Level::current());
        assert!(bits(&spare) == bits(&naive::refit(&one_tree, &one)), "seed {seed}");
        other_tree.refit_into(&mut spare, &other, &Threads::one(), Level::current());
        assert!(bits(&spare) == bits(&naive::refit(&other_tree, &other)), "seed {seed}");
    }
}

#[test]
fn chunks_cover_the_tree_once_and_none_is_too_large() {
    let seed = 0x5eed_0005;
    let (still, indices) = soup(60_000, 1.0, &mut Random(seed));
    let tree = tree_of(&still, &indices, Quality::Fast);
    let plan = Plan::of(&tree, &Triangles::new(still, indices).expect("in range"));
    assert!(plan.chunks.len() > 8, "{} chunks", plan.chunks.len());
    let mut nodes: Vec<u32> = plan.above.clone();
    let mut blocks = 0;
    for chunk in &plan.chunks {
        assert!(chunk.nodes.len() <= MAX_NODES as usize && chunk.blocks.len() <= MAX_BLOCKS as usize, "{chunk:?}");
        nodes.extend(chunk.nodes.clone());
        blocks += chunk.blocks.len();
        for at in chunk.nodes.clone() {
            for (_, link) in tree.tree.nodes[at as usize].lanes() {
                match link.target() {
                    WideTarget::Node(child) => assert!(chunk.nodes.contains(&child)),
                    WideTarget::Items(items) => {
                        assert!(chunk.blocks.start <= items.start && items.end <= chunk.blocks.end);
                    }
                }
            }
        }
    }
    for &at in &plan.above {
        for (_, link) in tree.tree.nodes[at as usize].lanes() {
            if let WideTarget::Items(items) = link.target() {
                blocks += items.len();
            }
        }
    }
    nodes.sort_unstable();
    assert!(nodes.iter().copied().eq(0..tree.node_count() as u32));
    assert_eq!(blocks, tree.blocks.len());
}

#[test]
fn leaves_that_do_not_stand_in_the_order_of_their_nodes_are_found() {
    let (still, indices) = soup(600, 1.0, &mut Random(0x5eed_0006));
    let mut tree = tree_of(&still, &indices, Quality::Fast);
    assert_eq!(tree.validate(), Ok(()));
    let is_leaf = |node: &WideNode, lane| node.link(lane).is_some_and(|link| link.is_leaf());
    let with_leaves = |node: &WideNode| is_leaf(node, 0) && is_leaf(node, 1);
    let at = tree.tree.nodes.iter().position(with_leaves).expect("a node with two leaves");
    let node = &mut tree.tree.nodes[at];
    node.links.swap(0, 1);
    node.planes.as_flattened_mut().iter_mut().for_each(|row| row.swap(0, 1));
    let violation = tree.validate().expect_err("items changed places");
    assert_eq!((violation.promise, violation.location), (7, Location::Lane { node: at, lane: 0 }));
}
